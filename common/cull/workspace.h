#pragma once

#include <cstdint>
#include <vector>

#include "common/cull/plane_tester.h"
#include "common/cull/result.h"
#include "common/geometry/box.h"
#include "common/hierarchy/object_hierarchy.h"

namespace tessera::cull {

/// Work still to be done: a node of the OH against a node of the FH or, where `isTile`, one tile; with the
/// planes that still matter (of the primary frustum, or of the tile).
struct Task {
  std::uint32_t node, frustum, mask;
  bool isTile = false;
  bool isCut = false;    ///< known to be cut by the FH node's bisection
  bool isGroup = false;  ///< the last of Workspace::groups instead of a node
};

/// Children on one side of a bisection, under a box of their own.
struct PseudoGroup {
  Aabb box;
  std::uint32_t firstMember = 0;  ///< of Workspace::members
};

/// A subtree that the first level leaves: wholly inside the primary frustum, or a cut terminal node.
struct FrontNode {
  std::uint32_t node;
  std::uint32_t mask;  ///< planes of the primary frustum that cut it
};

/// What a culler keeps from frame to frame: results and buffers.
struct Workspace {
  Result result;
  Changes changes;
  std::vector<VisibleList> listsBefore;  ///< of the call before, where changes are asked for
  std::uint32_t tileCount = 0;           ///< of the call before
  bool holdsLists = false;               ///< `result` has that call's lists
  bool togglesAreTables = false;         ///< `changes` has what the table's last changes were
  bool holdsTable = false;               ///< the table of footprints has them
  bool isThinned = false;                ///< absent leaves were taken out of `result`, not out of the table
  VisibleList thinned;
  PlaneTester tester;
  std::vector<Task> tasks;
  std::vector<std::uint32_t> frustumStack;
  std::vector<FrontNode> front;
  std::vector<std::uint32_t> outsideFrame;  ///< by node: the last frame in which it was outside the primary
  std::uint32_t frame = 0;
  std::vector<PseudoGroup> groups;                        ///< of the tasks, in their order
  std::vector<std::uint32_t> members;                     ///< of the groups, in their order
  std::vector<std::uint32_t> children, left, right, cut;  ///< of what is being unfolded
  bool isUnordered = false;                               ///< some list grew out of order and must be sorted
};

/// One frame's work: the inputs and the workspace.
struct Context {
  const ObjectHierarchy& oh;
  const FrustumHierarchy& frusta;
  const Options& options;
  Workspace& work;

  [[nodiscard]] const Switches& switches() const { return options.switches; }
  [[nodiscard]] TestCounts& counts() const { return work.result.tests; }

  /// Lists the leaves below a node for a tile. Mostly in order; finishLists mends the rest.
  void emit(std::uint32_t tile, std::uint32_t node) const;

  /// True where the node has reached the tile before, by way of another half of FH.
  [[nodiscard]] bool isListed(std::uint32_t tile, std::uint32_t node) const {
    const VisibleList& list = work.result.lists[tile];
    const LeafRange range = oh.leaves(node);
    return !list.empty() && list.back().first <= range.first && range.last <= list.back().last;
  }

  template <class View>
  [[nodiscard]] Side bisect(View& bounds, std::uint32_t frustum) const {
    ++counts().bisection;
    return bounds.side(frusta.bisection(frustum), counts());
  }
  template <class View>
  [[nodiscard]] bool testPrimary(View& bounds, std::uint32_t node, std::uint32_t& mask) const {
    return work.tester.test(bounds, frusta.primary(), 0, node, mask, counts());
  }
  template <class View>
  [[nodiscard]] bool testTile(View& bounds, std::uint32_t tile, std::uint32_t node,
                              std::uint32_t& mask) const {
    return work.tester.test(bounds, frusta.tile(tile), 1 + tile, node, mask, counts());
  }

  /// The mask for the children of a node that arrived with `before` and leaves its test with `after`.
  [[nodiscard]] std::uint32_t inherited(std::uint32_t before, std::uint32_t after) const {
    return switches().planeMasking ? after : before;
  }

  /// Pushes a task for each child of `task.node`, so that the first child is popped first: lists then grow in
  /// order.
  void pushChildren(const Task& task, std::uint32_t mask) const;
};

/// Sorts and merges lists that grew out of order.
void finishLists(Workspace& work);

}  // namespace tessera::cull
