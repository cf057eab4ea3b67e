#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "common/assets/stored_asset.h"
#include "common/base/column.h"
#include "common/base/result.h"
#include "common/scene/scene.h"

namespace tessera {

/// A file that went into a scene beside the one that was named: a buffer, an image, a material library.
struct SceneDependency {
  std::string path;    ///< absolute
  std::string sha256;  ///< of its content, in hex; empty: it was looked for and is not there
};

/// What an import leaves in the store: the scene without the bytes of its assets, and where those lie.
struct IndexedScene {
  Scene scene;
  Column<StoredAsset> places;  ///< by number of the asset
  std::vector<SceneDependency> dependencies;
};

/// Changes whenever an index written before cannot be read, or would not be what an import makes now.
inline constexpr int kSceneIndexVersion = 2;

[[nodiscard]] std::string encodeSceneIndex(const Scene& scene, const Column<StoredAsset>& places,
                                           const std::vector<SceneDependency>& dependencies);

/// The scene in place: its arrays are those of `bytes`, which live as long as `keeper`. Its assets have no
/// bytes yet. An error: written by another build.
[[nodiscard]] Result<IndexedScene> openSceneIndex(std::span<std::byte> bytes,
                                                  std::shared_ptr<const void> keeper);

}  // namespace tessera
