#pragma once

#include <optional>
#include <string>

#include "common/base/pixel_place.h"

namespace tessera {

/// What the command line says of windows and EGL.
struct SurfaceOptions {
  std::string monitor;               ///< full screen on this one; empty: a window without a frame
  std::optional<PixelPlace> window;  ///< absent: at 0,0 in the tile's size; not together with a monitor
  bool waitsForRetrace = true;       ///< vsync
  bool showsPointer = false;
  std::optional<int> eglDevice;  ///< absent: the first that works
};

}  // namespace tessera
