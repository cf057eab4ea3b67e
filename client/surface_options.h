#pragma once

#include <optional>
#include <string>

#include "client/surface.h"
#include "common/base/result.h"

namespace tessera {

/// A window on the desktop, in its pixels from the upper left.
struct WindowPlace {
  int xPx = 0, yPx = 0;
  std::optional<PixelSize> size = {};  ///< absent: the tile's
};

/// "X,Y" or "X,Y,WxH".
[[nodiscard]] Result<WindowPlace> parseWindowPlace(const std::string& text);

/// What the command line says of windows and EGL.
struct SurfaceOptions {
  std::string monitor;                ///< full screen on this one; empty: a window without a frame
  std::optional<WindowPlace> window;  ///< absent: at 0,0; not together with a monitor
  bool waitsForRetrace = true;        ///< vsync
  bool showsPointer = false;
  std::optional<int> eglDevice;  ///< absent: the first that works
};

}  // namespace tessera
