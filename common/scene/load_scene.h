#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>

#include "common/assets/asset_table.h"
#include "common/base/result.h"
#include "common/hierarchy/spatial_hierarchy.h"
#include "common/scene/scene.h"

namespace tessera {

/// Which way is up in a scene file.
enum class UpAxis { Auto, Y, Z };

struct LoadOptions {
  UpAxis up = UpAxis::Auto;
  /// How leaves are grouped: as in the file's graph, or by their places (spatial_hierarchy.h).
  HierarchyKind hierarchy = HierarchyKind::Graph;
  /// Larger meshes are cut into several leaves; spatial hierarchies group smaller ones. 0: neither.
  std::uint64_t maxTrianglesPerLeaf = 0;
  /// Where the bytes of the assets go; null: into memory.
  std::shared_ptr<AssetKeeper> keeper = {};
  /// Told the share of the work that is done, 0 to 1; may be empty.
  std::function<void(double share)> progress = {};
};

/// A scene and what it was made of.
struct LoadedScene {
  Scene scene;
  std::set<std::filesystem::path> files;  ///< looked for beside the one named, there or not
};

/// Loads a scene: glTF 2.0 (.gltf, .glb) or anything that OpenSceneGraph reads. The world is y up: glTF is so
/// by definition, and AC3D, whose reader leaves it so; the other formats are z up by OpenSceneGraph's
/// convention and are turned by -90 degrees about x (said in the warnings). `options.up` overrides that for
/// formats other than glTF.
///
/// Refused: a missing or malformed file, NaN or infinity in vertices or matrices, a scene with nothing to
/// draw. Stock OpenSceneGraph readers can crash on malformed files of some formats, and this process with
/// them.
[[nodiscard]] Result<Scene> loadScene(const std::filesystem::path& path, const LoadOptions& options);
[[nodiscard]] Result<Scene> loadScene(const std::filesystem::path& path, UpAxis up = UpAxis::Auto);
[[nodiscard]] Result<LoadedScene> loadSceneWithFiles(const std::filesystem::path& path,
                                                     const LoadOptions& options);

}  // namespace tessera
