#include "client/eye_views.h"

namespace tessera {

namespace {

using proto::StereoLayout;

bool hasStereoBuffers() {
  GLboolean has = GL_FALSE;
  glGetBooleanv(GL_STEREO, &has);
  return has == GL_TRUE;
}

}  // namespace

Result<std::vector<EyeView>> eyeViews(const proto::Frame& frame, int widthPx, int heightPx) {
  const PixelArea whole = {0, 0, widthPx, heightPx};
  EyeView left = {frame.eye, frame.corners, whole, GL_NONE};
  if (frame.stereo == StereoLayout::None || !frame.rightEye) return std::vector<EyeView>{left};
  EyeView right = {frame.rightEye->eye, frame.rightEye->corners, whole, GL_NONE};
  switch (frame.stereo) {
    case StereoLayout::SideBySide:
      left.area.widthPx = widthPx / 2;
      right.area.xPx = left.area.widthPx;
      right.area.widthPx = widthPx - left.area.widthPx;
      break;
    case StereoLayout::TopBottom:
      right.area.heightPx = heightPx - heightPx / 2;
      left.area.yPx = right.area.heightPx;
      left.area.heightPx = heightPx / 2;
      break;
    case StereoLayout::QuadBuffer:
      if (!hasStereoBuffers()) {
        return runtimeError("stereo", "this display has no buffers for two eyes (quad-buffered stereo)",
                            "choose side-by-side, top-bottom or tiles in the wall file");
      }
      left.buffer = GL_BACK_LEFT;
      right.buffer = GL_BACK_RIGHT;
      break;
    case StereoLayout::None:
      break;
  }
  if (left.area.widthPx == 0 || left.area.heightPx == 0)
    return runtimeError("stereo", "the tile is too small for two pictures");
  return std::vector<EyeView>{left, right};
}

}  // namespace tessera
