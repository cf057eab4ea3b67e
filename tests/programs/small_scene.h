#pragma once

#include <string>

#include "tests/support/process.h"

namespace tessera::test {

/// A scene of two triangles at different places, as text: enough for a wall to have something to draw.
inline std::string smallScene(const std::string& firstVertexX = "0") {
  return "v " + firstVertexX +
         " 0 0\nv 1 0 0\nv 0 1 0\nv 3 0 -1\nv 4 0 -1\nv 3 1 -1\ng a\nf 1 2 3\ng b\nf 4 5 6\n";
}

inline std::string smallWall() {
  return R"({"grid": {"columns": 2, "rows": 2, "tile_px": [64, 48]}})";
}

}  // namespace tessera::test
