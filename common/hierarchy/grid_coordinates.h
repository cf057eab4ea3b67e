#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "common/geometry/frustum.h"

namespace tessera {

/// Homogeneous tile coordinates of an even grid of tiles that one eye sees: each in a cell of the lattice, of
/// the cell's size, smaller (bezels) or larger (overlaps). For a point p relative to the
/// eye, x = column.p, y = row.p and z = depth.p; the point is seen at column x/z and row y/z of the wall,
/// which spans [0, columns] from the left and [0, rows] from the top. The set of tiles that a convex body
/// before the eye may meet is then an interval of columns and one of rows.
///
/// The three functionals are exact as they stand: they are floats, so that kernels in float start without an
/// error. What their rounding, and that of the tiles' corners, does to the tiles' borders is measured.
/// Derivation: a tile whose corners lie within 1/4 of the corners of its cell, and within 1/64 of a common
/// inset or overlap, is convex and before the eye, so its frustum is the cone of its corners' rays:
/// p = sum l_i k_i, l_i >= 0. With `low` at most (x - jz)/z of each of its corners k_i,
/// x(p) - (j + low) z(p) = sum l_i (x_i - (j + low) z_i) >= 0; likewise for the other sides.
struct GridCoordinates {
  std::array<float, 3> column = {}, row = {}, depth = {};  ///< the largest component of depth is in [1/2, 1]
  int columns = 0, rows = 0;
  /// Tile (c, r) is certainly within x/z of [c + columnLow, c + columnHigh], y/z of [r + rowLow, r +
  /// rowHigh].
  double columnLow = 0, columnHigh = 1, rowLow = 0, rowHigh = 1;
  /// Where the tiles end in depth: points p of a tile have z + depthError |p| >= nearDepth and
  /// z - depthError |p| <= farDepth, whichever three corners of the tile define its normal. 0 and infinity
  /// where there is no near and far.
  double nearDepth = 0, farDepth = 0;
  double depthError = 0;
  Vec3 eye = Vec3::Zero();

  /// `lattice` is the frustum of all cells; `tiles` has columns*rows frusta of the same eye, row by row from
  /// the top; near and far are taken from `lattice`. Nothing where the tiles are no even grid, the eye does
  /// not see them the right way round, or doubles cannot tell.
  [[nodiscard]] static std::optional<GridCoordinates> of(const Frustum& lattice,
                                                         std::span<const Frustum> tiles, int columns,
                                                         int rows);
};

}  // namespace tessera
