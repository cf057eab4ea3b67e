#pragma once

#include <memory>

#include "client/surface.h"

namespace tessera {

/// Draws into memory by OSMesa: no window system, no GPU. Fails with a clear error where another OpenGL
/// library has taken the place of OSMesa in this process.
[[nodiscard]] Result<std::unique_ptr<Surface>> makeOffscreenSurface(int widthPx, int heightPx);

/// Largest side that OSMesa draws.
[[nodiscard]] int maxOffscreenSidePx();

}  // namespace tessera
