#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <osg/Drawable>

#include "common/geometry/vec.h"

namespace tessera {

/// What a drawable draws as indexed triangles, in its local coordinates.
struct DrawableTriangles {
  std::vector<Vec3> vertices;  ///< all that the drawable has, used or not, in full precision
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< points and lines as (p, p, p) and (p, q, q)
  bool hasOther = false;     ///< there were points, lines or primitives that have no triangles
  bool isMalformed = false;  ///< an index is out of range: `triangles` is not complete
};

/// The triangles of any drawable that supports primitive functors, in the order in which they are drawn. Each
/// keeps its winding and its provoking vertex, the last one, so flat shading looks the same. Of primitives
/// without triangles that are neither points nor lines (patches), every vertex is a point.
[[nodiscard]] DrawableTriangles trianglesOf(const osg::Drawable& drawable);

}  // namespace tessera
