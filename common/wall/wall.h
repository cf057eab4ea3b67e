#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/geometry/frustum.h"
#include "common/geometry/vec.h"

namespace tessera {

/// Limits of the vertical field of view. Outside them the image plane degenerates numerically.
inline constexpr double kMinFovYDeg = 0.001;
inline constexpr double kMaxFovYDeg = 179.9;

/// Where a tile is drawn: pixels of the tile and their place in the wall's stitched picture, origin at the
/// picture's upper left.
struct Tile {
  std::string name;
  int column = 0;  ///< from the left
  int row = 0;     ///< from the top
  int xPx = 0, yPx = 0, widthPx = 0, heightPx = 0;
};

/// The viewpoint of one frame, world space. Looks from `eye` to `target`; `fovYRad` is the vertical field of
/// view over the whole wall, and overrides the wall's own where present.
struct CameraPose {
  Vec3 eye = Vec3::Zero();
  Vec3 target = Vec3(0, 0, -1);
  Vec3 up = Vec3(0, 1, 0);
  std::optional<double> fovYRad = {};
};

/// One frame's view of the whole wall: the frusta of all tiles and what they share.
struct WallView {
  Frustum wall;                ///< the primary frustum, over all tiles
  std::vector<Frustum> tiles;  ///< in the order of Wall::tiles
  Vec3 right, up;              ///< unit axes of the image plane; all tiles draw with the same orientation
  std::vector<Vec3> lattice;   ///< the tiles' corners, (columns + 1) x (rows + 1), row by row from the top
};

/// A uniform planar grid of tiles seen by one virtual camera. Tiles are stored row by row from the top,
/// named r<row>c<column> unless the file names them.
struct Wall {
  std::string source;  ///< the file it came from, for messages
  std::string name;    ///< for people; may be empty
  int columns = 1, rows = 1;
  int tileWidthPx = 0, tileHeightPx = 0;
  double fovYRad = 0;
  std::optional<double> near, far;  ///< metres; absent: fitted to the scene each frame
  std::vector<Tile> tiles;
  std::vector<std::string> warnings;  ///< allowed but unwise; one sentence each

  [[nodiscard]] int widthPx() const { return columns * tileWidthPx; }
  [[nodiscard]] int heightPx() const { return rows * tileHeightPx; }
  /// The same wall as a single tile of all its pixels, named "wall".
  [[nodiscard]] Wall untiled() const;
};

/// The frusta of one frame. Neighbouring tiles share the doubles of their common corners, so they share
/// planes and leave no gap. Near and far are the wall's own or, where it has none, fitted to the sphere
/// (`sceneCenter`, `sceneRadius` > 0): all tiles share them. The pose must be finite, its eye different from
/// its target and its up not along the view (CameraPath guarantees it); of a pose that breaks the latter two
/// the result is some finite view.
[[nodiscard]] WallView viewOf(const Wall& wall, const CameraPose& pose, const Vec3& sceneCenter,
                              double sceneRadius);

/// The same into `view`, whose capacities are reused.
void viewInto(const Wall& wall, const CameraPose& pose, const Vec3& sceneCenter, double sceneRadius,
              WallView& view);

}  // namespace tessera
