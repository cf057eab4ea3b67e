#pragma once

#include <Eigen/Geometry>

#include "common/geometry/vec.h"
#include "common/scene/synthetic/trig.h"

namespace tessera::synthetic {

using Quat = Eigen::Quaterniond;

/// Where a part or a node is: parent = position + rotation * (scale * local). Metres, y up.
struct Placement {
  Vec3 positionM = Vec3::Zero();
  Quat rotation = Quat::Identity();
  Vec3 scale = Vec3::Ones();
};

[[nodiscard]] inline Placement at(double x, double y, double z) {
  return {.positionM = {x, y, z}};
}
[[nodiscard]] inline Placement at(const Vec3& positionM) {
  return {.positionM = positionM};
}

/// Counter-clockwise from above.
[[nodiscard]] inline Quat turnY(double angleRad) {
  const SinCos half = sinCos(angleRad / 2);
  return {half.cos, 0, half.sin, 0};
}

[[nodiscard]] inline Quat turnX(double angleRad) {
  const SinCos half = sinCos(angleRad / 2);
  return {half.cos, half.sin, 0, 0};
}

[[nodiscard]] inline Quat turnZ(double angleRad) {
  const SinCos half = sinCos(angleRad / 2);
  return {half.cos, 0, 0, half.sin};
}

[[nodiscard]] inline Placement at(const Vec3& positionM, const Quat& rotation) {
  return {.positionM = positionM, .rotation = rotation};
}

/// The rotation that takes +y to the unit vector `direction`, by the shortest way.
[[nodiscard]] inline Quat yTo(const Vec3& direction) {
  if (direction.y() < -0.999999) return {0, 1, 0, 0};
  return Quat(1 + direction.y(), direction.z(), 0, -direction.x()).normalized();
}

/// The rotation whose columns are x, y and x cross y; both are unit and perpendicular.
[[nodiscard]] inline Quat fromAxes(const Vec3& x, const Vec3& y) {
  Mat3 m;
  m << x, y, x.cross(y);
  return Quat(m).normalized();
}

}  // namespace tessera::synthetic
