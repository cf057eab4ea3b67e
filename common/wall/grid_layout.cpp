#include "common/wall/grid_layout.h"

#include <algorithm>
#include <cmath>

namespace tessera {

namespace {

constexpr int kMostCanvasPx = 65535;
/// So much of a pixel may a tile lie beside the lattice of pixels, which then is what was meant.
constexpr double kPixelSlack = 1e-6;

/// One axis of a grid, as mounted.
struct GridAxis {
  int count;
  double tileMm, pitchMm, mountPitchMm;
  double overlapPx;

  [[nodiscard]] double extentMm() const { return (count - 1) * pitchMm + tileMm; }
  /// The near and far edge of tile i from the middle, in halves of the screen's size. Where tiles touch, the
  /// far edge of one is the near edge of the next to the last bit, and the ends are exactly -1 and 1.
  [[nodiscard]] double edge(int i, bool isFar, double screenMm) const {
    double share = extentMm() / screenMm;
    if (std::abs(share - 1) < 1e-12) share = 1;  // meant, but for the rounding of a fitted size
    if (pitchMm == tileMm) return (static_cast<double>(2 * (i + (isFar ? 1 : 0)) - count) / count) * share;
    return (2 * (i * pitchMm + (isFar ? tileMm : 0)) - extentMm()) / screenMm;
  }
};

/// `knownMm`: the screen's, 0 where it has none.
GridAxis axisOf(const GridSpec& grid, bool isAcross, double knownMm) {
  const std::size_t i = isAcross ? 0 : 1;
  const bool isTurned = grid.quarterTurns % 2 != 0;
  const std::size_t alongPicture = isTurned ? 1 - i : i;
  const int pixels = alongPicture == 0 ? grid.tileWidthPx : grid.tileHeightPx;
  GridAxis axis{.count = isAcross ? grid.columns : grid.rows,
                .tileMm = 0,
                .pitchMm = 0,
                .mountPitchMm = 0,
                .overlapPx = 0};
  const double bezelMm =
      isAcross ? grid.bezelMm.left + grid.bezelMm.right : grid.bezelMm.top + grid.bezelMm.bottom;
  const double gapMm = grid.compresses ? 0 : bezelMm;
  if (grid.tileMm) {
    axis.tileMm = (*grid.tileMm)[alongPicture];
  } else if (knownMm > 0) {
    const double overlaps = grid.overlapPx ? (axis.count - 1) * (*grid.overlapPx)[i] / pixels : 0;
    axis.tileMm = (knownMm - (axis.count - 1) * (gapMm - grid.overlapMm[i])) / (axis.count - overlaps);
  } else {
    axis.tileMm = pixels;
  }
  const double overlapMm = grid.overlapPx ? (*grid.overlapPx)[i] * axis.tileMm / pixels : grid.overlapMm[i];
  axis.overlapPx = grid.overlapPx ? (*grid.overlapPx)[i] : overlapMm / axis.tileMm * pixels;
  axis.pitchMm = axis.tileMm + gapMm - overlapMm;
  axis.mountPitchMm = axis.tileMm + bezelMm - overlapMm;
  return axis;
}

std::array<double, 4> blendOf(const GridSpec& grid, const GridAxis& across, const GridAxis& down, int column,
                              int row) {
  const Sides<double> mounted = {column > 0 ? across.overlapPx : 0,
                                 column + 1 < grid.columns ? across.overlapPx : 0,
                                 row + 1 < grid.rows ? down.overlapPx : 0, row > 0 ? down.overlapPx : 0};
  const Sides<double> sides = pictureSides(mounted, grid.quarterTurns);
  return {sides.left, sides.right, sides.bottom, sides.top};
}

}  // namespace

double layOut(const GridSpec& grid, std::uint32_t screenIndex, Screen& screen, std::vector<Tile>& tiles) {
  const GridAxis across = axisOf(grid, true, screen.widthMm), down = axisOf(grid, false, screen.heightMm);
  if (!(screen.widthMm > 0)) screen.widthMm = across.extentMm();
  if (!(screen.heightMm > 0)) screen.heightMm = down.extentMm();
  const bool isTurned = grid.quarterTurns % 2 != 0;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const auto cell = static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns) +
                        static_cast<std::size_t>(column);
      if (grid.names[cell].empty()) continue;
      Tile tile;
      tile.name = grid.names[cell];
      tile.screen = screenIndex;
      const double left = across.edge(column, false, screen.widthMm),
                   right = across.edge(column, true, screen.widthMm);
      const double top = -down.edge(row, false, screen.heightMm),
                   bottom = -down.edge(row, true, screen.heightMm);
      tile.corners = {Vec2(left, bottom), Vec2(right, bottom), Vec2(right, top), Vec2(left, top)};
      tile.widthPx = grid.tileWidthPx;
      tile.heightPx = grid.tileHeightPx;
      tile.widthMm = isTurned ? down.tileMm : across.tileMm;
      tile.heightMm = isTurned ? across.tileMm : down.tileMm;
      tile.mountMm = Vec2((2 * column + 1 - grid.columns) * across.mountPitchMm,
                          (grid.rows - 1 - 2 * row) * down.mountPitchMm) /
                     2;
      tile.quarterTurns = grid.quarterTurns;
      tile.output = grid.output;
      tile.output.blendPx = blendOf(grid, across, down, column, row);
      tiles.push_back(std::move(tile));
    }
  }
  screen.tileCount = static_cast<std::uint32_t>(tiles.size()) - screen.firstTile;
  const bool isFull = screen.tileCount == static_cast<std::uint32_t>(grid.columns * grid.rows);
  screen.columns = isFull ? grid.columns : 0;
  screen.rows = isFull ? grid.rows : 0;
  screen.latticeWidth = across.count * across.pitchMm / screen.widthMm;
  screen.latticeHeight = down.count * down.pitchMm / screen.heightMm;
  return std::max(across.extentMm() - screen.widthMm, down.extentMm() - screen.heightMm);
}

