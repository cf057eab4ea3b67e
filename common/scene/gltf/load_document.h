#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <tiny_gltf.h>

#include "common/base/result.h"

namespace tessera::gltf {

/// A parsed file with its buffers in memory. Images are not decoded yet: `model.images[i].image` holds the
/// bytes of the image file, or nothing where they lie in a buffer view or could not be had. Indices between
/// the parts of `model` have not been checked.
struct Document {
  tinygltf::Model model;
  std::vector<std::string> extensionsUsed;
  std::map<std::string, std::string> imageFaults;  ///< by uri as written: why its file could not be had
  std::set<std::filesystem::path> files;           ///< that it names, read or looked for
};

/// Reads and parses the file and the files that it names, which must lie in its own folder or below.
[[nodiscard]] Result<Document> loadDocument(const std::filesystem::path& path);

}  // namespace tessera::gltf
