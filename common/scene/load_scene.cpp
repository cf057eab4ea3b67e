#include "common/scene/load_scene.h"

#include <algorithm>
#include <cctype>
#include <new>

#include "common/scene/extract.h"
#include "common/scene/gltf/import_gltf.h"
#include "common/scene/import_graph.h"
#include "common/scene/osg_import.h"
#include "common/scene/reorganize.h"
#include "common/scene/scene_motion.h"

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

namespace {

Result<LoadedScene> load(const std::filesystem::path& path, const LoadOptions& options) {
  // Reading a file takes about as long as making assets of what was read.
  const auto tell = [&](double share) {
    if (options.progress) options.progress(share);
  };
  auto graph = importGraph(path, options.up);
  if (!graph) return graph.error();
  tell(0.5);
  LoadedScene loaded;
  loaded.files = std::move(graph->files);
  auto scene = extractScene(std::move(*graph), {.source = path.string(),
                                                .isGltf = isGltfFile(path),
                                                .maxTrianglesPerLeaf = options.maxTrianglesPerLeaf,
                                                .keeper = options.keeper,
                                                .progress = [&](double share) { tell(0.5 + 0.45 * share); }});
  if (!scene) return scene.error();
  // What moves must have its terminal node to itself.
  reorganize(*scene, options.hierarchy, scene->motion.empty() ? options.maxTrianglesPerLeaf : 0);
  if (Status status = hideAsLoaded(*scene); !status) return status.error();
  tell(1);
  loaded.scene = std::move(*scene);
  return loaded;
}

}  // namespace

Result<LoadedScene> loadSceneWithFiles(const std::filesystem::path& path, const LoadOptions& options) {
  try {
    return load(path, options);
  } catch (const std::bad_alloc&) {
    return runtimeError(path.string(), "needs more memory than there is",
                        "import it on a larger machine, or split it");
  }
}

Result<Scene> loadScene(const std::filesystem::path& path, const LoadOptions& options) {
  auto loaded = loadSceneWithFiles(path, options);
  if (!loaded) return loaded.error();
  return std::move(loaded->scene);
}

Result<Scene> loadScene(const std::filesystem::path& path, UpAxis up) {
  LoadOptions options;
  options.up = up;
  return loadScene(path, options);
}

}  // namespace tessera
