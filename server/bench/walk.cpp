#include "server/bench/walk.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "common/wall/frustum_groups.h"

namespace tessera::bench {

Wall gridWall(int columns, int rows) {
  return tessera::gridWall(columns, rows, 480, 270, 50 * std::numbers::pi / 180);
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

WallFrusta::WallFrusta(const Wall& wall) {
  const std::vector<FrustumGroup> groups = frustumGroups(wall, Grouping::Hierarchies);
  const FrustumGroup& first = groups.front();
  if (groups.size() > 1 || first.columns == 0) return;
  grid_.emplace(static_cast<std::uint16_t>(first.columns), static_cast<std::uint16_t>(first.rows),
                PlaneSource::Corners,
                first.touch ? GridFrusta::Neighbours::Touch : GridFrusta::Neighbours::GapOrOverlap);
}

void WallFrusta::update(const WallView& view) {
  if (grid_) {
    grid_->updateGrid(view.lattices[0], view.tiles);
    grid_->updatePlanes(view.screens[0], view.tiles);
  } else {
    general_.update(view.tiles);
  }
  if (view.left.empty()) return;
  if (grid_) {
    grid_->holdEyes(view.left, view.right);
  } else {
    general_.holdEyes(view.left, view.right);
  }
}

}  // namespace tessera::bench
