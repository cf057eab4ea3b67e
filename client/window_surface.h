#pragma once

#include <memory>

#include "client/surface.h"
#include "client/surface_options.h"

namespace tessera {

/// Windows on the desktop of $DISPLAY, by GLFW: full screen on one monitor, or without a frame at a place.
/// What is wrong (no display, an unknown monitor, a window that the desktop does not hold) is found before a
/// window opens. Closing a window, and the Escape key in it, are told as Quit.
[[nodiscard]] std::unique_ptr<SurfaceMaker> makeWindowSurfaces(const SurfaceOptions& options);

}  // namespace tessera
