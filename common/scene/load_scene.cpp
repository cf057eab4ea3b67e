#include "common/scene/load_scene.h"

#include <algorithm>
#include <cctype>

#include "common/scene/extract.h"
#include "common/scene/gltf/import_gltf.h"
#include "common/scene/import_graph.h"
#include "common/scene/osg_import.h"
#include "common/scene/reorganize.h"

namespace tessera {

namespace {

std::string lowerExtension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

}  // namespace

bool isGltfFile(const std::filesystem::path& path) {
  const std::string extension = lowerExtension(path);
  return extension == ".gltf" || extension == ".glb";
}

Result<ImportedGraph> importGraph(const std::filesystem::path& path, UpAxis up) {
  if (isGltfFile(path)) return importGltf(path);
  return importOsg(path, up == UpAxis::Auto ? lowerExtension(path) != ".ac" : up == UpAxis::Z);
}

Result<Scene> loadScene(const std::filesystem::path& path, const LoadOptions& options) {
  auto graph = importGraph(path, options.up);
  if (!graph) return graph.error();
  auto scene = extractScene(std::move(*graph), path.string(), isGltfFile(path), options.maxTrianglesPerLeaf);
  if (scene) reorganize(*scene, options.hierarchy, options.maxTrianglesPerLeaf);
  return scene;
}

Result<Scene> loadScene(const std::filesystem::path& path, UpAxis up) {
  return loadScene(path, LoadOptions{.up = up});
}

}  // namespace tessera
