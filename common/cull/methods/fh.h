#pragma once

#include "common/cull/methods/first_level.h"

namespace tessera::cull {

/// Takes a terminal node down the FH from `frustum` on: to one half where a bisection does not cut it, to
/// both where it does; at a leaf of FH the terminal test against what the way there has not implied.
template <class View>
void placeTerminal(const Context& context, View& bounds, std::uint32_t node, std::uint32_t frustum) {
  std::vector<std::uint32_t>& stack = context.work.frustumStack;
  stack.assign(1, frustum);
  while (!stack.empty()) {
    std::uint32_t at = stack.back();
    stack.pop_back();
    while (!context.frusta.node(at).isLeaf()) {
      const FrustumHierarchy::Node& inner = context.frusta.node(at);
      const Side side = context.bisect(bounds, at);
      if (side == Side::Intersecting) stack.push_back(inner.positive);
      at = side == Side::Inside ? inner.positive : inner.negative;
    }
    for (const FrustumHierarchy::LeafTile& leaf : context.frusta.leafTiles(context.frusta.node(at))) {
      if (context.isListed(leaf.tile, node)) continue;
      std::uint32_t mask = leaf.mask;
      if (mask == 0 || context.testTile(bounds, leaf.tile, node, mask)) context.emit(leaf.tile, node);
    }
  }
}

/// Every terminal node in the primary frustum down the FH, O(n log m) (Nirnimesh, Harish, Narayanan 2006,
/// section 4.2, "FH without OH").
template <class View>
void cullFh(const Context& context) {
  cullFirstLevel<View>(context, context.switches().firstLevel);
  for (const FrontNode& front : context.work.front) {
    for (std::uint32_t node = front.node; node != context.oh.subtreeEnd(front.node); ++node) {
      if (!context.oh.isTerminal(node)) continue;
      View bounds(context.oh, node, context.frusta.eye());
      // Without the first level the sides of the wall, which FH does not have, are met here.
      std::uint32_t mask = context.frusta.primary().all();
      if (!context.switches().firstLevel && !context.testPrimary(bounds, node, mask)) continue;
      placeTerminal(context, bounds, node, 0);
    }
  }
}

}  // namespace tessera::cull
