#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/cull/footprint/tile_rect.h"
#include "common/hierarchy/visible_list.h"

namespace tessera::cull {

/// Writes footprints out as the visible lists of tiles. Leaves come in ascending order.
class RangeLists {
 public:
  /// `lists` has columns * rows lists, all empty.
  RangeLists(std::vector<VisibleList>& lists, int columns) : lists_(lists.data()), columns_(columns) {}

  void add(LeafRange leaves, const TileCells& cells) {
    for (int row = cells.firstRow; row <= cells.lastRow; ++row)
      addRow(leaves, row, cells.firstColumn, cells.lastColumn);
  }
  void add(LeafRange leaves, const TileCells& cells, std::span<const ColumnSpan> spans) {
    for (int row = cells.firstRow; row <= cells.lastRow; ++row) {
      const ColumnSpan span = spans[static_cast<std::size_t>(row - cells.firstRow)];
      addRow(leaves, row, span.first, span.last);
    }
  }
  /// (leaf, tile) pairs so far.
  [[nodiscard]] std::uint64_t pairs() const { return pairs_; }

 private:
  void addRow(LeafRange leaves, int row, int firstColumn, int lastColumn) {
    VisibleList* const list = lists_ + static_cast<std::ptrdiff_t>(row) * columns_;
    for (int column = firstColumn; column <= lastColumn; ++column)
      appendRange(list[column], leaves);
    if (firstColumn <= lastColumn)
      pairs_ += static_cast<std::uint64_t>(lastColumn - firstColumn + 1) * (leaves.last - leaves.first);
  }

  VisibleList* lists_;
  int columns_;
  std::uint64_t pairs_ = 0;
};

}  // namespace tessera::cull
