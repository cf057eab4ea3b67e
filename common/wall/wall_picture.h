#pragma once

#include <vector>

#include "common/geometry/vec.h"
#include "common/wall/wall.h"

namespace tessera {

/// A screen in the flat picture of the wall: millimetres, x right, y down.
struct FlatScreen {
  Vec2 center = Vec2::Zero();
  double turnRad = 0;  ///< clockwise as it is seen
  /// A point of the screen, millimetres from its middle, x right, y up.
  [[nodiscard]] Vec2 at(const Vec2& mm) const;
};

/// Where a tile's picture lies in the wall's, in its pixels from its upper left corner, y down.
struct PicturePlace {
  Vec2 corner = Vec2::Zero();                   ///< the outer corner of the tile's first pixel
  Vec2 across = Vec2(1, 0), down = Vec2(0, 1);  ///< for each of the tile's pixels
};

/// The wall laid out flat, true to scale, bezels and all: screens that share an edge are unfolded over it as
/// long as none covers another, the first of them upright; what does not hang together stands side by side,
/// in rows. Tiles for the right eye are shown in a second wall beside the first.
struct WallPicture {
  std::vector<FlatScreen> screens;  ///< in the order of Wall::screens
  double widthMm = 0, heightMm = 0;
  int widthPx = 0, heightPx = 0;
  double pxPerMmAcross = 1, pxPerMmDown = 1;
  std::vector<PicturePlace> tiles;  ///< in the order of Wall::tiles
  /// Tiles overlap as projectors do: their light adds, by this gamma; 0: no tiles overlap.
  double gamma = 0;
};

/// The picture is as fine as the finest tile, but for walls that would take more than `mostPixels`. Tiles of
/// the picture's own fineness that are not turned freely lie on whole pixels: at most half a pixel beside
/// their true place.
[[nodiscard]] WallPicture wallPicture(const Wall& wall, double mostPixels = 1e9);

}  // namespace tessera
