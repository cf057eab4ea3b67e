#include "common/hierarchy/tile_cone.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "common/geometry/projection.h"

namespace tessera {

UnitNormal normalAt(const std::array<Vec3, 4>& corners, std::size_t i) {
  const Vec3& p = corners[i];
  const Vec3 a = corners[(i + 3) % 4] - p, b = corners[(i + 1) % 4] - p;
  const Vec3 cross = a.cross(b);
  const double length = cross.norm(), sides = a.norm() * b.norm();
  UnitNormal normal;
  if (!(length > 0) || !std::isfinite(length)) return normal;
  normal.n = cross / length;
  const double reach = std::max({p.norm(), corners[(i + 3) % 4].norm(), corners[(i + 1) % 4].norm()});
  // Differences of camera-relative corners err by 3u of the corner;
  // |fl(a)xfl(b) - axb| <= 6u|a||b| + (4u reach)(|a| + |b|); relative to |axb|, and twice for the division.
  normal.error = 2 * kUnitRoundoff * (8 * sides + 4 * reach * (a.norm() + b.norm())) / length;
  return normal;
}

TileCone::TileCone(const Frustum& frustum, const std::optional<Vec3>& commonAxis) {
  for (std::size_t i = 0; i < 4; ++i)
    corners[i] = frustum.corners[i] - frustum.eye;
  // How far away the rectangle lies has no meaning; at a distance near 1 nothing underflows. A power of two
  // is exact, but for what vanishes beside the rest.
  double largest = 0;
  for (const Vec3& k : corners)
    largest = std::max(largest, k.cwiseAbs().maxCoeff());
  if (largest > 0 && std::isfinite(largest)) {
    int exponent = 0;
    std::frexp(largest, &exponent);
    for (Vec3& k : corners)
      k = k.unaryExpr([exponent](double x) { return std::ldexp(x, -exponent); });
  }
  axis = commonAxis ? *commonAxis : normalAt(corners, 0).n;
  axisError = 0;
  minDepth = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 4; ++i) {
    // A rounded rectangle is not quite flat: the normal of any three of its corners may be meant.
    const UnitNormal normal = normalAt(corners, i);
    axisError = std::max(axisError, (normal.n - axis).norm() + normal.error + 4 * kUnitRoundoff);
    minDepth = std::min(minDepth, axis.dot(corners[i]) - 8 * kUnitRoundoff * corners[i].norm());
  }
  isProper = minDepth > 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const BoundedPlane& side = cornerSides[i] = planeThroughEye(corners[i], corners[(i + 1) % 4]);
    for (const std::size_t other : {(i + 2) % 4, (i + 3) % 4}) {
      const double error = side.errorPerUnit.dot(corners[other].cwiseAbs());
      if (!(side.normal.dot(corners[other]) > error)) isProper = false;
    }
  }
}

double TileCone::overhang(const BoundedPlane& plane, double sign) const {
  double most = 0;
  for (const Vec3& k : corners) {
    const double rounding = 8 * kUnitRoundoff * plane.normal.cwiseAbs().dot(k.cwiseAbs());
    most = std::max(most, -sign * plane.normal.dot(k) + rounding);
  }
  return most;
}

void TileCone::sides(FrustumPlanes& planes, PlaneSource source) const {
  if (source == PlaneSource::Matrix && isProper) {
    // Near and far do not enter the sides; these keep the matrix well conditioned.
    const auto extracted = gribbHartmannPlanes(relativeViewProjection(corners, axis, minDepth, 2 * minDepth));
    constexpr std::array kOrder = {ClipPlane::Bottom, ClipPlane::Right, ClipPlane::Top, ClipPlane::Left};
    for (std::size_t i = 0; i < 4; ++i) {
      BoundedPlane& side = planes.planes[i];
      side = {};
      side.normal = extracted[static_cast<std::size_t>(kOrder[i])].head<3>();
      side.errorPerUnit = 12 * kUnitRoundoff * side.normal.cwiseAbs();
      side.errorConstant = 0x1p-1000;  // underflow, as in planeThroughEye
      // No a-priori analysis of the matrix: where its planes lie is measured against the corners.
      widen(side, overhang(side, 1) / minDepth * (1 + 8 * kUnitRoundoff));
    }
    return;
  }
  std::copy(cornerSides.begin(), cornerSides.end(), planes.planes.begin());
}

void addDepthPlane(FrustumPlanes& planes, const Vec3& axis, double axisError, double distance, double sign) {
  BoundedPlane plane;
  plane.normal = sign * axis;
  plane.distance = sign * distance;
  plane.errorPerUnit = 12 * kUnitRoundoff * axis.cwiseAbs() + Vec3::Constant(axisError);
  plane.errorConstant = 8 * kUnitRoundoff * std::abs(distance) + 0x1p-1000;
  planes.planes[planes.count++] = plane;
}

}  // namespace tessera
