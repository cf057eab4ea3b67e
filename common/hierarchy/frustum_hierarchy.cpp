#include "common/hierarchy/frustum_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace tessera {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Unit normal, away from the eye, of the triangle (corner, next, previous) of an image rectangle, and a
/// bound of its error as a vector length. Differences of camera-relative corners err by 3u of the corner.
struct UnitNormal {
  Vec3 n = Vec3::Zero();
  double error = kInfinity;
};

UnitNormal normalAt(const std::array<Vec3, 4>& corners, std::size_t i) {
  const Vec3& p = corners[i];
  const Vec3 a = corners[(i + 3) % 4] - p, b = corners[(i + 1) % 4] - p;
  const Vec3 cross = a.cross(b);
  const double length = cross.norm(), sides = a.norm() * b.norm();
  UnitNormal normal;
  if (!(length > 0) || !std::isfinite(length)) return normal;
  normal.n = cross / length;
  const double reach = std::max({p.norm(), corners[(i + 3) % 4].norm(), corners[(i + 1) % 4].norm()});
  // |fl(a)xfl(b) - axb| <= 6u|a||b| + (4u reach)(|a| + |b|); relative to |axb|, and twice for the division.
  normal.error = 2 * kUnitRoundoff * (8 * sides + 4 * reach * (a.norm() + b.norm())) / length;
  return normal;
}

}  // namespace

FrustumHierarchy::FrustumHierarchy(std::uint16_t columns, std::uint16_t rows)
    : columns_(columns), rows_(rows) {
  const std::size_t tileCount = std::size_t{columns} * rows;
  tiles_.resize(tileCount);
  tileCorners_.resize(tileCount);
  build();
  bisections_.resize(nodes_.size());
}

void FrustumHierarchy::build() {
  nodes_.push_back({.firstColumn = 0, .endColumn = columns_, .firstRow = 0, .endRow = rows_});
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    const Node node = nodes_[i];
    const int width = node.endColumn - node.firstColumn, height = node.endRow - node.firstRow;
    if (width == 1 && height == 1) {
      nodes_[i].tile = std::uint32_t{node.firstRow} * columns_ + node.firstColumn;
      continue;
    }
    Node negative = node, positive = node;
    if (width >= height) {
      negative.endColumn = positive.firstColumn = static_cast<std::uint16_t>(node.firstColumn + width / 2);
    } else {
      negative.endRow = positive.firstRow = static_cast<std::uint16_t>(node.firstRow + height / 2);
    }
    nodes_[i].negative = static_cast<std::uint32_t>(nodes_.size());
    nodes_[i].positive = nodes_[i].negative + 1;
    nodes_.push_back(negative);
    nodes_.push_back(positive);
  }
}

void FrustumHierarchy::update(const Frustum& wall, std::span<const Frustum> tiles) {
  eye_ = wall.eye;
  for (std::size_t i = 0; i < 4; ++i)
    wallCorners_[i] = wall.corners[i] - eye_;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    for (std::size_t i = 0; i < 4; ++i)
      tileCorners_[t][i] = tiles[t].corners[i] - eye_;
  }
  measureDepths();
  proper_ = minDepth_ > 0;
  for (std::uint32_t t = 0; t < tiles.size(); ++t)
    updateTile(t);
  for (std::size_t i = 0; i < 4; ++i) {
    BoundedPlane& side = primary_.planes[i];
    side = planeThroughEye(wallCorners_[i], wallCorners_[(i + 1) % 4]);
    widen(side, overhang(side, nodes_[0], 1));
  }
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (!nodes_[i].isLeaf()) updateBisection(i);
  }
  primary_.count = 4;
  for (FrustumPlanes& tile : tiles_)
    tile.count = 4;
  updateNearAndFar(wall);
}

