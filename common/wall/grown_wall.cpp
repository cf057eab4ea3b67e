#include "common/wall/grown_wall.h"

#include <algorithm>
#include <cmath>

namespace tessera {

namespace {

double grownFovRad(double fovYRad, double heightFactor) {
  return 2 * std::atan(std::tan(fovYRad / 2) * heightFactor);
}

void grow(Tile& tile, double share) {
  Vec2 middle = Vec2::Zero();
  for (const Vec2& corner : tile.corners)
    middle += corner / 4;
  for (Vec2& corner : tile.corners)
    corner += 2 * share * (corner - middle);
}

}  // namespace

GrownWall grownWall(const Wall& wall, double share) {
  GrownWall grown{.wall = wall};
  for (Tile& tile : grown.wall.tiles)
    grow(tile, share);
  for (Screen& screen : grown.wall.screens) {
    const auto first = grown.wall.tiles.begin() + screen.firstTile, end = first + screen.tileCount;
    Vec2 factor(1, 1);
    for (auto tile = first; tile != end; ++tile) {
      for (const Vec2& corner : tile->corners)
        factor = factor.cwiseMax(corner.cwiseAbs());
    }
    for (auto tile = first; tile != end; ++tile) {
      for (Vec2& corner : tile->corners)
        corner = corner.cwiseQuotient(factor);
    }
    screen.widthMm *= factor.x();
    screen.heightMm *= factor.y();
    screen.latticeWidth /= factor.x();
    screen.latticeHeight /= factor.y();
    if (&screen == grown.wall.screens.data()) grown.heightFactor = factor.y();
  }
  grown.wall.fovYRad = grownFovRad(wall.fovYRad, grown.heightFactor);
  return grown;
}

CameraPose GrownWall::poseFor(const CameraPose& pose) const {
  CameraPose meant = pose;
  if (pose.fovYRad) meant.fovYRad = grownFovRad(*pose.fovYRad, heightFactor);
  return meant;
}

}  // namespace tessera
