#include "common/scene/load_scene.h"

#include <algorithm>
#include <cctype>

#include "common/scene/extract.h"
#include "common/scene/gltf/import_gltf.h"
#include "common/scene/osg_import.h"
#include "common/scene/reorganize.h"

namespace tessera {

Result<Scene> loadScene(const std::filesystem::path& path, const LoadOptions& options) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool isGltf = extension == ".gltf" || extension == ".glb";
  const bool isZUp = options.up == UpAxis::Auto ? extension != ".ac" : options.up == UpAxis::Z;
  auto graph = isGltf ? importGltf(path) : importOsg(path, isZUp);
  if (!graph) return graph.error();
  auto scene = extractScene(std::move(*graph), path.string(), isGltf, options.maxTrianglesPerLeaf);
  if (scene) reorganize(*scene, options.hierarchy, options.maxTrianglesPerLeaf);
  return scene;
}

Result<Scene> loadScene(const std::filesystem::path& path, UpAxis up) {
  return loadScene(path, LoadOptions{.up = up});
}

}  // namespace tessera