void assignCanvases(const Screen& screen, std::vector<Tile>& tiles) {
  const auto first = tiles.begin() + screen.firstTile, end = first + screen.tileCount;
  const auto isWhole = [](double px) { return std::abs(px - std::round(px)) < kPixelSlack; };
  bool isLattice = true;
  double across = 0, down = 0;  // pixels to half the screen
  for (auto tile = first; tile != end; ++tile) {
    tile->canvasWidthPx = tile->widthPx;
    tile->canvasHeightPx = tile->heightPx;
    tile->xPx = tile->yPx = 0;
    const Vec2 size = tile->corners[2] - tile->corners[0];
    const double fineX = tile->widthPx / size.x(), fineY = tile->heightPx / size.y();
    if (tile == first) across = fineX, down = fineY;
    const double x = (tile->corners[3].x() + 1) * across, y = (1 - tile->corners[3].y()) * down;
    isLattice = isLattice && tile->quarterTurns == 0 && tile->freeTurnRad == 0 &&
                std::abs(fineX / across - 1) * tile->widthPx < kPixelSlack &&
                std::abs(fineY / down - 1) * tile->heightPx < kPixelSlack && isWhole(x) && isWhole(y) &&
                x > -kPixelSlack && y > -kPixelSlack;
  }
  if (!isLattice || !isWhole(2 * across) || !isWhole(2 * down) || !(2 * across <= kMostCanvasPx) ||
      !(2 * down <= kMostCanvasPx)) {
    return;
  }
  for (auto tile = first; tile != end; ++tile) {
    tile->canvasWidthPx = static_cast<int>(std::lround(2 * across));
    tile->canvasHeightPx = static_cast<int>(std::lround(2 * down));
    tile->xPx = static_cast<int>(std::lround((tile->corners[3].x() + 1) * across));
    tile->yPx = static_cast<int>(std::lround((1 - tile->corners[3].y()) * down));
  }
}

}  // namespace tessera
