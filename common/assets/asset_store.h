#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/assets/asset_id.h"

namespace tessera {

/// Values go on the wire and never change.
enum class AssetKind : std::uint8_t { Drawable = 0, State = 1, Image = 2 };

/// An asset must fit into one message to a tile.
inline constexpr std::size_t kMaxAssetBytes = std::size_t{255} << 20;

/// An immutable piece of a scene: a drawable without its state, a state set whose images are named by their
/// ids, or an image; each serialized in OpenSceneGraph's osgb format.
struct Asset {
  AssetKind kind = AssetKind::Drawable;
  std::string bytes;
  std::vector<AssetId> needs;  ///< assets without which this one cannot be used: the images of a state set
};

/// Content-addressed assets in memory. Filled by one thread; immutable and free to read by many after that.
class AssetStore {
 public:
  /// Adds the asset unless it is there already. Returns its id.
  AssetId add(Asset asset);
  /// Null where there is none of that name.
  [[nodiscard]] const Asset* find(const AssetId& id) const;
  [[nodiscard]] std::size_t size() const { return assets_.size(); }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  std::unordered_map<AssetId, Asset, AssetIdHash> assets_;
  std::uint64_t bytes_ = 0;
};

}  // namespace tessera
