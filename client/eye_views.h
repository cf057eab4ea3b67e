#pragma once

#include <array>
#include <vector>

#include <osg/GL>

#include "client/gl_scope.h"
#include "common/base/result.h"
#include "common/geometry/vec.h"
#include "proto/messages.h"

namespace tessera {

/// One picture of a frame: the image rectangle `corners` (as in Frustum) seen from `eye`, drawn to `area`.
struct EyeView {
  Vec3 eye;
  std::array<Vec3, 4> corners;
  PixelArea area;
  GLenum buffer = GL_NONE;  ///< GL_NONE: the one that is drawn to anyway
};

/// The pictures of a frame for a tile of this size: one, or in stereo the left and then the right eye's.
/// Fails where the tile has no room for two, or OpenGL no second buffer for the right eye. Needs a current
/// context.
[[nodiscard]] Result<std::vector<EyeView>> eyeViews(const proto::Frame& frame, int widthPx, int heightPx);

}  // namespace tessera
