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
///
/// All tiles draw with the projection of the whole wall into a viewport of the wall's size, of which their
/// window is a part. Clip coordinates are then the same floats on every tile, so that edges and nearly
/// coinciding surfaces meet at the seams; with a projection for each tile their rounding would differ. A wall
/// beyond OpenGL's largest viewport is drawn with a projection for each tile, as is a tile whose drawn size
/// is not its own.
class TileView {
 public:
  /// Size, place and background are those of `welcome`; `drawn` is the size of the surface.
  TileView(const proto::Welcome& welcome, PixelSize drawn);
  ~TileView();
  TileView(const TileView&) = delete;
  TileView& operator=(const TileView&) = delete;

  /// The new list. Every leaf of it must be in the cache, which must outlive its use here.
  void setList(const VisibleList& list, const TileCache& cache);
  void draw(const proto::Frame& frame);

 private:
  struct Window {
    int xPx, yPx, widthPx, heightPx;  ///< of this tile in the wall's picture
    int wallWidthPx, wallHeightPx;
  };
  void setProjection(const proto::Frame& frame, const Mat3& rotation);

  const Window window_;
  bool drawsWallViewport_ = false;
  osg::ref_ptr<LeafListNode> leaves_;
  osgViewer::Viewer viewer_;
};

}  // namespace tessera
