#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <osg/Drawable>
#include <osg/Geometry>
#include <osg/ref_ptr>

namespace tessera {

/// A drawable in parts, and the binary tree whose leaves they are.
struct CutTree {
  std::vector<osg::ref_ptr<osg::Geometry>> parts;  ///< in depth-first order
  /// For each node in pre-order the number of parts below it: 1 for a part, more for an inner node.
  std::vector<std::uint32_t> shape;
};

/// Cuts a mesh into parts of at most `maxTriangles` triangles each by top-down midpoint subdivision
/// (Koblizek's term project, 2.1): across the axis of the largest extent of the triangles' centroids, at its
/// middle; in halves by order where that separates nothing. The parts together are exactly the drawable's
/// triangles with their winding; inside a part they keep their order. A part is indexed triangles over arrays
/// of its own that hold the vertices in use alone, in order of first use; it shares the state set and has the
/// same name and flags, but neither callbacks nor user data. Equal input gives equal parts.
///
/// nullopt where it need not or cannot be cut: not a plain osg::Geometry, no more than `maxTriangles`
/// triangles or `maxTriangles` 0, anything drawn but triangles, quads and polygons, instancing, arrays bound
/// other than per vertex or overall, a malformed index or array, a vertex that is not finite.
///
/// Linear in the triangles for each level of the tree; no recursion. Needs some 60 bytes a triangle and 32 a
/// vertex besides the parts.
[[nodiscard]] std::optional<CutTree> cutDrawable(const osg::Drawable& drawable, std::uint64_t maxTriangles);

}  // namespace tessera
