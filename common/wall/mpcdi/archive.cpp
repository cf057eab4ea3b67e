#include "common/wall/mpcdi/archive.h"

#include <algorithm>

#include <zip.h>

#include "common/base/file.h"
#include "common/wall/mpcdi/mpcdi.h"

namespace tessera {

namespace {

bool leadsOut(const std::string& name) {
  if (name.empty() || name.size() > 255 || name.front() == '/' || name.find('\\') != std::string::npos)
    return true;
  if (std::any_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }))
    return true;
  return ("/" + name + "/").find("/../") != std::string::npos;
}

}  // namespace

void Archive::Close::operator()(void* zip) const {
  zip_discard(static_cast<zip_t*>(zip));
}

Result<Archive> Archive::open(const std::filesystem::path& path) {
  Archive archive(path.string());
  std::error_code ec;
  if (!std::filesystem::is_regular_file(path, ec)) {
    return inputError(archive.path_, "is no file that can be read", "check the path");
  }
  int code = 0;
  archive.zip_.reset(zip_open(path.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, &code));
  if (!archive.zip_) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string reason = zip_error_strerror(&error);
    zip_error_fini(&error);
    return inputError(archive.path_, "is no sound zip archive: " + reason, "is the file complete?");
  }
  const zip_int64_t count = zip_get_num_entries(static_cast<zip_t*>(archive.zip_.get()), 0);
  if (count > static_cast<zip_int64_t>(kMaxMpcdiEntries)) {
    return inputError(archive.path_, "holds more than " + std::to_string(kMaxMpcdiEntries) + " files",
                      "is it the right file?");
  }
  return archive;
}

std::string Archive::place(const std::string& name) const {
  return path_ + '(' + name.substr(0, 255) + ')';
}

std::string Archive::find(const std::string& name) const {
  zip_t* zip = static_cast<zip_t*>(zip_.get());
  if (leadsOut(name)) return {};
  zip_int64_t index = zip_name_locate(zip, name.c_str(), 0);
  if (index < 0) index = zip_name_locate(zip, name.c_str(), ZIP_FL_NOCASE);
  if (index < 0) return {};
  const char* found = zip_get_name(zip, static_cast<zip_uint64_t>(index), 0);
  return found ? found : "";
}

Result<std::string> Archive::read(const std::string& name, std::int64_t limitBytes) const {
  zip_t* zip = static_cast<zip_t*>(zip_.get());
  const auto fail = [&](std::string what, std::string mend = {}) {
    return inputError(place(name), std::move(what), std::move(mend));
  };
  if (leadsOut(name)) return fail("is no name of a file in the archive", "use plain relative names");
  const std::string entry = find(name);
  if (entry.empty()) return fail("the archive has no such file");
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_stat(zip, entry.c_str(), 0, &stat) != 0) return fail(zip_strerror(zip));
  const std::string tooLarge = "holds more than " + std::to_string(limitBytes) + " bytes";
  if ((stat.valid & ZIP_STAT_SIZE) != 0 && stat.size > static_cast<zip_uint64_t>(limitBytes))
    return fail(tooLarge);
  zip_file_t* file = zip_fopen(zip, entry.c_str(), 0);
  if (!file) return fail(std::string("cannot be unpacked: ") + zip_strerror(zip));
  // What an archive claims of a file's size is not believed: memory grows with what really comes out.
  std::string bytes;
  char block[1 << 16];
  zip_int64_t count = 0;
  while ((count = zip_fread(file, block, sizeof block)) > 0) {
    if (static_cast<std::int64_t>(bytes.size()) + count > limitBytes) {
      zip_fclose(file);
      return fail(tooLarge);
    }
    bytes.append(block, static_cast<std::size_t>(count));
  }
  const std::string reason = count < 0 ? zip_file_strerror(file) : "";
  if (zip_fclose(file) != 0 || count < 0) {
    return fail("is damaged" + (reason.empty() ? "" : ": " + reason), "is the archive complete?");
  }
  return bytes;
}

}  // namespace tessera
