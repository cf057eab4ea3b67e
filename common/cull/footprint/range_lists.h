#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/cull/footprint/tile_rect.h"
#include "common/hierarchy/visible_list.h"

namespace tessera::cull {

/// Writes leaves down as the canonical lists of many tiles at once; for each tile they come in ascending
/// order. Whether a leaf goes on with a range or starts one is a coin's toss, so that is decided without a
/// branch.
class RangeLists {
 public:
  /// All empty. Memory is kept from call to call.
  void begin(int columns, int rows);

  /// Not kNoTiles, without spans.
  void add(LeafRange leaves, TileRect rect) {
    const TileCells cells = unpack(rect);
    if (cells.firstColumn == cells.lastColumn && cells.firstRow == cells.lastRow) {  // most are
      pairs_ += leaves.last - leaves.first;
      return add(leaves, static_cast<std::size_t>(cells.firstRow * columns_ + cells.firstColumn));
    }
    for (int row = cells.firstRow; row <= cells.lastRow; ++row)
      addRow(leaves, row, cells.firstColumn, cells.lastColumn);
  }
  void add(LeafRange leaves, const TileCells& cells, std::span<const ColumnSpan> spans) {
    for (int row = cells.firstRow; row <= cells.lastRow; ++row) {
      const ColumnSpan span = spans[static_cast<std::size_t>(row - cells.firstRow)];
      addRow(leaves, row, span.first, span.last);
    }
  }
  void add(LeafRange leaves, std::size_t tile) {
    Tile& t = tiles_[tile];
    LeafRange* range = t.last;
    if (range == t.ranges.data()) touched_.push_back(static_cast<std::uint32_t>(tile));
    const bool opens = range->last != leaves.first;
    range += opens;
    range->first = opens ? leaves.first : range->first;
    range->last = leaves.last;
    t.last = range;
    if (range == t.limit) [[unlikely]]
      grow(t);
  }
  /// (leaf, tile) pairs so far.
  [[nodiscard]] std::uint64_t pairs() const { return pairs_; }

  /// The tiles whose lists are not empty, in no order.
  [[nodiscard]] std::span<const std::uint32_t> touched() const { return touched_; }
  [[nodiscard]] std::span<const LeafRange> list(std::size_t tile) const {
    return {tiles_[tile].ranges.data() + 1, tiles_[tile].last + 1};
  }

 private:
  struct Tile {
    LeafRange* last = nullptr;  ///< the first is none: it ends where no leaf begins
    LeafRange* limit = nullptr;
    std::vector<LeafRange> ranges;
  };
  static void grow(Tile& tile);

  void addRow(LeafRange leaves, int row, int firstColumn, int lastColumn) {
    const auto first = static_cast<std::size_t>(row * columns_ + firstColumn);
    const auto count = static_cast<std::size_t>(lastColumn - firstColumn + 1);
    for (std::size_t i = 0; i < count; ++i)
      add(leaves, first + i);
    pairs_ += std::uint64_t{count} * (leaves.last - leaves.first);
  }

  std::vector<Tile> tiles_;
  std::vector<std::uint32_t> touched_;
  int columns_ = 0;
  std::uint64_t pairs_ = 0;
};

}  // namespace tessera::cull
