#pragma once

#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include <osg/Drawable>
#include <osg/StateSet>

#include "common/assets/asset_store.h"
#include "common/base/result.h"
#include "common/geometry/box.h"
#include "common/scene/osgb_codec.h"

namespace tessera {

/// A drawable as it goes into the store, and what its leaves need to know of it.
struct WrittenDrawable {
  AssetId id;
  Vec3 origin = Vec3::Zero();  ///< local coordinates: the stored vertices are relative to it
  /// Per axis, how far a stored vertex may lie from its point: vertices in double are stored as float.
  Vec3 storageError = Vec3::Zero();
  std::vector<Vec3> points;  ///< the vertices in use, local coordinates, full precision
  std::uint64_t triangles = 0;
  bool isEmpty = true;  ///< there is nothing to draw
};

/// The point about which a geometry's vertices are stored: in the middle of its box on the axes on which it
/// lies far from its origin, else 0.
[[nodiscard]] Vec3 storageOriginOf(const osg::Drawable& drawable);

/// Serializes the drawables, state sets and images of one scene into its store, each once.
class AssetWriter {
 public:
  explicit AssetWriter(AssetStore& store) : store_(&store) {}

  /// The drawable without its state. A geometry whose vertices lie far from its origin, or are doubles, is
  /// stored relative to a point in its middle, so that a tile can draw it in float without jitter; to
  /// `origin` where one is given. The result lives as long as the writer or until the drawable is forgotten.
  /// The error has no place: the caller knows the leaf.
  [[nodiscard]] Result<const WrittenDrawable*> writeDrawable(const osg::Drawable& drawable,
                                                             const Vec3* origin = nullptr);

  /// Moves the points out. They are collected anew should the drawable be met again.
  [[nodiscard]] std::vector<Vec3> takePoints(const osg::Drawable& drawable);

  /// To be called before a drawable that was written dies: another one could get its address.
  void forget(const osg::Drawable& drawable) { drawables_.erase(&drawable); }

  /// The state in force below `inherited` (may be null) and then `own` (may be null). The result stays alive
  /// with the writer.
  [[nodiscard]] const osg::StateSet* merged(const osg::StateSet* inherited, const osg::StateSet* own);

  /// Null stands for the empty state.
  [[nodiscard]] Result<AssetId> writeState(const osg::StateSet* state);

 private:
  Result<AssetId> writeImage(osg::Image& image);
  Result<std::vector<AssetId>> nameImages(osg::StateSet& state);

  AssetStore* store_;
  OsgbCodec codec_;
  std::unordered_map<const osg::Drawable*, WrittenDrawable> drawables_;
  std::unordered_map<const osg::StateSet*, AssetId> states_;
  std::unordered_map<const osg::Image*, AssetId> images_;
  std::map<std::pair<const osg::StateSet*, const osg::StateSet*>, osg::ref_ptr<const osg::StateSet>> merged_;
};

}  // namespace tessera
