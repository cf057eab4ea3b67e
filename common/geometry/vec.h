#pragma once

#include <cmath>

#include <Eigen/Core>

namespace tessera {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Mat4 = Eigen::Matrix4d;

/// Unit roundoff of double, 2^-53: a correctly rounded operation errs by at most this factor.
inline constexpr double kUnitRoundoff = 0x1p-53;

/// |v| without underflow or overflow on the way; errs by less than 8 roundoffs, and by 2^-1070.
[[nodiscard]] inline double lengthOf(const Vec3& v) {
  const double squared = v.squaredNorm();
  return squared > 1e-270 && squared < 1e300 ? std::sqrt(squared) : v.stableNorm();
}

[[nodiscard]] inline bool isFinite(const Vec3& v) {
  return v.allFinite();
}

}  // namespace tessera
