#include "common/hierarchy/placed_frusta.h"

#include <cmath>

namespace tessera {

BoundedPlane inModelSpace(const BoundedPlane& plane, const Mat3& linear, const Vec3& offset) {
  constexpr double u = kUnitRoundoff;
  constexpr double kSlack = 1 + 32 * u;
  const Mat3 magnitude = linear.cwiseAbs();
  const Vec3 n = plane.normal.cwiseAbs(), tau = offset.cwiseAbs();
  BoundedPlane placed;
  placed.normal = linear.transpose() * plane.normal;
  placed.distance = plane.distance - plane.normal.dot(offset);
  placed.errorPerUnit =
      kSlack * (magnitude.transpose() * (plane.errorPerUnit + 4 * u * n) + 12 * u * placed.normal.cwiseAbs());
  placed.errorConstant = kSlack * (plane.errorConstant + (plane.errorPerUnit + 6 * u * n).dot(tau) +
                                   8 * u * std::abs(placed.distance));
  // As planeThroughEye: to components near 1, so that lengths and sums neither underflow nor overflow; and
  // what products may have lost by underflow.
  const double largest = placed.normal.cwiseAbs().maxCoeff();
  int exponent = 0;
  if (largest > 0 && std::isfinite(largest)) std::frexp(largest, &exponent);
  const auto scale = [exponent](double x) { return std::ldexp(x, -3 - exponent); };
  placed.normal = placed.normal.unaryExpr(scale);
  placed.distance = scale(placed.distance);
  placed.errorPerUnit = (placed.errorPerUnit + Vec3::Constant(0x1p-1000)).unaryExpr(scale);
  placed.errorConstant = scale(placed.errorConstant + 0x1p-1000) + 0x1p-1060;
  return placed;
}

void PlacedFrusta::place(FrustumPlanes& planes, const Mat3& linear, const Vec3& offset) const {
  for (std::uint32_t p = 0; p < planes.count; ++p)
    planes.planes[p] = inModelSpace(planes.planes[p], linear, offset);
}

void PlacedFrusta::update(const FrustumHierarchy& world, const Mat4& modelToWorld) {
  FrustumHierarchy::operator=(world);
  const Mat3 linear = modelToWorld.topLeftCorner<3, 3>();
  const Vec3 offset = modelToWorld.topRightCorner<3, 1>() - world.eye();
  eye_ = Vec3::Zero();
  grid_.reset();  // its functionals are exact in the world alone
  place(primary_, linear, offset);
  for (FrustumPlanes& tile : tiles_)
    place(tile, linear, offset);
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (!nodes_[i].isLeaf()) bisections_[i] = inModelSpace(bisections_[i], linear, offset);
  }
}

}  // namespace tessera
