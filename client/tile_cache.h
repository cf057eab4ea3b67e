#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include <osg/Billboard>
#include <osg/Drawable>
#include <osg/Geometry>
#include <osg/Image>
#include <osg/Matrixd>
#include <osg/StateSet>

#include "client/leaf_deformer.h"
#include "common/assets/disk_store.h"
#include "common/assets/leaf_cache.h"
#include "common/base/result.h"
#include "common/geometry/vec.h"
#include "common/scene/osgb_codec.h"
#include "proto/messages.h"

namespace tessera {

/// A leaf whose record this tile has. What draws it may still be missing.
struct CachedLeaf {
  AssetId drawableId, stateId;
  osg::ref_ptr<osg::Drawable> drawable;  ///< null: not here yet
  osg::ref_ptr<osg::StateSet> state;     ///< likewise
  std::uint32_t stateRank = 0;           ///< the same order of states on every tile: leaves are drawn by it
  Mat4 localToWorld;
  Vec3 center;
  std::array<Vec3, 3> halfAxes;  ///< of its box about `boxCenter`, world space
  Vec3 boxCenter;
  std::array<float, 3> meanRgb;
  osg::ref_ptr<osg::Geometry> box;      ///< what stands for it, once that was needed
  Mat4 recordToWorld;                   ///< as its record has it, from which steps of poses count
  Vec3 localCenter;                     ///< of its record's sphere
  osg::ref_ptr<LeafDeformer> deformer;  ///< of a leaf that has had a shape; `drawable` is then its geometry
  std::vector<float> joints, weights;   ///< of a shape that came before the drawable
  osg::ref_ptr<osg::Billboard> billboard;  ///< computes the turn; null for most
  osg::Vec3d billboardPosition;
  [[nodiscard]] bool canBeDrawn() const { return drawable && state; }
};

/// The assets and leaves that this tile was sent and keeps, and nothing else of the scene. What is dropped
/// when the budget is spent, LeafCache decides, as the master's mirror does. With a store on disk, assets are
/// written there as they come, and taken from there when the master says that they are there.
class TileCache {
 public:
  struct Options {
    bool decodes = true;  ///< false keeps no OSG objects (a tile that draws nothing), but checks everything
    std::uint64_t budgetBytes = LeafCache::kNoBudget;
    std::shared_ptr<DiskStore> disk = nullptr;  ///< null: none
  };
  explicit TileCache(Options options);

  /// Most time that prepare() takes; 0, which is so at first: what comes is made drawable at once.
  void setUploadMs(float ms) { uploadMs_ = ms; }

  /// Refuses an asset whose bytes do not have the hash that names it.
  [[nodiscard]] Status add(const proto::Assets& message);
  /// Refuses a leaf out of range.
  [[nodiscard]] Status add(const proto::Leaves& message, std::uint32_t leafCount);
  /// Refuses a pose of a leaf that is not here, that leads too far, or that does not fit its drawable.
  [[nodiscard]] Status add(const proto::Poses& message);
  [[nodiscard]] Status keep(const proto::Keep& message, std::uint32_t leafCount);

  /// Makes drawable what has come, in its order, until the time is up; at least one asset.
  [[nodiscard]] Status prepare();
  /// Leaves that come into the list or leave it; then drops what does not fit the budget.
  void show(const VisibleList& toggled);
  /// Assets that are not on the disk after all, since the last call.
  [[nodiscard]] std::vector<proto::Sha256> takeLacked() { return std::exchange(lacked_, {}); }

  /// Null: no record is here. `canBeDrawn` is as of now.
  [[nodiscard]] CachedLeaf* find(std::uint32_t leaf);
  [[nodiscard]] bool has(std::uint32_t leaf) const { return leaves_.contains(leaf); }
  /// Whether the leaf and its assets are here, and drawable where this tile draws.
  [[nodiscard]] bool isComplete(std::uint32_t leaf) const;
  [[nodiscard]] std::size_t leafCount() const { return leaves_.size(); }
  [[nodiscard]] std::size_t assetCount() const { return books_.assetCount(); }
  [[nodiscard]] std::uint64_t bytes() const { return books_.bytes(); }

 private:
  struct Waiting {
    AssetId id;
    proto::AssetKind kind;
    std::string bytes;
  };
  [[nodiscard]] Status place(CachedLeaf& leaf, const proto::Pose& pose) const;
  [[nodiscard]] static Status shape(CachedLeaf& leaf);
  [[nodiscard]] Status addAsset(const proto::Asset& asset);
  [[nodiscard]] Result<std::string> bytesOf(const proto::Asset& asset);
  [[nodiscard]] Status make(const Waiting& asset);
  [[nodiscard]] Result<osg::ref_ptr<osg::Object>> decode(proto::AssetKind kind, std::string_view bytes) const;
  [[nodiscard]] bool isHere(const AssetId& id) const;

  const Options options_;
  float uploadMs_ = 0;
  OsgbCodec codec_;
  LeafCache books_;
  std::deque<Waiting> waiting_;
  std::vector<proto::Sha256> lacked_;
  std::unordered_map<AssetId, osg::ref_ptr<osg::Drawable>, AssetIdHash> drawables_;
  std::unordered_map<AssetId, osg::ref_ptr<osg::StateSet>, AssetIdHash> states_;
  std::unordered_map<AssetId, osg::ref_ptr<osg::Image>, AssetIdHash> images_;
  std::unordered_map<std::string, AssetId> imageNames_;  ///< by the names that states use
  std::unordered_map<std::uint32_t, CachedLeaf> leaves_;
};

}  // namespace tessera
