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
      : oh_(&oh),
        tree_(&tree),
        frame_(KernelFrame::forLeaves(grid, tree.scale())),
        clipped_(grid),
        refines_(refines) {}

  /// `rects` are those of so many leaves, `lanes` what a kernel says of them; calls `refined(lane, spans)`
  /// for those with spans, in order, after their rectangle was marked with kSpansFlag. Spans are one for each
  /// row.
  template <class Refined>
  void finish(std::span<const std::uint32_t> leaves, BlockLanes lanes, TileRect* rects, Refined refined) {
    std::uint32_t left = lanes.open | (refines_ ? lanes.wide : 0U);
    for (; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
      if (lane >= leaves.size()) break;
      if (!outline(leaves[lane], (lanes.open >> lane) & 1, rects[lane])) continue;
      const TileCells cells = unpack(rects[lane]);
      rects[lane] |= kSpansFlag;
      refined(lane, std::span<const ColumnSpan>(
                        spans_.data(), static_cast<std::size_t>(cells.lastRow - cells.firstRow + 1)));
    }
  }

 private:
  [[nodiscard]] static bool isWide(const TileCells& cells) {
    const int columns = cells.lastColumn - cells.firstColumn + 1, rows = cells.lastRow - cells.firstRow + 1;
    return columns >= 2 && rows >= 2 && columns * rows >= kLeastRefined;
  }

  /// Finds an open leaf's rectangle, and the spans where they are worth it: true.
  bool outline(std::uint32_t leaf, bool isOpen, TileRect& rect) {
    if (!isOpen) {
      return kernels().spans(frame_, tree_->leaves()[leaf / kLanes], leaf % kLanes, unpack(rect),
                             spans_.data());
    }
    const TileCells cells = clipped_.rectOf(tree_->boxOf(*oh_, leaf));
    rect = pack(cells);
    return refines_ && isWide(cells) && clipped_.spans(cells, spans_);
  }

  const ObjectHierarchy* oh_;
  const BoxTree* tree_;
  KernelFrame frame_;
  ClippedFootprint clipped_;
  bool refines_;
  std::array<ColumnSpan, kMostCells + 1> spans_;
};

}  // namespace tessera::cull
