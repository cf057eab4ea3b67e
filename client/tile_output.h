#pragma once

#include <memory>
#include <optional>

#include <osg/GLExtensions>
#include <osg/ref_ptr>

#include "client/gl_picture.h"
#include "client/gl_scope.h"
#include "client/output_pass.h"
#include "client/overlay.h"
#include "client/test_pattern.h"
#include "common/base/result.h"
#include "proto/messages.h"

namespace tessera {

/// What is done to a tile's picture besides drawing the scene: test patterns, the correction that its display
/// needs, statistics. Lives in the context that is current when it is made, which must stay so.
class TileOutput {
 public:
  /// A plain picture, and, for the patterns, a screen that is the wall with pixels of a millimetre.
  TileOutput(const proto::Welcome& welcome, PixelSize drawn, osg::ref_ptr<osg::GLExtensions> gl);

  /// Where the tile hangs and what its display needs. Keeps nothing that `setup` refers to.
  [[nodiscard]] Status configure(const proto::TileSetup& setup);

  /// Fills the area with the pattern (not None) instead of the scene.
  [[nodiscard]] Status drawPattern(proto::Pattern pattern, const PixelArea& area);

  /// Corrects the picture in `area`, as configured; does nothing where nothing was asked for.
  void correct(const PixelArea& area) const;

  /// Lays statistics over the picture in `area`, in its upper left corner.
  [[nodiscard]] Status drawOverlay(const OverlayFacts& facts, const PixelArea& area);

 private:
  [[nodiscard]] Status make(std::unique_ptr<GlPicture>& picture) const;

  osg::ref_ptr<osg::GLExtensions> gl_;
  const PixelSize drawn_;
  TilePlace place_;
  std::unique_ptr<OutputPass> pass_;
  std::unique_ptr<GlPicture> patternPicture_, overlayPicture_;
  proto::Pattern pattern_ = proto::Pattern::None;  ///< that patternPicture_ shows
};

}  // namespace tessera
