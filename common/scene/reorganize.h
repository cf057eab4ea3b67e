#pragma once

#include <cstdint>

#include "common/hierarchy/spatial_hierarchy.h"
#include "common/scene/scene.h"

namespace tessera {

/// Replaces the hierarchy of the scene's graph by one made from the leaves' places alone
/// (spatial_hierarchy.h) and brings the leaves into its order: leaf ids are positions in it,
/// SceneLeaf::graphLeaf keeps the graph's. Leaves of at most `maxTrianglesPerLeaf` triangles together share a
/// terminal node; 0: each has its own. Nothing to do for HierarchyKind::Graph.
void reorganize(Scene& scene, HierarchyKind kind, std::uint64_t maxTrianglesPerLeaf);

}  // namespace tessera
