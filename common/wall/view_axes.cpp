#include "common/wall/view_axes.h"

#include <Eigen/Geometry>

namespace tessera {

std::optional<Vec3> direction(const Vec3& v) {
  const double largest = v.cwiseAbs().maxCoeff();
  // Scaled first, since the squares of a length may overflow or vanish.
  if (!v.allFinite() || !(largest > 0)) return std::nullopt;
  return (v / largest).normalized();
}

std::optional<Vec3> upAcross(const Vec3& forward, const Vec3& up) {
  const std::optional<Vec3> upDirection = direction(up);
  if (!upDirection) return std::nullopt;
  const Vec3 across = *upDirection - forward * forward.dot(*upDirection);
  if (!(across.norm() > kMinUpSine)) return std::nullopt;
  // What cancellation left along `forward` is taken off a second time.
  const Vec3 unit = across.normalized();
  return (unit - forward * forward.dot(unit)).normalized();
}

Vec3 anyUpAcross(const Vec3& forward) {
  constexpr double kUnreliableSine = 0.1;
  const Vec3 y = Vec3::UnitY() - forward * forward.y();
  if (y.norm() > kUnreliableSine) return *upAcross(forward, y);
  return *upAcross(forward, Vec3::UnitZ());
}

}  // namespace tessera
