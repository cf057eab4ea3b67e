#pragma once

#include <array>
#include <string>

#include "common/geometry/vec.h"
#include "common/image/picture.h"

namespace tessera {

/// Where a tile's picture lies on a flat screen. Metres from the screen's lower left corner, x right, y up.
struct TilePlace {
  std::string tileName, screenName;  ///< UTF-8; the screen's may be empty
  int widthPx = 1, heightPx = 1;
  double screenWidthM = 1, screenHeightM = 1;
  /// Of the picture: lower left, lower right, upper right, upper left.
  std::array<Vec2, 4> cornersM = {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};

  /// Where a point of the picture lies on the screen. Pixels from the picture's upper left corner; the centre
  /// of the first pixel is at (0.5, 0.5).
  [[nodiscard]] Vec2 onScreen(double xPx, double yPx) const;
};

/// Distance of the grid's lines on a screen of this size: 1, 2 or 5 times a power of ten, about a twentieth
/// of the screen's shorter side.
[[nodiscard]] double gridSpacingM(double screenWidthM, double screenHeightM);

/// For hanging and blending: a grid at whole multiples of gridSpacingM() from the screen's lower left corner
/// with every fifth line brighter, circles around the screen's centre, its diagonals, marks on the tile's
/// outermost pixels at its corners, colour bars, a grey ramp, name and resolution. Lines are placed in
/// metres, so that they go on across bezels and overlaps, also of turned tiles.
[[nodiscard]] Picture alignmentPattern(const TilePlace& tile);

/// For finding out which display is which: the tile's name on a colour of its own, its screen, its size, and
/// an arrow that points to the screen's top.
[[nodiscard]] Picture identifyPattern(const TilePlace& tile);

}  // namespace tessera
