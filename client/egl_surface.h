#pragma once

#include <memory>

#include "client/surface.h"
#include "client/surface_options.h"

namespace tessera {

/// Draws into memory of the GPU (or of what stands in for one) by EGL, without a display: on the device that
/// was named, else on the first of EGL's devices that works, else on Mesa's surfaceless platform.
[[nodiscard]] std::unique_ptr<SurfaceMaker> makeEglSurfaces(const SurfaceOptions& options);

}  // namespace tessera
