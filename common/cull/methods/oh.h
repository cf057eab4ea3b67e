#pragma once

#include "common/cull/methods/first_level.h"

namespace tessera::cull {

/// The OH once for each tile, O(m log n) (Nirnimesh, Harish, Narayanan 2006, section 4.2, "OH without FH").
/// Nodes that the first level found outside are not entered again.
template <class View>
void cullOh(const Context& context) {
  Workspace& work = context.work;
  const bool firstLevel = context.switches().firstLevel;
  if (firstLevel) cullFirstLevel<View>(context, true);
  for (std::uint32_t tile = 0; tile < context.frusta.tileCount(); ++tile) {
    work.tasks.assign(1, {.node = 0, .frustum = tile, .mask = context.frusta.tile(tile).all()});
    while (!work.tasks.empty()) {
      const Task task = work.tasks.back();
      work.tasks.pop_back();
      if (firstLevel && work.outsideFrame[task.node] == work.frame) continue;
      View bounds(context.oh, task.node, context.frusta.eye());
      std::uint32_t mask = task.mask;
      if (!context.testTile(bounds, tile, task.node, mask)) continue;
      if (mask == 0 || context.oh.isTerminal(task.node)) {
        context.emit(tile, task.node);
      } else {
        context.pushChildren(task, context.inherited(task.mask, mask));
      }
    }
  }
}

}  // namespace tessera::cull
