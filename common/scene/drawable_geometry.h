#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <osg/Drawable>

#include "common/geometry/vec.h"

namespace tessera {

/// What a drawable draws, in its local coordinates.
struct DrawableGeometry {
  std::vector<Vec3> points;  ///< every vertex that a primitive uses, once
  std::uint64_t triangles = 0;
  std::uint64_t primitives = 0;  ///< points, lines and polygons of any kind
  std::string problem;  ///< what is malformed (an index out of range, a number that is not finite), or empty
};

/// Collects the vertices of any drawable that supports primitive functors, in full precision.
[[nodiscard]] DrawableGeometry geometryOf(const osg::Drawable& drawable);

}  // namespace tessera
