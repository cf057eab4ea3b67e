#pragma once

#include "common/cull/workspace.h"

namespace tessera::cull {

/// Culls the OH to the primary frustum (Nirnimesh, Harish, Narayanan 2006, section 4.2: "a first level
/// culling to the primary view frustum"). Leaves the front: maximal subtrees inside it and terminal nodes
/// that it cuts, in pre-order; and marks the nodes found outside. Without `culls` the front is the root.
template <class View>
void cullFirstLevel(const Context& context, bool culls) {
  Workspace& work = context.work;
  work.front.clear();
  const std::uint32_t all = context.frusta.primary().all();
  if (!culls) {
    work.front.push_back({0, all});
    return;
  }
  work.outsideFrame.resize(context.oh.nodeCount(), 0);
  ++work.frame;
  work.tasks.assign(1, {.node = 0, .frustum = 0, .mask = all});
  while (!work.tasks.empty()) {
    const Task task = work.tasks.back();
    work.tasks.pop_back();
    View bounds(context.oh, task.node, context.frusta.eye());
    std::uint32_t mask = task.mask;
    if (!context.testPrimary(bounds, task.node, mask)) {
      work.outsideFrame[task.node] = work.frame;
    } else if (mask == 0 || context.oh.isTerminal(task.node)) {
      work.front.push_back({task.node, mask});
    } else {
      context.pushChildren(task, context.inherited(task.mask, mask));
    }
  }
}

}  // namespace tessera::cull
