// tessera-tile-gl: draws by the system's OpenGL, in a window or by EGL. People start tessera-tile.

#include "client/egl_surface.h"
#include "client/tile_program.h"
#include "client/window_surface.h"

int main(int argc, char** argv) {
  using tessera::proto::SurfaceKind;
  const auto surfacesOf = [](SurfaceKind kind, const tessera::SurfaceOptions& options) {
    if (kind == SurfaceKind::Window) return tessera::makeWindowSurfaces(options);
    return kind == SurfaceKind::Egl ? tessera::makeEglSurfaces(options) : nullptr;
  };
  return tessera::runTileProgram(argc, argv, {.surfacesOf = surfacesOf, .sibling = "tessera-tile"});
}
