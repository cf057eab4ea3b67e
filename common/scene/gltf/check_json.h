#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

namespace tessera::gltf {

/// A file that the JSON refers to.
struct NamedFile {
  std::string written;           ///< the uri as the JSON has it
  std::string path;              ///< the same, percent-decoded
  std::uint64_t byteLength = 0;  ///< declared length of a buffer; 0 for an image
  bool isBuffer = false;
};

/// What must be known of the JSON before tinygltf may see it.
struct JsonFacts {
  std::vector<std::string> extensionsUsed;
  std::vector<std::string> extensionsRequired;
  /// By the name under which tinygltf will ask for the file.
  std::map<std::string, NamedFile> files;
};

/// Walks the JSON once without building it and refuses what tinygltf would crash on (nesting), silently take
/// for something else (negative, fractional or 64-bit indices and offsets, wrong types), or not explain (an
/// older glTF version, a required extension that is not supported). The error has no `where`.
[[nodiscard]] Result<JsonFacts> checkJson(std::string_view json);

}  // namespace tessera::gltf
