#include "common/wall/wall.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "common/wall/view_axes.h"

namespace tessera {

namespace {

struct Axes {
  Vec3 right, up, forward;
};

struct DepthRange {
  double near, far;
};

Axes axesOf(const CameraPose& pose) {
  const Vec3 forward = direction(pose.target - pose.eye).value_or(-Vec3::UnitZ());
  const std::optional<Vec3> maybeUp = upAcross(forward, pose.up);
  const Vec3 up = maybeUp ? *maybeUp : anyUpAcross(forward);
  return {forward.cross(up).normalized(), up, forward};
}

/// Depths that hold the whole scene sphere, as far as it is before the eye.
DepthRange fittedDepths(const CameraPose& pose, const Vec3& forward, const Vec3& center, double radius) {
  constexpr double kSlack = 1e-3;
  constexpr double kDeepestRatio =
      2e3;  // as OpenSceneGraph; deeper wastes the depth buffer: surfaces flicker
  // The second term outweighs the rounding of coordinates that are large against the sphere.
  const double largest = std::max(pose.eye.cwiseAbs().maxCoeff(), center.cwiseAbs().maxCoeff());
  const double margin = kSlack * radius + 64 * kUnitRoundoff * largest;
  const double depth = forward.dot(center - pose.eye);
  const double far = std::max(depth + radius + margin, radius);
  return {std::max(depth - radius - margin, far / kDeepestRatio), far};
}

/// The wall's own distances where it has them, the fitted ones else, and near < far in any case.
DepthRange depthsOf(const Wall& wall, const DepthRange& fitted) {
  DepthRange depths{wall.near.value_or(fitted.near), wall.far.value_or(fitted.far)};
  if (depths.near < depths.far) return depths;
  if (wall.near) return {depths.near, 2 * depths.near};
  return {depths.far / 2, depths.far};
}

/// The corners of all tiles on the image plane, (columns + 1) x (rows + 1), each computed once: tiles that
/// share a corner share its doubles.
class Lattice {
 public:
  /// Kept in `corners`.
  Lattice(const Wall& wall, const Axes& axes, const Vec3& eye, double distance, double fovYRad,
          std::vector<Vec3>& corners)
      : columns_(wall.columns), rows_(wall.rows), corners_(corners) {
    const Vec3 origin = eye + axes.forward * distance;
    const double halfHeight = distance * std::tan(fovYRad / 2);
    const double halfWidth = halfHeight * wall.widthPx() / wall.heightPx();
    corners_.clear();
    corners_.reserve((static_cast<std::size_t>(columns_) + 1) * (static_cast<std::size_t>(rows_) + 1));
    // The quotients run from exactly -1 to exactly 1 and are symmetric, so the outermost corners do not
    // depend on how the wall is divided.
    for (int row = 0; row <= rows_; ++row) {
      const double y = halfHeight * (static_cast<double>(rows_ - 2 * row) / rows_);
      for (int column = 0; column <= columns_; ++column) {
        const double x = halfWidth * (static_cast<double>(2 * column - columns_) / columns_);
        corners_.emplace_back(origin + axes.right * x + axes.up * y);
      }
    }
  }

  /// Corners of the rectangle from column, row (inclusive) to columnEnd, rowEnd (exclusive), in the order
  /// of Frustum.
  [[nodiscard]] std::array<Vec3, 4> rectangle(int column, int row, int columnEnd, int rowEnd) const {
    return {at(column, rowEnd), at(columnEnd, rowEnd), at(columnEnd, row), at(column, row)};
  }

 private:
  [[nodiscard]] const Vec3& at(int column, int row) const {
    const std::size_t stride = static_cast<std::size_t>(columns_) + 1;
    return corners_[static_cast<std::size_t>(row) * stride + static_cast<std::size_t>(column)];
  }

  int columns_, rows_;
  std::vector<Vec3>& corners_;
};

}  // namespace

Wall Wall::untiled() const {
  Wall whole = *this;
  whole.columns = 1;
  whole.rows = 1;
  whole.tileWidthPx = widthPx();
  whole.tileHeightPx = heightPx();
  whole.tiles = {Tile{"wall", 0, 0, 0, 0, widthPx(), heightPx()}};
  whole.warnings.clear();  // they are about seams
  return whole;
}

WallView viewOf(const Wall& wall, const CameraPose& pose, const Vec3& sceneCenter, double sceneRadius) {
  WallView view;
  viewInto(wall, pose, sceneCenter, sceneRadius, view);
  return view;
}

void viewInto(const Wall& wall, const CameraPose& pose, const Vec3& sceneCenter, double sceneRadius,
              WallView& view) {
  const Axes axes = axesOf(pose);
  const DepthRange depths = depthsOf(wall, fittedDepths(pose, axes.forward, sceneCenter, sceneRadius));
  // How far away the rectangle lies has no meaning, but its corners are rounded to steps that grow with the
  // eye's coordinates. At the far distance, and no nearer than the eye is to the origin, a step is no larger
  // an angle than double's roundoff, even for a tiny scene far out.
  const double distance = std::max(depths.far, pose.eye.cwiseAbs().maxCoeff());
  const Lattice lattice(wall, axes, pose.eye, distance, pose.fovYRad.value_or(wall.fovYRad), view.lattice);

  const auto frustum = [&](const std::array<Vec3, 4>& corners) {
    return Frustum{pose.eye, corners, depths.near, depths.far};
  };
  view.wall = frustum(lattice.rectangle(0, 0, wall.columns, wall.rows));
  view.right = axes.right;
  view.up = axes.up;
  view.tiles.clear();
  view.tiles.reserve(wall.tiles.size());
  for (const Tile& tile : wall.tiles) {
    view.tiles.push_back(frustum(lattice.rectangle(tile.column, tile.row, tile.column + 1, tile.row + 1)));
  }
}

}  // namespace tessera
