#include "common/wall/import/wall_import.h"

#include <algorithm>
#include <fstream>

#include <pugixml.hpp>

#include "common/base/file.h"
#include "common/wall/import/formats.h"
#include "common/wall/import/mpcdi_wall.h"
#include "common/wall/mpcdi/mpcdi.h"

namespace tessera {

namespace {

constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 20;
constexpr const char* kKnown =
    "known are Equalizer .eqc, Tide, DisplayCluster and SGCT files and MPCDI archives";

std::string lineOf(std::string_view text, std::ptrdiff_t offset) {
  const std::size_t end =
      std::min(text.size(), static_cast<std::size_t>(std::max<std::ptrdiff_t>(offset, 0)));
  return std::to_string(1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
}

Result<ImportedWall> importXml(std::string_view text, const std::string& fileName) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(
      text.data(), text.size(), pugi::parse_default | pugi::parse_doctype, pugi::encoding_utf8);
  if (!parsed) {
    return inputError(fileName + ':' + lineOf(text, parsed.offset),
                      std::string("is no XML: ") + parsed.description());
  }
  for (const pugi::xml_node& node : document.children()) {
    if (node.type() == pugi::node_doctype) {
      return inputError(fileName + ':' + lineOf(text, node.offset_debug()),
                        "holds a document type, which may define entities", "remove the <!DOCTYPE ...>");
    }
  }
  const std::string root = document.document_element().name();
  if (root == "configuration") return importDisplayCluster(document, text, fileName);
  if (root == "Cluster") {
    return inputError(fileName, "is an SGCT file of the old XML format, which is not read",
                      "convert it to SGCT's JSON format");
  }
  if (root == "MPCDI") {
    return inputError(fileName, "is the description inside an MPCDI archive",
                      "give the whole .mpcdi archive");
  }
  return inputError(fileName, "is XML, but describes no wall in a known format", kKnown);
}

Result<ImportedWall> importJson(std::string_view text, const std::string& fileName) {
  const Result<JsonDocument> document = JsonDocument::parse(text, fileName);
  if (!document) return document.error();
  const JsonValue root = document->root();
  if (root.find("surfaces")) return importTide(*document, fileName);
  if (root.find("nodes")) return importSgct(*document, fileName);
  if (root.find("grid") || root.find("screens") || root.find("columns")) {
    return inputError(fileName, "is a wall file already", "use it as it is");
  }
  return inputError(fileName, "is JSON, but describes no wall in a known format", kKnown);
}

}  // namespace

std::string wallNameOf(const std::string& fileName) {
  std::string stem = std::filesystem::path(fileName).stem().string();
  return stem.empty() ? "wall" : stem;
}

Result<ImportedWall> importWallText(std::string_view text, const std::string& fileName) {
  if (text.size() > kMaxFileBytes) {
    return inputError(fileName, "is larger than " + std::to_string(kMaxFileBytes) + " bytes",
                      "is it the right file?");
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return inputError(fileName, "the file is empty", kKnown);
  const std::size_t nul = text.find('\0');
  if (nul != std::string_view::npos) {
    return inputError(fileName + ':' + lineOf(text, static_cast<std::ptrdiff_t>(nul)),
                      "the text holds a NUL byte", kKnown);
  }
  const std::string_view rest = text.substr(first);
  if (rest.starts_with('<')) return importXml(text, fileName);
  if (rest.starts_with('{') || rest.starts_with('[') || rest.starts_with("//") || rest.starts_with("/*")) {
    return importJson(text, fileName);
  }
  for (const std::string_view word : {"#", "server", "global", "config"}) {
    if (rest.starts_with(word)) return importEqualizer(text, fileName);
  }
  return inputError(fileName, "describes no wall in a known format", kKnown);
}

Result<ImportedWall> importWall(const std::filesystem::path& path) {
  {
    std::ifstream in(path, std::ios::binary);
    char magic[2] = {0, 0};
    if (in.read(magic, 2) && magic[0] == 'P' && magic[1] == 'K') {
      const Result<Mpcdi> mpcdi = readMpcdi(path);
      if (!mpcdi) return mpcdi.error();
      return wallOfMpcdi(*mpcdi, path.string());
    }
  }
  const Result<std::string> text = readFile(path, kMaxFileBytes);
  if (!text) return text.error();
  return importWallText(*text, path.string());
}

}  // namespace tessera
