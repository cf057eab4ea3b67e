#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/cull/options.h"
#include "common/geometry/box.h"
#include "common/hierarchy/object_hierarchy.h"

namespace tessera::cull {

/// Boxes are kept in blocks of so many, component by component, as vector instructions read them.
inline constexpr std::size_t kLanes = 16;

/// Oriented boxes: the leaves. Half-axes are scaled by BoxTree::scale() and rounded to nearest.
struct alignas(64) OrientedBlock {
  double center[3][kLanes];
  float half[9][kLanes];  ///< x, y, z of the first half-axis, then of the others
  float extent[kLanes];   ///< at least the sum of the half-axes' components, and at least 2^-96
};

/// One oriented box, in one line of the cache.
struct alignas(64) OrientedBox {
  double center[3];
  float half[9], extent;
};

/// Puts a box into a lane.
inline void setLane(OrientedBlock& block, std::size_t lane, const OrientedBox& box) {
  for (std::size_t i = 0; i < 3; ++i)
    block.center[i][lane] = box.center[i];
  for (std::size_t i = 0; i < 9; ++i)
    block.half[i][lane] = box.half[i];
  block.extent[lane] = box.extent;
}

/// Axis-aligned boxes: the inner nodes. Half-extents are scaled and rounded up, past the centre's rounding.
struct alignas(64) AlignedBlock {
  double center[3][kLanes];
  float half[3][kLanes];
};

/// The boxes of a scene's leaves in blocks of 16 and, over them, an implicit 16-ary tree: node i of a level
/// holds nodes 16i to 16i + 15 of the level below, or the leaves of block i. As leaf ids count in pre-order,
/// what is near in the scene graph is near in the tree, and the leaves below a node are one range.
class BoxTree {
 public:
  /// Sphere and AabbThenObb bounds are refused by check().
  void build(const ObjectHierarchy& oh, BoundsKind bounds);
  /// Rereads the boxes of some leaves, and refits what is above them. Does not allocate once warm.
  void refit(const ObjectHierarchy& oh, std::span<const std::uint32_t> leaves);

  [[nodiscard]] std::uint32_t leafCount() const { return leafCount_; }
  [[nodiscard]] const std::vector<OrientedBlock>& leaves() const { return leaves_; }
  /// One leaf's box by itself, for those who need few of many; after keepSingles().
  [[nodiscard]] const OrientedBox& leaf(std::uint32_t leaf) const { return singles_[leaf]; }
  void keepSingles();

  /// levels()[0] has a node for each block of leaves; the last level has at most kLanes nodes. None where
  /// there is a single block of leaves.
  struct Level {
    std::vector<AlignedBlock> blocks;
    std::uint32_t nodeCount = 0;
  };
  [[nodiscard]] const std::vector<Level>& levels() const { return levels_; }
  /// A power of two by which lengths are multiplied to come near 1.
  [[nodiscard]] double scale() const { return scale_; }
  /// The box of a leaf as kernels mean it.
  [[nodiscard]] Obb boxOf(const ObjectHierarchy& oh, std::uint32_t leaf) const;

 private:
  [[nodiscard]] OrientedBox single(std::uint32_t leaf) const;
  void setLeaf(std::uint32_t leaf, const Obb& box);
  void setNode(std::size_t level, std::uint32_t node, const Aabb& box);
  [[nodiscard]] Aabb aabbOfNode(const ObjectHierarchy& oh, std::size_t level, std::uint32_t node) const;

  BoundsKind bounds_ = BoundsKind::Obb;
  std::uint32_t leafCount_ = 0;
  double scale_ = 1;
  std::vector<OrientedBlock> leaves_;
  std::vector<OrientedBox> singles_;
  std::vector<Level> levels_;
  std::vector<std::vector<Aabb>> boxes_;  ///< of the nodes, by level
  std::vector<std::uint32_t> touched_;    ///< nodes to refit
};

}  // namespace tessera::cull
