// tessera-tile: draws by OSMesa, and starts tessera-tile-gl for what needs another OpenGL library.

#include "client/offscreen_surface.h"
#include "client/tile_program.h"

int main(int argc, char** argv) {
  using tessera::proto::SurfaceKind;
  const auto surfacesOf = [](SurfaceKind kind, const tessera::SurfaceOptions&) {
    return kind == SurfaceKind::Offscreen ? tessera::makeOffscreenSurfaces() : nullptr;
  };
  return tessera::runTileProgram(argc, argv, {.surfacesOf = surfacesOf, .sibling = "tessera-tile-gl"});
}
