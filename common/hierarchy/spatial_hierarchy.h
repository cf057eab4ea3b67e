#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "common/hierarchy/enclosing_bounds.h"
#include "common/hierarchy/object_hierarchy.h"

namespace tessera {

/// Where the tree over a scene's leaves comes from. Cells and splits only decide which items share a node:
/// every node's bounds are computed from what it holds, so a split can cost time but never drops anything.
enum class HierarchyKind {
  Graph,   ///< the scene graph as its author grouped it
  Bvh,     ///< binary: centroids split at their middle on the axis where they spread most (Koblizek's term
           ///< project, section 2.1; Pharr, Jakob, Humphreys, Physically Based Rendering, 4.3.1)
  Octree,  ///< boxes halved on three axes; what straddles a middle plane stays at the node (Akenine-Moeller
           ///< et al., Real-Time Rendering, 3rd edition, chapter 14)
  LooseOctree,  ///< cells of double size, so that size alone decides an item's level (Ulrich 2000)
  Kd,           ///< axis-aligned binary space partition at the middle of the cell's longest axis; what
                ///< straddles stays at the node (Real-Time Rendering, chapter 14)
};

/// graph, bvh, octree, loose-octree, kd; nothing for any other name.
[[nodiscard]] std::optional<HierarchyKind> hierarchyFromName(std::string_view name);
[[nodiscard]] std::string_view nameOf(HierarchyKind kind);

struct SpatialHierarchy {
  ObjectHierarchy hierarchy;
  std::vector<std::uint32_t> order;  ///< index of the item that became the leaf of this id
};

/// Builds a hierarchy over items by where they are; any kind but Graph. `triangles` are the items' counts.
/// A terminal node holds items of at most `maxTrianglesPerLeaf` triangles together (MTPL; an item counts for
/// at least one); a bigger item stands alone, so a count of UINT64_MAX sets apart an item that will move.
/// With 0 every item has a terminal node of its own.
///
/// Items' boxes are finite and not empty. Equal input gives the equal result on every machine. Time
/// O(n log n): each rule has a limit of depth, below which ranges are halved at their median.
[[nodiscard]] SpatialHierarchy buildSpatialHierarchy(HierarchyKind kind, std::span<const Bounds> items,
                                                     std::span<const std::uint64_t> triangles,
                                                     std::uint64_t maxTrianglesPerLeaf);

}  // namespace tessera
