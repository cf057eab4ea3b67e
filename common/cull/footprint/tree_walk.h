#pragma once

#include <cstdint>
#include <vector>

#include "common/cull/footprint/box_blocks.h"
#include "common/cull/footprint/kernels.h"
#include "common/cull/result.h"

namespace tessera::cull {

/// Footprints by way of the implicit tree (Algorithm::Footprint): nodes that are nowhere are left, nodes
/// within one tile are listed as the range of their leaves, the others are opened, down to blocks of leaves.
class TreeWalk {
 public:
  /// `result.lists` has a list for each tile, all empty; fills them, and `pairs`. `threads` >= 1.
  void list(const ObjectHierarchy& oh, const BoxTree& tree, const GridCoordinates& grid, bool refines,
            unsigned threads, Result& result);

 private:
  struct Part {
    std::vector<VisibleList> lists;
    std::uint64_t pairs = 0, blocks = 0;
  };
  void merge(std::vector<VisibleList>& lists);
  std::vector<Part> parts_;
};

}  // namespace tessera::cull
