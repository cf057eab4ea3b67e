#pragma once

#include <cstdint>

namespace tessera::cull {

/// The most columns or rows of a grid whose rectangles fit four bytes.
inline constexpr int kMostCells = 127;

/// A rectangle of tiles in four bytes: first and last column, first and last row, both inclusive, from the
/// least byte up; empty where a first is above its last. The topmost bit of the first byte tells that only
/// spans of its rows are meant.
using TileRect = std::uint32_t;

inline constexpr TileRect kNoTiles = 0x00010001;
inline constexpr TileRect kSpansFlag = 0x80;

struct TileCells {
  int firstColumn = 1, lastColumn = 0, firstRow = 1, lastRow = 0;
  [[nodiscard]] bool empty() const { return firstColumn > lastColumn || firstRow > lastRow; }
};

[[nodiscard]] inline TileCells unpack(TileRect rect) {
  return {.firstColumn = static_cast<int>(rect & 0x7F),
          .lastColumn = static_cast<int>((rect >> 8) & 0xFF),
          .firstRow = static_cast<int>((rect >> 16) & 0xFF),
          .lastRow = static_cast<int>(rect >> 24)};
}

[[nodiscard]] inline TileRect pack(const TileCells& cells) {
  if (cells.empty()) return kNoTiles;
  return static_cast<TileRect>(cells.firstColumn) | static_cast<TileRect>(cells.lastColumn) << 8 |
         static_cast<TileRect>(cells.firstRow) << 16 | static_cast<TileRect>(cells.lastRow) << 24;
}

/// Columns first to last of one row of tiles; empty where first > last.
struct ColumnSpan {
  std::uint8_t first = 1, last = 0;
  friend bool operator==(const ColumnSpan&, const ColumnSpan&) = default;
};

}  // namespace tessera::cull
