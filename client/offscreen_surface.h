#pragma once

#include <memory>

#include "client/surface.h"

namespace tessera {

/// Draws into memory by OSMesa: no window system, no GPU. make() fails with a clear error where another
/// OpenGL library has taken the place of OSMesa in this process.
[[nodiscard]] std::unique_ptr<SurfaceMaker> makeOffscreenSurfaces();

}  // namespace tessera
