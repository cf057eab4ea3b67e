#pragma once

#include <algorithm>

#include "common/cull/methods/fh.h"
#include "common/cull/methods/regroup.h"

namespace tessera::cull {

/// An inner node at a leaf of FH: listed where nothing can be outside any more, else unfolded against what is
/// left of the planes.
inline void arrive(const Context& context, const Task& task, std::uint32_t mask, std::uint32_t childMask) {
  for (const FrustumHierarchy::LeafTile& leaf : context.frusta.leafTiles(context.frusta.node(task.frustum))) {
    if (leaf.mask == 0 && (!leaf.boundedByPrimary || mask == 0)) {
      context.emit(leaf.tile, task.node);
    } else if (leaf.mask == 0) {
      context.pushChildren(task, childMask);
    } else {
      context.work.tasks.push_back(
          {.node = task.node, .frustum = leaf.tile, .mask = leaf.mask, .isTile = true});
    }
  }
}

/// A node that has arrived at a tile and is culled to it alone.
template <class View>
void cullToTile(const Context& context, const Task& task) {
  View bounds(context.oh, task.node, context.frusta.eye());
  std::uint32_t mask = task.mask;
  if (!context.testTile(bounds, task.frustum, task.node, mask)) return;
  if (mask == 0 || context.oh.isTerminal(task.node)) {
    context.emit(task.frustum, task.node);
  } else {
    context.pushChildren(task, context.inherited(task.mask, mask));
  }
}

template <class View>
void cullAdaptiveNode(const Context& context, Task task) {
  View bounds(context.oh, task.node, context.frusta.eye());
  std::uint32_t mask = task.mask;
  if (!context.testPrimary(bounds, task.node, mask)) return;
  if (context.oh.isTerminal(task.node)) {
    placeTerminal(context, bounds, task.node, task.frustum);
    return;
  }
  std::uint32_t childMask = context.inherited(task.mask, mask);
  while (!context.frusta.node(task.frustum).isLeaf()) {
    const FrustumHierarchy::Node& frustum = context.frusta.node(task.frustum);
    const Side side = task.isCut ? Side::Intersecting : context.bisect(bounds, task.frustum);
    if (side == Side::Intersecting) {
      if (context.switches().regroup) {
        unfoldRegrouped<View>(context, task, childMask);
      } else {
        context.pushChildren(task, childMask);
      }
      return;
    }
    const bool positive = side == Side::Inside;
    const std::uint32_t keep = positive ? frustum.keepPositive : frustum.keepNegative;
    mask &= keep;
    childMask &= keep;
    task.frustum = positive ? frustum.positive : frustum.negative;
  }
  arrive(context, task, mask, childMask);
}

/// The adaptive algorithm as the text of Nirnimesh, Harish, Narayanan 2006, section 4.2, describes it: the FH
/// is descended while the node is uncut, the OH unfolded where it is cut; at a leaf of FH the OH is culled to
/// what is left of the tile's planes. The primary frustum is culled to in the same traversal: a tile of a
/// grid is bounded by the bisections on its path and by sides of the primary frustum, so `mask` holds what is
/// left.
template <class View>
void cullAdaptive(const Context& context) {
  Workspace& work = context.work;
  work.tasks.assign(1, {.node = 0, .frustum = 0, .mask = context.frusta.primary().all()});
  work.groups.clear();
  work.members.clear();
  while (!work.tasks.empty()) {
    const Task task = work.tasks.back();
    work.tasks.pop_back();
    if (task.isGroup) {
      cullPseudoGroup<View>(context, task);
    } else if (task.isTile) {
      cullToTile<View>(context, task);
    } else {
      cullAdaptiveNode<View>(context, task);
    }
  }
}

}  // namespace tessera::cull
