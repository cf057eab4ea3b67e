#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/column.h"
#include "common/geometry/box.h"
#include "common/hierarchy/enclosing_bounds.h"
#include "common/hierarchy/visible_list.h"

namespace tessera {

/// Bounds of points, each known to within `margin` per axis. At least one point; all finite.
[[nodiscard]] Bounds boundsOf(std::span<const Vec3> points, const Vec3& margin);

/// The object hierarchy (OH) of a scene as flat arrays in depth-first pre-order. Node 0 is the root; the
/// first child follows its parent, the next sibling is one jump away (of a binary tree: the right child's
/// index, as in Koblizek's term project, section 2.1). A node without children is terminal and holds one leaf
/// or, where a builder grouped small ones, several. Leaf ids count in the same order, so the leaves below any
/// node are one range. An empty hierarchy has no nodes.
class ObjectHierarchy {
 public:
  [[nodiscard]] std::uint32_t nodeCount() const { return static_cast<std::uint32_t>(subtreeEnd_.size()); }
  [[nodiscard]] std::uint32_t leafCount() const { return static_cast<std::uint32_t>(leafNode_.size()); }
  [[nodiscard]] bool empty() const { return subtreeEnd_.empty(); }

  /// One past the last node of the subtree: the next node in pre-order that is not below `node`.
  [[nodiscard]] std::uint32_t subtreeEnd(std::uint32_t node) const { return subtreeEnd_[node]; }
  /// True for a node without children.
  [[nodiscard]] bool isTerminal(std::uint32_t node) const { return subtreeEnd_[node] == node + 1; }
  [[nodiscard]] LeafRange leaves(std::uint32_t node) const {
    return {leafBegin_[node], leafBegin_[subtreeEnd_[node]]};
  }
  /// kNoParent for the root.
  [[nodiscard]] std::uint32_t parent(std::uint32_t node) const { return parent_[node]; }
  /// The terminal node that holds the leaf.
  [[nodiscard]] std::uint32_t nodeOfLeaf(std::uint32_t leaf) const { return leafNode_[leaf]; }

  [[nodiscard]] const Aabb& aabb(std::uint32_t node) const { return aabbs_[node]; }
  [[nodiscard]] const Obb& obb(std::uint32_t node) const { return obbs_[node]; }
  [[nodiscard]] const Sphere& sphere(std::uint32_t node) const { return spheres_[node]; }

  /// True for a node whose bounds, or those of something below it, change from frame to frame.
  [[nodiscard]] bool isMoving(std::uint32_t node) const { return moving_[node] != 0; }
  /// Changes whenever any bound does: what was remembered of this hierarchy's bounds is then void.
  [[nodiscard]] std::uint64_t revision() const { return revision_; }
  /// The leaves whose bounds the last revision changed, in no order; some may be there twice.
  [[nodiscard]] std::span<const std::uint32_t> changedLeaves() const { return changedLeaves_; }

  /// Leaves that are not there now, as behind a switch that is off: no culler lists them. Their bounds count
  /// for the nodes above them all the same, so that they come back without a refit and what cullers remember
  /// of bounds stays valid.
  [[nodiscard]] const VisibleList& absentLeaves() const { return absent_; }
  /// A canonical list of leaves of this hierarchy; a bug otherwise. Not while a culler runs.
  void setAbsentLeaves(const VisibleList& leaves);

  /// Edges on the longest path from the root; children of inner nodes on average.
  [[nodiscard]] std::uint32_t depth() const;
  [[nodiscard]] double meanBranching() const;

  static constexpr std::uint32_t kNoParent = UINT32_MAX;

  /// The arrays of a hierarchy in which nothing has moved, for storing it. All by node but `leafNode`.
  struct Arrays {
    Column<std::uint32_t> subtreeEnd, parent;
    Column<std::uint32_t> leafBegin;  ///< one more than nodes: the last entry is the number of leaves
    Column<std::uint32_t> leafNode;   ///< by leaf
    Column<Aabb> aabbs;
    Column<Obb> obbs;
    Column<Sphere> spheres;
  };
  ObjectHierarchy() = default;
  /// From arrays of a hierarchy before; the caller answers for their content.
  explicit ObjectHierarchy(Arrays arrays);
  /// Calls visit(array) for each, in the order of Arrays.
  template <class Visit>
  void visitArrays(Visit visit) const {
    visit(subtreeEnd_), visit(parent_), visit(leafBegin_), visit(leafNode_);
    visit(aabbs_), visit(obbs_), visit(spheres_);
  }

 private:
  friend class ObjectHierarchyBuilder;
  friend class BoundsRefit;
  Column<std::uint32_t> subtreeEnd_;
  Column<std::uint32_t> leafBegin_;  ///< one more than nodes: the last entry is the number of leaves
  Column<std::uint32_t> parent_;
  Column<std::uint32_t> leafNode_;
  Column<Aabb> aabbs_;
  Column<Obb> obbs_;
  Column<Sphere> spheres_;
  std::vector<std::uint8_t> moving_;
  std::uint64_t revision_ = 0;
  std::vector<std::uint32_t> changedLeaves_;
  VisibleList absent_;
};

/// Builds an ObjectHierarchy from a pre-order walk: openNode, addLeaf and closeNode in the order of the
/// scene. Inner nodes with nothing below them vanish; one with a single child gives way to that child, as
/// its bounds would be the same. The bounds of inner nodes are computed in finish, bottom-up: the box by PCA
/// over the corners of the children's boxes (Nirnimesh, Harish, Narayanan 2006, Algorithm 1).
class ObjectHierarchyBuilder {
 public:
  ObjectHierarchyBuilder();
  void openNode();
  /// Returns the leaf's id.
  std::uint32_t addLeaf(const Bounds& bounds) { return addGroup({&bounds, 1}); }
  /// Adds a terminal node that holds several leaves under one bound. Returns the first one's id.
  std::uint32_t addGroup(std::span<const Bounds> leaves);
  void closeNode();
  /// Every opened node must be closed. What lies outside any node is put under one root.
  [[nodiscard]] ObjectHierarchy finish();

 private:
  struct Links {
    std::uint32_t subtreeEnd, leafBegin, parent;
  };
  static constexpr std::uint32_t kOpen = UINT32_MAX;  ///< subtreeEnd of a node still open

  void append(const Links& links, const Bounds& bounds);
  void removeLast();
  void close();
  void computeInnerBounds();
  ObjectHierarchy oh_;
  EnclosingBounds enclosing_;
  std::vector<std::uint32_t> open_;
  std::vector<bool> dropped_;  ///< nodes that give way to their only child in finish
};

}  // namespace tessera
