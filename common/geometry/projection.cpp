#include "common/geometry/projection.h"

#include <Eigen/Geometry>

namespace tessera {

Mat4 relativeViewProjection(const std::array<Vec3, 4>& corners, const Vec3& axis, double near, double far) {
  const Vec3 right = (corners[1] - corners[0]).normalized();
  const Vec3 up = right.cross(axis).normalized();
  // The rectangle's edges at depth 1 (generalized perspective projection, Kooima 2009).
  const double depth = axis.dot(corners[0]);
  const double l = right.dot(corners[0]) / depth, r = right.dot(corners[1]) / depth;
  const double b = up.dot(corners[0]) / depth, t = up.dot(corners[3]) / depth;
  Mat4 projection = Mat4::Zero();
  projection(0, 0) = 2 / (r - l);
  projection(0, 2) = (r + l) / (r - l);
  projection(1, 1) = 2 / (t - b);
  projection(1, 2) = (t + b) / (t - b);
  projection(2, 2) = -(far + near) / (far - near);
  projection(2, 3) = -2 * far * near / (far - near);
  projection(3, 2) = -1;
  Mat4 view = Mat4::Identity();
  view.row(0).head<3>() = right;
  view.row(1).head<3>() = up;
  view.row(2).head<3>() = -axis;
  return projection * view;
}

std::array<Eigen::Vector4d, 6> gribbHartmannPlanes(const Mat4& toClip) {
  const Eigen::Vector4d x = toClip.row(0), y = toClip.row(1), z = toClip.row(2), w = toClip.row(3);
  return {w + x, w - x, w + y, w - y, w + z, w - z};
}

}  // namespace tessera
