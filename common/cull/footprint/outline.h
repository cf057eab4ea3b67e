#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "common/cull/footprint/box_blocks.h"
#include "common/cull/footprint/clipped_footprint.h"
#include "common/cull/footprint/kernels.h"

namespace tessera::cull {

/// Finishes single leaves that a kernel could not, or not well enough: those that reach behind the eye, and
/// those whose outline covers fewer tiles than its rectangle. A footprint depends on the box and the grid
/// alone, so that it is the same whichever way led to it.
class Outliner {
 public:
  Outliner(const ObjectHierarchy& oh, const BoxTree& tree, const GridCoordinates& grid, bool refines)
      : oh_(&oh), tree_(&tree), clipped_(grid), refines_(refines) {}

  /// `lanes` of block `block`, whose rectangles are rects[0..kLanes); calls `refined(lane, spans)` for those
  /// with spans, in order, after their rectangle was marked with kSpansFlag. Spans are one for each row.
  template <class Refined>
  void finish(std::uint32_t block, BlockLanes lanes, TileRect* rects, Refined refined) {
    std::uint32_t left = lanes.open | (refines_ ? lanes.wide : 0U);
    while (left != 0) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
      left &= left - 1;
      const auto leaf = static_cast<std::uint32_t>(block * kLanes + lane);
      if (leaf >= tree_->leafCount()) continue;
      const TileCells exact = clipped_.rectOf(tree_->boxOf(*oh_, leaf));
      TileCells cells = unpack(rects[lane]);
      if ((lanes.open >> lane) & 1) {
        cells = exact;
        rects[lane] = pack(cells);
      }
      if (!refines_ || !isWide(cells)) continue;
      const std::span<ColumnSpan> spans(spans_.data(),
                                        static_cast<std::size_t>(cells.lastRow - cells.firstRow + 1));
      if (!clipped_.spans(cells, spans)) continue;
      rects[lane] |= kSpansFlag;
      refined(lane, spans);
    }
  }

 private:
  [[nodiscard]] static bool isWide(const TileCells& cells) {
    const int columns = cells.lastColumn - cells.firstColumn + 1, rows = cells.lastRow - cells.firstRow + 1;
    return columns >= 2 && rows >= 2 && columns * rows >= kLeastRefined;
  }

  const ObjectHierarchy* oh_;
  const BoxTree* tree_;
  ClippedFootprint clipped_;
  bool refines_;
  std::array<ColumnSpan, kMostCells + 1> spans_;
};

}  // namespace tessera::cull
