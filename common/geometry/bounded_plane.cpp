#include "common/geometry/bounded_plane.h"

#include <algorithm>

#include <Eigen/Geometry>

namespace tessera {

namespace {

/// `v` times the power of two that brings its largest component into [1/2, 1): exact, and keeps products
/// of extreme scenes away from overflow and underflow.
Vec3 scaledToUnit(const Vec3& v) {
  const double largest = v.cwiseAbs().maxCoeff();
  if (!(largest > 0) || !std::isfinite(largest)) return v;
  int exponent = 0;
  std::frexp(largest, &exponent);
  return v.unaryExpr([exponent](double x) { return std::ldexp(x, -exponent); });
}

}  // namespace

BoundedPlane planeThroughEye(const Vec3& a, const Vec3& b) {
  const Vec3 p = scaledToUnit(b), q = scaledToUnit(a);
  BoundedPlane plane;
  plane.normal = p.cross(q);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double m = std::abs(p[j] * q[k]) + std::abs(p[k] * q[j]);
    // The last term stands for products that underflow.
    plane.errorPerUnit[i] =
        6 * kUnitRoundoff * m + 12 * kUnitRoundoff * std::abs(plane.normal[i]) + 0x1p-1000;
  }
  return plane;
}

void widen(BoundedPlane& plane, double angle) {
  plane.errorPerUnit += Vec3::Constant(angle);
}

}  // namespace tessera
