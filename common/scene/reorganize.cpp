#include "common/scene/reorganize.h"

#include <utility>
#include <vector>

namespace tessera {

void reorganize(Scene& scene, HierarchyKind kind, std::uint64_t maxTrianglesPerLeaf) {
  if (kind == HierarchyKind::Graph) return;
  std::vector<Bounds> bounds;
  std::vector<std::uint64_t> triangles;
  bounds.reserve(scene.leaves.size());
  triangles.reserve(scene.leaves.size());
  for (std::uint32_t leaf = 0; leaf < scene.leaves.size(); ++leaf) {
    const std::uint32_t node = scene.hierarchy.nodeOfLeaf(leaf);
    bounds.push_back({scene.hierarchy.aabb(node), scene.hierarchy.obb(node), scene.hierarchy.sphere(node)});
    triangles.push_back(scene.leaves[leaf].triangles);
  }
  SpatialHierarchy built = buildSpatialHierarchy(kind, bounds, triangles, maxTrianglesPerLeaf);
  std::vector<SceneLeaf> leaves;
  leaves.reserve(scene.leaves.size());
  for (const std::uint32_t from : built.order)
    leaves.push_back(scene.leaves[from]);
  scene.leaves = std::move(leaves);
  scene.hierarchy = std::move(built.hierarchy);
}

}  // namespace tessera
