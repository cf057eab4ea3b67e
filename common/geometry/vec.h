#pragma once

#include <Eigen/Core>

namespace tessera {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Mat4 = Eigen::Matrix4d;

/// Unit roundoff of double, 2^-53: a correctly rounded operation errs by at most this factor.
inline constexpr double kUnitRoundoff = 0x1p-53;

[[nodiscard]] inline bool isFinite(const Vec3& v) {
  return v.allFinite();
}

}  // namespace tessera
