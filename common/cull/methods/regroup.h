#pragma once

#include <algorithm>

#include "common/cull/workspace.h"

// Pseudo-groups (Nirnimesh, Harish, Narayanan 2006, section 4.2): the children of a cut node that lie on one
// side of the bisection go on as one, under a box recomputed for them, as long as no plane cuts it.
namespace tessera::cull {

/// Pushes `nodes` for one half of a bisection: as a group where there are enough of them, else one by one.
inline void pushHalf(const Context& context, const std::vector<std::uint32_t>& nodes, std::uint32_t frustum,
                     std::uint32_t mask) {
  Workspace& work = context.work;
  if (nodes.size() < std::max(2u, context.switches().regroupFrom)) {
    for (auto node = nodes.rbegin(); node != nodes.rend(); ++node)
      work.tasks.push_back({.node = *node, .frustum = frustum, .mask = mask});
    return;
  }
  ++context.counts().groups;
  PseudoGroup group;
  group.firstMember = static_cast<std::uint32_t>(work.members.size());
  for (const std::uint32_t node : nodes) {
    group.box.extend(context.oh.aabb(node));
    work.members.push_back(node);
  }
  group.endMember = static_cast<std::uint32_t>(work.members.size());
  work.tasks.push_back({.node = static_cast<std::uint32_t>(work.groups.size()),
                        .frustum = frustum,
                        .mask = mask,
                        .isGroup = true});
  work.groups.push_back(group);
}

/// Unfolds a node that the bisection of task.frustum cuts: its children into L, C and R.
template <class View>
void unfoldRegrouped(const Context& context, const Task& task, std::uint32_t mask) {
  Workspace& work = context.work;
  const FrustumHierarchy::Node& frustum = context.frusta.node(task.frustum);
  work.left.clear(), work.right.clear();
  const std::size_t firstCut = work.tasks.size();
  const std::uint32_t end = context.oh.subtreeEnd(task.node);
  for (std::uint32_t child = task.node + 1; child != end; child = context.oh.subtreeEnd(child)) {
    View bounds(context.oh, child, context.frusta.eye());
    switch (context.bisect(bounds, task.frustum)) {
      case Side::Outside:
        work.left.push_back(child);
        break;
      case Side::Inside:
        work.right.push_back(child);
        break;
      case Side::Intersecting:
        work.tasks.push_back({.node = child, .frustum = task.frustum, .mask = mask, .isCut = true});
        break;
    }
  }
  std::reverse(work.tasks.begin() + static_cast<std::ptrdiff_t>(firstCut), work.tasks.end());
  pushHalf(context, work.right, frustum.positive, mask & frustum.keepPositive);
  pushHalf(context, work.left, frustum.negative, mask & frustum.keepNegative);
}

/// A group goes down FH as one node would; where its box is cut, or FH ends and planes are left, its members
/// go on from there one by one.
inline void cullPseudoGroup(const Context& context, Task task) {
  Workspace& work = context.work;
  const PseudoGroup group = work.groups[task.node];
  AabbView bounds(group.box, context.frusta.eye());
  // Groups are taken off in the reverse order of their making, so the members end here.
  const auto dissolve = [&] {
    for (std::uint32_t m = group.endMember; m-- > group.firstMember;)
      work.tasks.push_back({.node = work.members[m], .frustum = task.frustum, .mask = task.mask});
    work.members.resize(group.firstMember);
    work.groups.pop_back();
  };
  for (std::uint32_t p = 0; p < context.frusta.primary().count; ++p) {
    if (!(task.mask & (1u << p))) continue;
    ++context.counts().primary;
    const Side side = bounds.side(context.frusta.primary().planes[p], context.counts());
    if (side == Side::Inside && context.switches().planeMasking) task.mask &= ~(1u << p);
    if (side == Side::Outside) {
      work.members.resize(group.firstMember);
      work.groups.pop_back();
      return;
    }
  }
  while (!context.frusta.node(task.frustum).isLeaf()) {
    const FrustumHierarchy::Node& frustum = context.frusta.node(task.frustum);
    const Side side = context.bisect(bounds, task.frustum);
    if (side == Side::Intersecting) break;
    const bool positive = side == Side::Inside;
    task.mask &= positive ? frustum.keepPositive : frustum.keepNegative;
    task.frustum = positive ? frustum.positive : frustum.negative;
  }
  const FrustumHierarchy::Node& end = context.frusta.node(task.frustum);
  if (end.isLeaf() && task.mask == 0) {
    const auto tiles = context.frusta.leafTiles(end);
    if (std::all_of(tiles.begin(), tiles.end(), [](const auto& leaf) { return leaf.mask == 0; })) {
      for (const FrustumHierarchy::LeafTile& leaf : tiles) {
        for (std::uint32_t m = group.firstMember; m < group.endMember; ++m)
          context.emit(leaf.tile, work.members[m]);
      }
      work.members.resize(group.firstMember);
      work.groups.pop_back();
      return;
    }
  }
  dissolve();
}

}  // namespace tessera::cull
