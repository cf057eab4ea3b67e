#pragma once

#include <cstdint>
#include <vector>

#include "common/cull/footprint/box_blocks.h"
#include "common/cull/footprint/kernels.h"
#include "common/cull/footprint/range_lists.h"
#include "common/cull/result.h"

namespace tessera::cull {

/// Footprints by way of the implicit tree (Algorithm::Footprint): nodes that are nowhere are left, nodes
/// within one tile are listed as the range of their leaves, the others are opened, down to blocks of leaves.
class TreeWalk {
 public:
  /// Fills the lists, and the counts of tests and pairs. `threads` >= 1.
  void list(const ObjectHierarchy& oh, const BoxTree& tree, const GridCoordinates& grid, bool refines,
            unsigned threads, Result& result);

 private:
  struct Part {
    RangeLists lists;
    std::uint64_t blocks = 0;
  };
  std::vector<Part> parts_;
};

}  // namespace tessera::cull
