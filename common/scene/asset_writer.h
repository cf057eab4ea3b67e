#pragma once

#include <map>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include <osg/Drawable>
#include <osg/Image>
#include <osg/StateSet>
#include <osg/Vec4>

#include "common/assets/asset_table.h"
#include "common/base/result.h"
#include "common/geometry/box.h"
#include "common/scene/osgb_codec.h"

namespace tessera {

/// A drawable as it goes into the store, and what its leaves need to know of it.
struct WrittenDrawable {
  std::uint32_t asset = 0;     ///< its number
  Vec3 origin = Vec3::Zero();  ///< local coordinates: the stored vertices are relative to it
  /// Per axis, how far a stored vertex may lie from its point: vertices in double are stored as float.
  Vec3 storageError = Vec3::Zero();
  std::vector<Vec3> points;  ///< the vertices in use, local coordinates, full precision
  std::uint64_t triangles = 0;
  bool isEmpty = true;                 ///< there is nothing to draw
  std::optional<osg::Vec4> meanColor;  ///< of its vertices; none: the state has the colour
};

/// What a state makes of a drawable seen from far away.
struct StateColor {
  osg::Vec4 material = osg::Vec4(0.8F, 0.8F, 0.8F, 1);
  osg::Vec4 texture = osg::Vec4(1, 1, 1, 1);  ///< the mean of the texture
};

/// The point about which a geometry's vertices are stored: in the middle of its box on the axes on which it
/// lies far from its origin, else 0.
[[nodiscard]] Vec3 storageOriginOf(const osg::Drawable& drawable);

/// Serializes the drawables, state sets and images of one scene into its assets, each once.
class AssetWriter {
 public:
  explicit AssetWriter(AssetTable& assets) : assets_(&assets) {}

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

  /// The number of the asset. Null stands for the empty state.
  [[nodiscard]] Result<std::uint32_t> writeState(const osg::StateSet* state);

  /// Of a state that was written.
  [[nodiscard]] const StateColor& meanColorOf(std::uint32_t state) const { return colors_.at(state); }

 private:
  Result<std::uint32_t> writeImage(osg::Image& image);
  Result<std::vector<std::uint32_t>> nameImages(osg::StateSet& state);
  [[nodiscard]] StateColor colorOf(const osg::StateSet& state);

  AssetTable* assets_;
  OsgbCodec codec_;
  std::unordered_map<const osg::Drawable*, WrittenDrawable> drawables_;
  std::unordered_map<const osg::StateSet*, std::uint32_t> states_;
  std::unordered_map<const osg::Image*, std::uint32_t> images_;
  std::unordered_map<const osg::Image*, osg::Vec4> imageColors_;
  std::unordered_map<std::uint32_t, StateColor> colors_;  ///< by number of the state
  std::map<std::pair<const osg::StateSet*, const osg::StateSet*>, osg::ref_ptr<const osg::StateSet>> merged_;
};

}  // namespace tessera
