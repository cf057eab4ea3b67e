#pragma once

#include "common/cull/methods/first_level.h"

namespace tessera::cull {

/// Every terminal node in the primary frustum against every tile, O(mn) (Nirnimesh, Harish, Narayanan 2006,
/// section 4.2, "naive approach").
template <class View>
void cullNaive(const Context& context) {
  cullFirstLevel<View>(context, context.switches().firstLevel);
  for (const FrontNode& front : context.work.front) {
    for (std::uint32_t node = front.node; node != context.oh.subtreeEnd(front.node); ++node) {
      if (!context.oh.isTerminal(node)) continue;
      View bounds(context.oh, node, context.frusta.eye());
      for (std::uint32_t tile = 0; tile < context.frusta.tileCount(); ++tile) {
        std::uint32_t mask = context.frusta.tile(tile).all();
        if (context.testTile(bounds, tile, node, mask)) context.emit(tile, node);
      }
    }
  }
}

}  // namespace tessera::cull
