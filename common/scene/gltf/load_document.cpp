#include "common/scene/gltf/load_document.h"

#include <cstdint>
#include <cstring>
#include <exception>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "common/base/file.h"
#include "common/scene/gltf/check_json.h"

namespace tessera::gltf {

namespace {

namespace fs = std::filesystem;

/// tinygltf and GLB itself count bytes in 32 bits.
constexpr std::uintmax_t kMaxFileBytes = UINT32_MAX;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr const char* kExportAgain = "export it again, or check that it was copied whole";

/// What the callbacks of tinygltf work with and leave behind.
struct FileAccess {
  fs::path folder;
  const JsonFacts* facts = nullptr;
  std::map<std::string, std::string> imageFaults;  ///< by uri as written
  std::optional<Error> bufferFault;
  std::set<fs::path> files;  ///< that were looked for
};

/// Empty when the decoded uri names a file in the scene's folder, else why not.
std::string faultOfUri(const std::string& uri) {
  const std::size_t colon = uri.find(':');
  if (colon != std::string::npos && uri.find('/') > colon) {
    return "is not a file of its folder (only plain relative paths are read)";
  }
  if (uri.find('\0') != std::string::npos) return "holds a NUL character";
  const fs::path path = fs::path(uri).lexically_normal();
  if (path.is_absolute() || uri.starts_with('\\')) return "is an absolute path";
  if (path.empty() || *path.begin() == "..") return "leads out of the scene's folder";
  return {};
}

Result<std::string> readNamedFile(FileAccess& access, const NamedFile& file) {
  const std::string fault = faultOfUri(file.path);
  const std::string what =
      std::string(file.isBuffer ? "buffer" : "image") + " \"" + file.path.substr(0, 200) + "\"";
  if (!fault.empty()) return inputError({}, what + " " + fault, "put the file beside the scene");
  const fs::path path = access.folder / file.path;
  access.files.insert(path);
  Result<std::string> bytes = readFile(path, kMaxFileBytes);
  if (!bytes)
    return inputError({}, what + ": " + path.string() + ": " + bytes.error().what, bytes.error().mend);
  if (!file.isBuffer) return bytes;
  if (bytes->size() < file.byteLength) {
    return inputError({},
                      what + " has " + std::to_string(bytes->size()) + " bytes of the " +
                          std::to_string(file.byteLength) + " that the scene declares",
                      kExportAgain);
  }
  bytes->resize(file.byteLength);  // tinygltf refuses a file that is longer, which glTF allows
  return bytes;
}

bool fileExists(const std::string&, void*) {
  return true;
}
std::string expandPath(const std::string& path, void*) {
  return path;
}
bool writeFile(std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
  return false;
}

bool readWholeFile(std::vector<unsigned char>* out, std::string*, const std::string& name, void* user) {
  FileAccess& access = *static_cast<FileAccess*>(user);
  const auto found = access.facts->files.find(name);
  const NamedFile file = found != access.facts->files.end() ? found->second : NamedFile{name, name, 0, false};
  const Result<std::string> bytes = readNamedFile(access, file);
  if (bytes) {
    out->assign(bytes->begin(), bytes->end());
    return true;
  }
  if (file.isBuffer) access.bufferFault = bytes.error();
  access.imageFaults[file.written] = bytes.error().what;
  return false;
}

/// Keeps the bytes of image files for later. Those in buffer views are handed over unchecked by tinygltf and
/// may lie outside their buffer, so nothing is read here.
bool keepImageBytes(tinygltf::Image* image, int, std::string*, std::string*, int, int,
                    const unsigned char* bytes, int size, void*) {
  if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
  return true;
}

std::uint32_t wordAt(std::string_view bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

/// The JSON of a GLB whose chunks lie inside the file; tinygltf itself reads up to 8 bytes past a cut one.
Result<std::string_view> jsonOfGlb(std::string_view bytes) {
  constexpr std::size_t kHeader = 12;
  constexpr std::size_t kChunkHeader = 8;
  if (bytes.size() < kHeader + kChunkHeader)
    return inputError({}, "is cut off in its GLB header", kExportAgain);
  if (wordAt(bytes, 4) != 2) {
    return inputError({}, "is GLB version " + std::to_string(wordAt(bytes, 4)) + ", only 2 is supported",
                      "export it as glTF 2.0");
  }
  const std::uint64_t length = wordAt(bytes, 8);
  if (length > bytes.size()) {
    return inputError(
        {}, "is cut off: " + std::to_string(bytes.size()) + " of " + std::to_string(length) + " bytes",
        kExportAgain);
  }
  const std::uint64_t jsonLength = wordAt(bytes, kHeader);
  const std::uint64_t jsonEnd = kHeader + kChunkHeader + jsonLength;
  if (wordAt(bytes, kHeader + 4) != kJsonChunk || jsonEnd > length) {
    return inputError({}, "has a damaged GLB header (JSON chunk)", kExportAgain);
  }
  if (jsonEnd < length) {
    if (jsonEnd + kChunkHeader > length || jsonEnd + kChunkHeader + wordAt(bytes, jsonEnd) > length) {
      return inputError({}, "has a damaged GLB header (binary chunk)", kExportAgain);
    }
  }
  return bytes.substr(kHeader + kChunkHeader, jsonLength);
}

/// The first line of tinygltf's complaints that matters. It also says yes after leaving out a part that it
/// could not read, and complains of skins and animations that are in order, of which nothing is drawn anyway.
std::string seriousFault(const std::string& faults) {
  std::istringstream lines(faults);
  for (std::string line; std::getline(lines, line);) {
    const bool isHarmless = line.empty() || line.find("Skin") != std::string::npos ||
                            line.find("nimation") != std::string::npos ||
                            line.find("'node' property is missing") != std::string::npos ||
                            line.find("aligned to a 4-byte boundary") != std::string::npos;
    if (isHarmless) continue;
    while (line.ends_with('.') || line.ends_with(' '))
      line.pop_back();
    return line.substr(0, 300);
  }
  return {};
}

Result<tinygltf::Model> parse(const std::string& bytes, bool isBinary, FileAccess& access) {
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks({fileExists, expandPath, readWholeFile, writeFile, &access});
  loader.SetImageLoader(keepImageBytes, nullptr);
  tinygltf::Model model;
  std::string fault;
  std::string ignored;
  const auto size = static_cast<unsigned int>(bytes.size());
  bool ok = false;
  try {
    ok = isBinary
             ? loader.LoadBinaryFromMemory(&model, &fault, &ignored,
                                           reinterpret_cast<const unsigned char*>(bytes.data()), size, "")
             : loader.LoadASCIIFromString(&model, &fault, &ignored, bytes.data(), size, "");
  } catch (const std::exception& e) {  // whatever nlohmann-json or a vector throws inside tinygltf
    ok = false;
    fault = e.what();
  }
  if (access.bufferFault) return *access.bufferFault;
  std::string serious = seriousFault(fault);
  if (!ok && serious.empty()) serious = fault.empty() ? "a part of it cannot be read" : fault.substr(0, 300);
  if (!serious.empty()) return inputError({}, "is not valid glTF: " + serious, kExportAgain);
  return model;
}

}  // namespace

Result<Document> loadDocument(const fs::path& path) {
  Result<std::string> bytes = readFile(path, kMaxFileBytes);
  if (!bytes) return bytes.error();
  const bool isBinary = bytes->starts_with("glTF");
  const Result<std::string_view> json = isBinary ? jsonOfGlb(*bytes) : std::string_view(*bytes);
  if (!json) return json.error();
  Result<JsonFacts> facts = checkJson(*json);
  if (!facts) return facts.error();

  FileAccess access{path.parent_path(), &*facts, {}, std::nullopt, {}};
  Result<tinygltf::Model> model = parse(*bytes, isBinary, access);
  if (!model) return model.error();
  Document document;
  document.model = std::move(*model);
  document.extensionsUsed = std::move(facts->extensionsUsed);
  document.imageFaults = std::move(access.imageFaults);
  document.files = std::move(access.files);
  return document;
}

}  // namespace tessera::gltf
