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
  placed.errorPerUnit = kSlack * (magnitude.transpose() * (plane.errorPerUnit + 4 * u * n) +
                                  12 * u * placed.normal.cwiseAbs());
  placed.errorPerUnit += Vec3::Constant(0x1p-1000);  // products that underflow
  placed.errorConstant = kSlack * (plane.errorConstant + (plane.errorPerUnit + 6 * u * n).dot(tau) +
                                   8 * u * std::abs(placed.distance));
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
  place(primary_, linear, offset);
  for (FrustumPlanes& tile : tiles_)
    place(tile, linear, offset);
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (!nodes_[i].isLeaf()) bisections_[i] = inModelSpace(bisections_[i], linear, offset);
  }
}

}  // namespace tessera
