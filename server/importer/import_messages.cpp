#include "server/importer/import_messages.h"

namespace tessera {

namespace {
using Json = nlohmann::json;

// Paths may hold any bytes; JSON's text must be UTF-8.
std::string hex(const std::string& bytes) {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (const char c : bytes) {
    text += digits[static_cast<unsigned char>(c) >> 4];
    text += digits[static_cast<unsigned char>(c) & 15];
  }
  return text;
}

std::string unhex(const std::string& text) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2)
    bytes += static_cast<char>(std::stoi(text.substr(i, 2), nullptr, 16));
  return bytes;
}

}  // namespace

std::string orderText(const ImportOrder& order) {
  return Json{{"scene", hex(order.job.scene.string())},
              {"up", static_cast<int>(order.job.up)},
              {"hierarchy", static_cast<int>(order.job.hierarchy)},
              {"mtpl", order.job.maxTrianglesPerLeaf},
              {"store", hex(order.store.string())},
              {"entry", order.entry},
              {"sha256", order.sceneSha256},
              {"memory", order.memoryBytes}}
             .dump() +
         "\n";
}

std::optional<ImportOrder> orderFrom(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  try {
    return ImportOrder{.job = {.scene = unhex(json.at("scene").get<std::string>()),
                               .up = static_cast<UpAxis>(json.at("up").get<int>()),
                               .hierarchy = static_cast<HierarchyKind>(json.at("hierarchy").get<int>()),
                               .maxTrianglesPerLeaf = json.at("mtpl").get<std::uint64_t>()},
                       .store = unhex(json.at("store").get<std::string>()),
                       .entry = json.at("entry").get<std::string>(),
                       .sceneSha256 = json.at("sha256").get<std::string>(),
                       .memoryBytes = json.at("memory").get<std::uint64_t>()};
  } catch (const std::exception&) {
    return {};
  }
}

Json errorJson(const Error& error) {
  return {{"error", error.what},
          {"where", error.where},
          {"mend", error.mend},
          {"input", error.kind == ErrorKind::Input}};
}

std::optional<Error> errorFrom(const Json& answer) {
  try {
    return Error{answer.at("input").get<bool>() ? ErrorKind::Input : ErrorKind::Runtime,
                 answer.at("where").get<std::string>(), answer.at("error").get<std::string>(),
                 answer.at("mend").get<std::string>()};
  } catch (const Json::exception&) {
    return {};
  }
}

}  // namespace tessera
