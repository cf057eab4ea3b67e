#pragma once

#include "common/geometry/bounded_plane.h"

namespace tessera::bench {

/// The plain test, as one would write it who does not mind what rounding does: for measuring what the bound
/// costs. It drops what is visible.
template <class RelativeBounds>
Side classifyUnbounded(const RelativeBounds& bounds, const BoundedPlane& plane) {
  const double value = plane.normal.dot(bounds.d) - plane.distance;
  const double radius = bounds.radius(plane.normal);
  if (value + radius < 0) return Side::Outside;
  if (value - radius >= 0) return Side::Inside;
  return Side::Intersecting;
}

}  // namespace tessera::bench
