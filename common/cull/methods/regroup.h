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
  work.tasks.push_back({.node = 0, .frustum = frustum, .mask = mask, .isGroup = true});
  work.groups.push_back(group);
}

/// Sends `nodes` (a range of node indices) down from the bisection of `at`, which cuts what they have in
/// common: those in L and in R regrouped, those in C one by one.
template <class View, class Nodes>
void unfoldRegrouped(const Context& context, const Nodes& nodes, std::uint32_t at, std::uint32_t mask) {
  Workspace& work = context.work;
  const FrustumHierarchy::Node& frustum = context.frusta.node(at);
  work.left.clear(), work.right.clear(), work.cut.clear();
  for (const std::uint32_t node : nodes) {
    View bounds(context.oh, node, context.frusta.eye());
    const Side side = context.bisect(bounds, at);
    (side == Side::Outside ? work.left : side == Side::Inside ? work.right : work.cut).push_back(node);
  }
  // Groups are taken off in the reverse order of their making: what is tasked last must be grouped last.
  pushHalf(context, work.right, frustum.positive, mask & frustum.keepPositive);
  pushHalf(context, work.left, frustum.negative, mask & frustum.keepNegative);
  for (auto node = work.cut.rbegin(); node != work.cut.rend(); ++node)
    work.tasks.push_back({.node = *node, .frustum = at, .mask = mask, .isCut = true});
}

/// The same for the children of a node; of too few to make a group none is looked at here.
template <class View>
void unfoldRegrouped(const Context& context, const Task& task, std::uint32_t mask) {
  std::vector<std::uint32_t>& children = context.work.children;
  children.clear();
  const std::uint32_t end = context.oh.subtreeEnd(task.node);
  for (std::uint32_t child = task.node + 1; child != end; child = context.oh.subtreeEnd(child))
    children.push_back(child);
  if (children.size() < context.switches().regroupFrom) {
    context.pushChildren(task, mask);
  } else {
    unfoldRegrouped<View>(context, children, task.frustum, mask);
  }
}

/// Tests a group's box against what is left of the primary frustum. False: outside.
inline bool testGroup(const Context& context, AabbView& bounds, std::uint32_t& mask) {
  for (std::uint32_t p = 0; p < context.frusta.primary().count; ++p) {
    if (!(mask & (1u << p))) continue;
    ++context.counts().primary;
    const Side side = bounds.side(context.frusta.primary().planes[p], context.counts());
    if (side == Side::Outside) return false;
    if (side == Side::Inside && context.switches().planeMasking) mask &= ~(1u << p);
  }
  return true;
}

/// A group goes down FH as one node would. Where a bisection cuts its box its members are regrouped; where FH
/// ends and planes are left they go on one by one.
template <class View>
void cullPseudoGroup(const Context& context, Task task) {
  Workspace& work = context.work;
  // Groups made after this one have been taken off, so its members are the last.
  const PseudoGroup group = work.groups.back();
  work.groups.pop_back();
  work.children.assign(work.members.begin() + group.firstMember, work.members.end());
  work.members.resize(group.firstMember);
  AabbView bounds(group.box, context.frusta.eye());
  if (!testGroup(context, bounds, task.mask)) return;
  while (!context.frusta.node(task.frustum).isLeaf()) {
    const FrustumHierarchy::Node& frustum = context.frusta.node(task.frustum);
    const Side side = context.bisect(bounds, task.frustum);
    if (side == Side::Intersecting) {
      unfoldRegrouped<View>(context, work.children, task.frustum, task.mask);
      return;
    }
    const bool positive = side == Side::Inside;
    task.mask &= positive ? frustum.keepPositive : frustum.keepNegative;
    task.frustum = positive ? frustum.positive : frustum.negative;
  }
  const auto tiles = context.frusta.leafTiles(context.frusta.node(task.frustum));
  const bool isInside = std::all_of(tiles.begin(), tiles.end(), [&](const FrustumHierarchy::LeafTile& leaf) {
    return leaf.mask == 0 && (!leaf.boundedByPrimary || task.mask == 0);
  });
  if (!isInside) {
    for (auto node = work.children.rbegin(); node != work.children.rend(); ++node)
      work.tasks.push_back({.node = *node, .frustum = task.frustum, .mask = task.mask});
    return;
  }
  for (const FrustumHierarchy::LeafTile& leaf : tiles) {
    for (const std::uint32_t node : work.children)
      context.emit(leaf.tile, node);
  }
}

}  // namespace tessera::cull
