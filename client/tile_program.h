#pragma once

#include <functional>
#include <memory>

#include "client/surface.h"
#include "client/surface_options.h"
#include "proto/messages.h"

namespace tessera {

/// One of the two programs that a tile is drawn by. libosg draws with the OpenGL library that its program was
/// linked with first, so OSMesa and the system's OpenGL need a program each; the command line is the same.
struct TileProgram {
  /// Makes the surfaces of a kind; null where the other program does.
  std::function<std::unique_ptr<SurfaceMaker>(proto::SurfaceKind, const SurfaceOptions&)> surfacesOf;
  const char* sibling;  ///< file name of the other program, which lies beside this one
};

/// Reads the command line and runs the tile to its end, or becomes the other program where that one draws on
/// the surface that was asked for. Returns the exit status.
[[nodiscard]] int runTileProgram(int argc, char** argv, const TileProgram& program);

}  // namespace tessera
