#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "common/assets/asset_id.h"

namespace tessera {

/// An immutable piece of a scene: a drawable without its state, a state set whose images are named by their
/// ids, or an image; each serialized in OpenSceneGraph's osgb format. Values go on the wire and never change.
enum class AssetKind : std::uint8_t { Drawable = 0, State = 1, Image = 2 };

/// An asset must fit into one message to a tile.
inline constexpr std::size_t kMaxAssetBytes = std::size_t{255} << 20;

/// What is known of an asset without its bytes.
struct AssetRow {
  AssetId id;
  std::uint32_t bytes = 0;
  std::uint32_t needsBegin = 0, needsCount = 0;  ///< of AssetTable's needs
  AssetKind kind = AssetKind::Drawable;
  std::uint8_t unused[3] = {0, 0, 0};
};

using AssetBytes = std::shared_ptr<const std::string>;

}  // namespace tessera
