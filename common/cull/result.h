#pragma once

#include <cstdint>
#include <vector>

#include "common/hierarchy/visible_list.h"

namespace tessera::cull {

/// Tests of one frame, by what was tested and by what was spared.
struct TestCounts {
  std::uint64_t sphere = 0, aabb = 0, obb = 0;  ///< bound-plane classifications
  std::uint64_t primary = 0, bisection = 0,
                tile = 0;  ///< bounds against whose planes; a "first, then" is one
  std::uint64_t nodes =
      0;  ///< (node, frustum) visits; of footprints: blocks of boxes, or leaves of the table
  std::uint64_t remembered = 0;    ///< rejections by a remembered distance, without a test
  std::uint64_t octantSpared = 0;  ///< planes left out by the octant test
  std::uint64_t groups = 0;        ///< pseudo-groups formed

  [[nodiscard]] std::uint64_t classifications() const { return sphere + aabb + obb; }
  TestCounts& operator+=(const TestCounts& other);
};

struct Result {
  std::vector<VisibleList> lists;  ///< one for each tile, in the order of the tiles
  TestCounts tests;
  std::uint64_t pairs = 0;  ///< (leaf, tile) pairs listed
};

/// What a frame changes in the lists of the frame before.
struct Changes {
  /// By tile: the leaves that are in exactly one of the two lists, as a canonical list of its own.
  std::vector<VisibleList> toggled;
  std::vector<std::uint32_t> leafCounts;  ///< by tile: leaves listed now
  TestCounts tests;
  std::uint64_t pairs = 0;  ///< (leaf, tile) pairs listed now
};

/// Of the lists' ranges, continuing from `seed`: equal lists of equal tiles have equal hashes on every
/// machine.
[[nodiscard]] std::uint64_t hashOf(const std::vector<VisibleList>& lists, std::uint64_t seed);

}  // namespace tessera::cull
