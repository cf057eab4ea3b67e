#include "common/hierarchy/grid_coordinates.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace tessera {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// How far a corner may lie from its cell's, and how much these distances may differ, in cells.
constexpr double kMostInset = 1.0 / 4, kMostDeviation = 1.0 / 64;

std::array<float, 3> toFloat(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

Vec3 toDouble(const std::array<float, 3>& v) {
  return {double{v[0]}, double{v[1]}, double{v[2]}};
}

/// The least and the largest of some values.
struct Extent {
  double least = kInfinity, largest = -kInfinity;
  void add(double low, double high) {
    least = std::min(least, low);
    largest = std::max(largest, high);
  }
  [[nodiscard]] bool isNarrow() const { return largest - least < kMostDeviation; }
};

/// Where corners lie against their places in the lattice.
class Deviation {
 public:
  Deviation(const GridCoordinates& grid)
      : column_(toDouble(grid.column)),
        row_(toDouble(grid.row)),
        depth_(toDouble(grid.depth)),
        // 6u of the sum of absolute terms is what the three functionals may err by: a rounded difference,
        // three products and two sums; the rest is for the quotients.
        columnError_(16 * kUnitRoundoff * (column_.cwiseAbs() + (grid.columns + 1) * depth_.cwiseAbs())),
        rowError_(16 * kUnitRoundoff * (row_.cwiseAbs() + (grid.rows + 1) * depth_.cwiseAbs())) {}

  /// A corner relative to the eye and its place. False where it is not certainly before the eye and near it.
  bool add(const Vec3& k, int column, int row, Extent& columns, Extent& rows) {
    const Vec3 size = k.cwiseAbs();
    const double z = depth_.dot(k), zError = columnError_.dot(size);
    if (!(z > 2 * zError) || !(z > 1e-200)) return false;
    depths_.add(z - zError, z + zError);
    const double scale = 1 / z;
    const double x = (column_.dot(k) - column * z) * scale, xError = 2 * zError * scale;
    const double y = (row_.dot(k) - row * z) * scale, yError = 2 * rowError_.dot(size) * scale;
    columns.add(x - xError, x + xError);
    rows.add(y - yError, y + yError);
    return std::abs(x) + xError < kMostInset && std::abs(y) + yError < kMostInset;
  }
  [[nodiscard]] const Extent& depths() const { return depths_; }

 private:
  Vec3 column_, row_, depth_, columnError_, rowError_;
  Extent depths_;
};

}  // namespace

std::optional<GridCoordinates> GridCoordinates::of(const Frustum& lattice, std::span<const Frustum> tiles,
                                                   int columns, int rows) {
  GridCoordinates grid;
  grid.columns = columns;
  grid.rows = rows;
  grid.eye = lattice.eye;
  // A point of the lattice's plane is z (origin + a across + b down).
  const Vec3 origin = lattice.corners[3] - lattice.eye;
  const Vec3 across = lattice.corners[2] - lattice.corners[3], down = lattice.corners[0] - lattice.corners[3];
  const Vec3 normal = across.cross(down);
  const double volume = normal.dot(origin), largest = normal.cwiseAbs().maxCoeff();
  if (!(volume > 0) || !(largest > 0) || !std::isfinite(volume) || !std::isfinite(largest))
    return std::nullopt;
  int exponent = 0;
  static_cast<void>(std::frexp(largest / volume, &exponent));
  const double unit = std::ldexp(1.0, -exponent);
  grid.depth = toFloat(normal / volume * unit);
  grid.column = toFloat(down.cross(origin) / volume * unit * columns);
  grid.row = toFloat(origin.cross(across) / volume * unit * rows);

  Deviation deviation(grid);
  Extent left, right, top, bottom;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const Frustum& tile = tiles[static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) +
                                  static_cast<std::size_t>(c)];
      const bool fits = deviation.add(tile.corners[0] - grid.eye, c, r + 1, left, bottom) &&
                        deviation.add(tile.corners[1] - grid.eye, c + 1, r + 1, right, bottom) &&
                        deviation.add(tile.corners[2] - grid.eye, c + 1, r, right, top) &&
                        deviation.add(tile.corners[3] - grid.eye, c, r, left, top);
      if (!fits) return std::nullopt;
    }
  }
  if (!left.isNarrow() || !right.isNarrow() || !top.isNarrow() || !bottom.isNarrow()) return std::nullopt;
  grid.columnLow = left.least;
  grid.columnHigh = 1 + right.largest;
  grid.rowLow = top.least;
  grid.rowHigh = 1 + bottom.largest;

  // The corners' heights along `depth` differ by at most `rise`, so a tile's normal is turned against it by
  // at most rise (|a| + |b|) / |a x b|, a and b being the tile's edges in the plane: cells' edges times no
  // less than `least`. Twice that covers edges whose ends deviate by 1/64.
  const double length = toDouble(grid.depth).norm();
  const double rise = (deviation.depths().largest - deviation.depths().least) / length;
  const double least = std::min({1.0, 1 + right.least - left.largest, 1 + bottom.least - top.largest});
  const double tilt = 2 * rise / least * (rows * across.norm() + columns * down.norm()) / normal.norm();
  grid.depthError = length * (tilt + 16 * kUnitRoundoff);
  grid.nearDepth = lattice.near ? *lattice.near * length * (1 - 16 * kUnitRoundoff) : 0;
  grid.farDepth = lattice.far ? *lattice.far * length * (1 + 16 * kUnitRoundoff) : kInfinity;
  if (!std::isfinite(grid.depthError) || !(grid.nearDepth >= 0)) return std::nullopt;
  return grid;
}

}  // namespace tessera
