#include "common/cull/footprint/camera_drift.h"

#include <algorithm>
#include <cmath>

namespace tessera::cull {

namespace {

/// Of what the sums themselves are rounded by.
constexpr double kRounding = 1 + 1e-9;

Vec3 toDouble(const std::array<float, 3>& v) {
  return {double{v[0]}, double{v[1]}, double{v[2]}};
}

/// The largest norm of across - b * depth over all borders b of `cells` cells.
double largestNorm(const Vec3& across, const Vec3& depth, int cells) {
  return std::max((across + depth).norm(), (across - (cells + 1) * depth).norm());
}

/// 0 of two infinities.
double difference(double a, double b) {
  return a == b ? 0 : std::abs(a - b);
}

}  // namespace

bool CameraDrift::advance(const GridCoordinates& grid, double scale) {
  const GridCoordinates before = last_;
  last_ = grid;
  const bool isSame = !isFirst_ && before.columns == grid.columns && before.rows == grid.rows;
  isFirst_ = false;
  const double moved = (grid.eye - before.eye).norm() * scale;
  const double depths =
      scale * (difference(grid.nearDepth, before.nearDepth) + difference(grid.farDepth, before.farDepth));
  const Vec3 depth = toDouble(grid.depth), depthChange = depth - toDouble(before.depth);
  const auto step = [&](const std::array<float, 3>& now, const std::array<float, 3>& was, int cells) {
    const Vec3 across = toDouble(now);
    return Axis{.turn = kRounding * largestNorm(across - toDouble(was), depthChange, cells),
                .travel = kRounding * (largestNorm(across, depth, cells) * moved + depths)};
  };
  const Axis columns = step(grid.column, before.column, grid.columns);
  const Axis rows = step(grid.row, before.row, grid.rows);
  if (!isSame || !std::isfinite(columns.turn + columns.travel + rows.turn + rows.travel)) {
    rebase();
    return false;
  }
  columns_.turn += columns.turn;
  columns_.travel += columns.travel;
  rows_.turn += rows.turn;
  rows_.travel += rows.travel;
  return true;
}

}  // namespace tessera::cull
