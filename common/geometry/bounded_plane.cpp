#include "common/geometry/bounded_plane.h"

#include <algorithm>

#include <Eigen/Geometry>

namespace tessera {

namespace {

/// The exponent e with largest component in [2^(e-1), 2^e); 0 where there is none.
int exponentOf(const Vec3& v) {
  const double largest = v.cwiseAbs().maxCoeff();
  if (!(largest > 0) || !std::isfinite(largest)) return 0;
  int exponent = 0;
  std::frexp(largest, &exponent);
  return exponent;
}

/// Times a power of two: exact but for underflow.
Vec3 scaled(const Vec3& v, int exponent) {
  return v.unaryExpr([exponent](double x) { return std::ldexp(x, exponent); });
}

/// What products before the normal's scaling, or numbers after it, may lose by underflow.
constexpr double kUnderflow = 0x1p-1070;

}  // namespace

BoundedPlane planeThroughEye(const Vec3& a, const Vec3& b) {
  const Vec3 p = scaled(b, -exponentOf(b)), q = scaled(a, -exponentOf(a));
  const Vec3 normal = p.cross(q);
  Vec3 error;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    error[i] = 6 * kUnitRoundoff * (std::abs(p[j] * q[k]) + std::abs(p[k] * q[j])) + kUnderflow;
  }
  const int up = -3 - exponentOf(normal);
  BoundedPlane plane;
  plane.normal = scaled(normal, up);
  plane.errorPerUnit =
      scaled(error, up) + 12 * kUnitRoundoff * plane.normal.cwiseAbs() + Vec3::Constant(kUnderflow);
  plane.errorConstant = 0x1p-1060;
  return plane;
}

void widen(BoundedPlane& plane, double angle) {
  plane.errorPerUnit += Vec3::Constant(angle);
}

}  // namespace tessera