void FrustumHierarchy::measureDepths() {
  const UnitNormal wallNormal = normalAt(wallCorners_, 0);
  axis_ = wallNormal.n;
  axisError_ = wallNormal.error;
  minDepth_ = kInfinity;
  for (const Corners& corners : tileCorners_) {
    for (std::size_t i = 0; i < 4; ++i) {
      // A rounded rectangle is not quite flat: the normal of any three of its corners may be meant.
      const UnitNormal normal = normalAt(corners, i);
      axisError_ = std::max(axisError_, (normal.n - axis_).norm() + normal.error + 4 * kUnitRoundoff);
      minDepth_ = std::min(minDepth_, axis_.dot(corners[i]) - 8 * kUnitRoundoff * corners[i].norm());
    }
  }
}

void FrustumHierarchy::updateTile(std::uint32_t tile) {
  const Corners& corners = tileCorners_[tile];
  for (std::size_t i = 0; i < 4; ++i) {
    BoundedPlane& side = tiles_[tile].planes[i];
    side = planeThroughEye(corners[i], corners[(i + 1) % 4]);
    for (const std::size_t other : {(i + 2) % 4, (i + 3) % 4}) {
      const double error = side.errorPerUnit.dot(corners[other].cwiseAbs());
      if (!(side.normal.dot(corners[other]) > error)) proper_ = false;
    }
  }
}

/// How far the corners of the node's tiles stick out over the outside (sign 1: where the plane is negative)
/// of a plane, as the angle by which the plane must be widened. The frustum of a convex tile is the cone of
/// its corner rays, so a point p of it is a sum of l_i k_i, l_i >= 0, with sum l_i <= depth(p) / minDepth_;
/// where every n.k_i >= -m, n.p >= -m depth(p) / minDepth_ >= -m |p| / minDepth_.
double FrustumHierarchy::overhang(const BoundedPlane& plane, const Node& node, double sign) const {
  if (!proper_) return kInfinity;
  double most = 0;
  for (int row = node.firstRow; row < node.endRow; ++row) {
    for (int column = node.firstColumn; column < node.endColumn; ++column) {
      for (const Vec3& k : corners(column, row)) {
        const double rounding = 8 * kUnitRoundoff * plane.normal.cwiseAbs().dot(k.cwiseAbs());
        most = std::max(most, -sign * plane.normal.dot(k) + rounding);
      }
    }
  }
  return most / minDepth_ * (1 + 8 * kUnitRoundoff);
}

void FrustumHierarchy::updateBisection(std::uint32_t index) {
  const Node& node = nodes_[index];
  const Node& negative = nodes_[node.negative];
  const Node& positive = nodes_[node.positive];
  BoundedPlane& plane = bisections_[index];
  if (negative.endColumn == positive.firstColumn) {
    const int column = negative.endColumn - 1;
    plane = planeThroughEye(corners(column, node.firstRow)[2], corners(column, node.endRow - 1)[1]);
  } else {
    const int row = negative.endRow - 1;
    plane = planeThroughEye(corners(node.endColumn - 1, row)[1], corners(node.firstColumn, row)[0]);
  }
  widen(plane, std::max(overhang(plane, positive, 1), overhang(plane, negative, -1)));
}

void FrustumHierarchy::updateNearAndFar(const Frustum& wall) {
  const auto add = [this](double distance, double sign) {
    BoundedPlane plane;
    plane.normal = sign * axis_;
    plane.distance = sign * distance;
    plane.errorPerUnit = 12 * kUnitRoundoff * axis_.cwiseAbs() + Vec3::Constant(axisError_);
    plane.errorConstant = 8 * kUnitRoundoff * std::abs(distance);
    primary_.planes[primary_.count++] = plane;
    for (FrustumPlanes& tile : tiles_)
      tile.planes[tile.count++] = plane;
  };
  if (wall.near) add(*wall.near, 1);
  if (wall.far) add(*wall.far, -1);
}

const FrustumHierarchy::Corners& FrustumHierarchy::corners(int column, int row) const {
  return tileCorners_[static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column)];
}

}  // namespace tessera
