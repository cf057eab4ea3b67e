#include "server/bench/walk.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace tessera::bench {

Wall gridWall(int columns, int rows) {
  Wall wall;
  wall.source = std::to_string(columns) + "x" + std::to_string(rows);
  wall.columns = columns;
  wall.rows = rows;
  wall.tileWidthPx = 480;
  wall.tileHeightPx = 270;
  wall.fovYRad = 50 * std::numbers::pi / 180;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      wall.tiles.push_back({.name = "r" + std::to_string(row) + "c" + std::to_string(column),
                            .column = column,
                            .row = row,
                            .xPx = column * wall.tileWidthPx,
                            .yPx = row * wall.tileHeightPx,
                            .widthPx = wall.tileWidthPx,
                            .heightPx = wall.tileHeightPx});
    }
  }
  return wall;
}

Walk::Step Walk::step() const {
  std::vector<double> degrees, radii;
  for (std::uint64_t frame = 1; frame < frames(); ++frame) {
    const CameraPose before = pose(frame - 1), now = pose(frame);
    const Vec3 a = (before.target - before.eye).normalized(), b = (now.target - now.eye).normalized();
    degrees.push_back(std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi);
    radii.push_back((now.eye - before.eye).norm() / scene_.radius);
  }
  const auto median = [](std::vector<double>& values) {
    if (values.empty()) return 0.0;
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                     values.end());
    return values[values.size() / 2];
  };
  return {median(degrees), median(radii)};
}

}  // namespace tessera::bench
