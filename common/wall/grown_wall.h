#pragma once

#include "common/wall/wall.h"

namespace tessera {

/// A wall of which every tile shows more of the same picture: its rectangle is larger on its screen by
/// `share` (0 or more) of its size on each side, about the same middle, and so tiles overlap. Screens grow
/// with their tiles, and the field of view of a virtual camera with its screen. For culling alone: pixels
/// stay as they are. Up to a quarter, less what tiles overlap already, even grids are still culled as such.
struct GrownWall {
  Wall wall;
  /// By how much the first screen's height has grown: tan(fovYRad / 2) has.
  double heightFactor = 1;

  /// The pose for the grown wall that is meant by one for the wall itself: its field of view, where it has
  /// one.
  [[nodiscard]] CameraPose poseFor(const CameraPose& pose) const;
};

[[nodiscard]] GrownWall grownWall(const Wall& wall, double share);

}  // namespace tessera
