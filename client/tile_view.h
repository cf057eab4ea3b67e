#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <osg/Scissor>
#include <osgViewer/Viewer>

#include "client/eye_views.h"
#include "client/surface.h"
#include "client/tile_cache.h"
#include "client/tile_output.h"
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

  /// The new list. Every leaf of it must have a record in the cache, which must outlive its use here. Those
  /// that cannot be drawn yet are left out, or stand as boxes.
  void setList(const VisibleList& list, TileCache& cache, bool drawsBoxes);
  /// The tile's screen and display; see TileOutput.
  [[nodiscard]] Status configure(const proto::TileSetup& setup);
  /// Draws the list or, where the frame asks for one, a test pattern; once for each eye. `facts` are for the
  /// frame's overlay.
  [[nodiscard]] Status draw(const proto::Frame& frame, const OverlayFacts& facts);

 private:
  struct Window {
    int xPx, yPx, widthPx, heightPx;  ///< of this tile in the wall's picture
    int wallWidthPx, wallHeightPx;
  };
  void drawScene(const proto::Frame& frame, const EyeView& view);
  void selectBuffer(GLenum buffer);
  void setTarget(const EyeView& view);
  void setProjection(const proto::Frame& frame, const EyeView& view, const Mat3& rotation);
  [[nodiscard]] bool fillsWindow(const PixelArea& area) const;

  const Window window_;
  const PixelSize drawn_;
  bool wallViewportFits_ = false;
  osg::ref_ptr<LeafListNode> leaves_;
  osgViewer::Viewer viewer_;
  GLenum buffer_ = GL_NONE;             ///< GL_NONE: the context's own choice
  osg::ref_ptr<osg::Scissor> scissor_;  ///< of the eye's area; set where that is not the whole window
  std::optional<TileOutput> output_;
};

}  // namespace tessera
