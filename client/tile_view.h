#pragma once

#include <cstdint>
#include <memory>

#include <osgViewer/Viewer>

#include "client/surface.h"
#include "client/tile_cache.h"
#include "common/hierarchy/visible_list.h"

namespace tessera {

class LeafListNode;

/// Draws exactly the leaves of a list, seen through one frustum, into the surface that is current.
/// OpenSceneGraph does the drawing but none of the culling.
///
/// Modelview matrices are composed in double relative to the eye, R (A | t - eye), so that a scene far from
/// the origin is drawn as steadily as one at it.
class TileView {
 public:
  TileView(int widthPx, int heightPx, const std::array<float, 3>& backgroundRgb);
  ~TileView();
  TileView(const TileView&) = delete;
  TileView& operator=(const TileView&) = delete;

  /// The new list. Every leaf of it must be in the cache, which must outlive its use here.
  void setList(const VisibleList& list, const TileCache& cache);
  void draw(const proto::Frame& frame);

 private:
  osg::ref_ptr<LeafListNode> leaves_;
  osgViewer::Viewer viewer_;
};

}  // namespace tessera
