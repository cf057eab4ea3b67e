#pragma once

#include <algorithm>

#include "common/cull/methods/first_level.h"

namespace tessera::cull {

/// Algorithm 2 of Nirnimesh, Harish, Narayanan 2006 as printed, for each node that the first level leaves:
/// the node's children are classified (ClassifyLCR) and handed on, those that are cut to both halves; where
/// FH ends the whole node is marked, also where the tile's planes cut it, so it lists much more than the
/// text's version. The listing has no line for a terminal node above a leaf of FH: it would vanish; as the
/// text says "at leaf nodes in OH, only FH traversal remains", it is classified itself. Where leaves of FH do
/// not fill their parents, a check comes before the mark (the text after the listing).
template <class View>
void cullAdaptiveListing(const Context& context) {
  Workspace& work = context.work;
  cullFirstLevel<View>(context, true);
  for (const FrontNode& front : work.front) {
    work.tasks.assign(1, {.node = front.node, .frustum = 0, .mask = 0});
    while (!work.tasks.empty()) {
      const Task task = work.tasks.back();
      work.tasks.pop_back();
      const FrustumHierarchy::Node& frustum = context.frusta.node(task.frustum);
      if (frustum.isLeaf()) {
        for (const FrustumHierarchy::LeafTile& leaf : context.frusta.leafTiles(frustum)) {
          std::uint32_t mask = leaf.mask;
          View bounds(context.oh, task.node, context.frusta.eye());
          if (mask == 0 || context.testTile(bounds, leaf.tile, task.node, mask))
            context.emit(leaf.tile, task.node);
        }
        continue;
      }
      const std::size_t start = work.tasks.size();
      const auto classify = [&](std::uint32_t node) {
        View bounds(context.oh, node, context.frusta.eye());
        const Side side = context.bisect(bounds, task.frustum);
        if (side != Side::Inside)
          work.tasks.push_back({.node = node, .frustum = frustum.negative, .mask = 0});
        if (side != Side::Outside)
          work.tasks.push_back({.node = node, .frustum = frustum.positive, .mask = 0});
      };
      if (context.oh.isTerminal(task.node)) {
        classify(task.node);
      } else {
        const std::uint32_t end = context.oh.subtreeEnd(task.node);
        for (std::uint32_t child = task.node + 1; child != end; child = context.oh.subtreeEnd(child))
          classify(child);
      }
      std::reverse(work.tasks.begin() + static_cast<std::ptrdiff_t>(start), work.tasks.end());
    }
  }
}

}  // namespace tessera::cull
