#pragma once

#include <array>
#include <limits>
#include <optional>

#include "common/geometry/frustum.h"
#include "common/hierarchy/frustum_hierarchy.h"

namespace tessera {

/// Where the sides of a frustum come from.
enum class PlaneSource {
  Corners,  ///< cross products of the corners: the frustum's definition
  Matrix,   ///< the rows of the view-projection matrix (Gribb and Hartmann 2001)
};

/// One tile's frustum as the cone of its four corner rays, relative to the eye, and what is certain of it.
struct TileCone {
  std::array<Vec3, 4> corners;              ///< scaled together by a power of two to lengths near 1
  std::array<BoundedPlane, 4> cornerSides;  ///< through the eye and corners i, i + 1
  Vec3 axis = Vec3::Zero();                 ///< unit normal of the image rectangle, away from the eye
  double axisError = std::numeric_limits<double>::infinity();  ///< of the normal of any three corners
  double minDepth = 0;                                         ///< of the corners along the axis; certain
  bool isProper = false;                                       ///< certainly convex and before the eye

  TileCone() = default;
  /// `commonAxis` is that of the wall where the tile lies in its plane.
  TileCone(const Frustum& frustum, const std::optional<Vec3>& commonAxis);

  /// How far the corners stick out over the plane, where sign * plane is negative: a length in the units of
  /// the plane's normal times the corners.
  [[nodiscard]] double overhang(const BoundedPlane& plane, double sign) const;

  /// The four sides, bounded against the frustum's definition. A proper cone for PlaneSource::Matrix; any
  /// other falls back to its corners.
  void sides(FrustumPlanes& planes, PlaneSource source) const;
};

/// Unit normal, away from the eye, of the triangle (corner, next, previous) of an image rectangle given
/// relative to the eye, and a bound of its error as a vector length; infinite where there is none.
struct UnitNormal {
  Vec3 n = Vec3::Zero();
  double error = std::numeric_limits<double>::infinity();
};
[[nodiscard]] UnitNormal normalAt(const std::array<Vec3, 4>& corners, std::size_t i);

/// Adds a plane at `distance` along a unit axis known to within `axisError`; sign 1 for near, -1 for far.
void addDepthPlane(FrustumPlanes& planes, const Vec3& axis, double axisError, double distance, double sign);

}  // namespace tessera
