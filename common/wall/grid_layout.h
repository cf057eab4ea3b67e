#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/wall/wall.h"

namespace tessera {

/// Something for each side.
template <class T>
struct Sides {
  T left{}, right{}, bottom{}, top{};
};

/// An even grid of panels or projectors as people describe one.
struct GridSpec {
  int columns = 1, rows = 1;
  int tileWidthPx = 1, tileHeightPx = 1;
  /// Visible, along the picture's rows and columns; absent: as the screen's size says or, without that, a
  /// millimetre to a pixel.
  std::optional<std::array<double, 2>> tileMm;
  Sides<double> bezelMm;    ///< the panel's frame as mounted
  bool compresses = false;  ///< the picture is pushed together over the bezels
  /// What neighbours share across and down: pixels or, where those are absent, millimetres.
  std::optional<std::array<double, 2>> overlapPx;
  std::array<double, 2> overlapMm = {0, 0};
  int quarterTurns = 0;
  std::vector<std::string> names;  ///< row by row from the top; empty: no tile there
  TileOutput output;
};

/// Places the grid's tiles in the middle of the screen, at the end of `tiles`. Where the screen's size is not
/// known (0) it becomes what the grid covers. Returns how far the grid sticks out over a screen of known
/// size, in millimetres (not positive where it does not).
double layOut(const GridSpec& grid, std::uint32_t screenIndex, Screen& screen, std::vector<Tile>& tiles);

/// Finds the lattice of pixels that the screen's tiles lie on, if there is one, and tells them their place.
void assignCanvases(const Screen& screen, std::vector<Tile>& tiles);

/// The sides of a tile's picture, given those of the tile as it is mounted.
template <class T>
[[nodiscard]] Sides<T> pictureSides(Sides<T> mounted, int quarterTurns) {
  for (int turn = 0; turn < quarterTurns; ++turn)
    mounted = {mounted.top, mounted.bottom, mounted.left, mounted.right};
  return mounted;
}

}  // namespace tessera
