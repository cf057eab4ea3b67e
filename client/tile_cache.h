#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <osg/Billboard>
#include <osg/Drawable>
#include <osg/Image>
#include <osg/Matrixd>
#include <osg/StateSet>

#include "client/leaf_deformer.h"
#include "common/assets/asset_id.h"
#include "common/base/result.h"
#include "common/geometry/vec.h"
#include "common/scene/osgb_codec.h"
#include "proto/messages.h"

namespace tessera {

/// A leaf that this tile can draw.
struct CachedLeaf {
  osg::ref_ptr<osg::Drawable> drawable;
  osg::ref_ptr<osg::StateSet> state;
  std::uint32_t stateRank = 0;  ///< the same order of states on every tile: leaves are drawn by it
  Mat4 localToWorld;
  Vec3 center;
  Mat4 recordToWorld;                   ///< as its record has it, from which steps of poses count
  Vec3 localCenter;                     ///< of its record's sphere
  osg::ref_ptr<LeafDeformer> deformer;  ///< of a leaf that has had a shape; `drawable` is then its geometry
  osg::ref_ptr<osg::Billboard> billboard;  ///< computes the turn; null for most
  osg::Vec3d billboardPosition;
};

/// The assets and leaves that this tile was sent, and nothing else of the scene.
class TileCache {
 public:
  /// `decodes`: false keeps no OSG objects (a tile that draws nothing), but checks everything all the same.
  explicit TileCache(bool decodes) : decodes_(decodes) {}

  /// Refuses an asset whose bytes do not have the hash that names it.
  [[nodiscard]] Status add(const proto::Assets& message);
  /// Refuses a leaf out of range or whose assets are not here.
  [[nodiscard]] Status add(const proto::Leaves& message, std::uint32_t leafCount);

  /// Refuses a pose of a leaf that is not here, that leads too far, or that does not fit its drawable.
  [[nodiscard]] Status add(const proto::Poses& message);

  /// Null: not here.
  [[nodiscard]] const CachedLeaf* find(std::uint32_t leaf) const;
  [[nodiscard]] bool has(std::uint32_t leaf) const { return leaves_.contains(leaf); }
  [[nodiscard]] std::size_t leafCount() const { return leaves_.size(); }
  [[nodiscard]] std::size_t assetCount() const { return drawables_.size() + states_.size() + images_.size(); }

 private:
  [[nodiscard]] Status place(CachedLeaf& leaf, const proto::Pose& pose) const;
  [[nodiscard]] Status addAsset(const proto::Asset& asset);
  [[nodiscard]] Result<osg::ref_ptr<osg::Object>> decode(proto::AssetKind kind, std::string_view bytes) const;

  bool decodes_;
  OsgbCodec codec_;
  std::unordered_map<AssetId, osg::ref_ptr<osg::Drawable>, AssetIdHash> drawables_;
  std::unordered_map<AssetId, osg::ref_ptr<osg::StateSet>, AssetIdHash> states_;
  std::unordered_map<std::string, osg::ref_ptr<osg::Image>> images_;
  std::unordered_map<std::uint32_t, CachedLeaf> leaves_;
};

}  // namespace tessera
