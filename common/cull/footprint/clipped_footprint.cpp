#include "common/cull/footprint/clipped_footprint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace tessera::cull {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A near distance smaller than this share of the box's depth might as well be 0.
constexpr double kLeastNear = 0x1p-30;

Vec3 toDouble(const std::array<float, 3>& v) {
  return {double{v[0]}, double{v[1]}, double{v[2]}};
}

/// First and last cell that [least, most] meets; first > last where it meets none.
std::pair<int, int> cellsOf(double least, double most, double low, double high, int count) {
  const double first = std::clamp(std::ceil(least - high), 0.0, static_cast<double>(count));
  const double last = std::clamp(std::floor(most - low), -1.0, static_cast<double>(count - 1));
  return {static_cast<int>(first), static_cast<int>(last)};
}

}  // namespace

ClippedFootprint::ClippedFootprint(const GridCoordinates& grid)
    : grid_(&grid),
      column_(toDouble(grid.column)),
      row_(toDouble(grid.row)),
      depth_(toDouble(grid.depth)),
      xError_(16 * kUnitRoundoff * column_.cwiseAbs().maxCoeff()),
      yError_(16 * kUnitRoundoff * row_.cwiseAbs().maxCoeff()),
      zError_(16 * kUnitRoundoff * depth_.cwiseAbs().maxCoeff()) {}

TileCells ClippedFootprint::everywhere() const {
  return {.firstColumn = 0, .lastColumn = grid_->columns - 1, .firstRow = 0, .lastRow = grid_->rows - 1};
}

void ClippedFootprint::addEdge(const Vertex& a, const Vertex& b) {
  edges_[edgeCount_++] = {{a.x / a.z, a.y / a.z}, {b.x / b.z, b.y / b.z}};
}

TileCells ClippedFootprint::rectOf(const Obb& box) {
  edgeCount_ = 0;
  isEverywhere_ = true;
  const Vec3 d = box.center - grid_->eye;
  const auto project = [this](const Vec3& v) { return Vertex{column_.dot(v), row_.dot(v), depth_.dot(v)}; };
  const Vertex c = project(d);
  std::array<Vertex, 3> h;
  double m = d.cwiseAbs().sum();
  for (std::size_t k = 0; k < 3; ++k) {
    h[k] = project(box.halfAxes[k]);
    m += box.halfAxes[k].cwiseAbs().sum();
  }
  if (!(m < 1e150)) return everywhere();
  m += 1e-290;  // underflow
  std::array<Vertex, 8> corners;
  double zLeast = kInfinity, zMost = -kInfinity;
  for (std::size_t i = 0; i < 8; ++i) {
    Vertex& corner = corners[i];
    corner = c;
    for (std::size_t k = 0; k < 3; ++k) {
      const double sign = (i >> k) & 1 ? 1 : -1;
      corner.x += sign * h[k].x;
      corner.y += sign * h[k].y;
      corner.z += sign * h[k].z;
    }
    zLeast = std::min(zLeast, corner.z);
    zMost = std::max(zMost, corner.z);
  }
  const double depthError = grid_->depthError * m + 2 * zError_ * m;
  if (zMost + depthError < grid_->nearDepth || zLeast - depthError > grid_->farDepth) return {};

  // Everything behind the near distance is cut away; where there is next to none, what reaches the eye's own
  // plane is seen at infinity, on the sides that its crossings lie on.
  double near = grid_->nearDepth - depthError;
  const bool reachesEye = near < kLeastNear * zMost && zLeast < kLeastNear * zMost;
  if (reachesEye) near = 0;
  const double zTiny = zError_ * m + kLeastNear * std::max(zMost, 0.0);
  if (zMost <= zTiny) return everywhere();
  const double xError = xError_ * m, yError = yError_ * m, zError = zError_ * m;
  std::array<Vertex, 6> crossings;
  std::size_t crossingCount = 0;
  double xLeast = kInfinity, xMost = -kInfinity, yLeast = kInfinity, yMost = -kInfinity;
  xSlack_ = ySlack_ = 0;
  const auto addVertex = [&](const Vertex& v) {
    const double x = v.x / v.z, y = v.y / v.z;
    xLeast = std::min(xLeast, x);
    xMost = std::max(xMost, x);
    yLeast = std::min(yLeast, y);
    yMost = std::max(yMost, y);
    xSlack_ = std::max(xSlack_, 2 * (xError + (std::abs(x) + 1) * zError) / v.z);
    ySlack_ = std::max(ySlack_, 2 * (yError + (std::abs(y) + 1) * zError) / v.z);
  };
  for (const Vertex& v : corners) {
    if (reachesEye ? v.z > zTiny : v.z >= near) addVertex(v);
  }
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t j = i | (std::size_t{1} << k);
      if (j == i) continue;
      const Vertex &a = corners[i], &b = corners[j];
      const bool aIn = a.z >= near, bIn = b.z >= near;
      if (aIn != bIn) {
        const double t = (near - a.z) / (b.z - a.z);
        const Vertex v = {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), near};
        const double slackX = 2 * xError + 16 * kUnitRoundoff * (std::abs(a.x) + std::abs(b.x));
        const double slackY = 2 * yError + 16 * kUnitRoundoff * (std::abs(a.y) + std::abs(b.y));
        if (reachesEye) {
          if (v.x - slackX < 0) xLeast = -kInfinity;
          if (v.x + slackX > 0) xMost = kInfinity;
          if (v.y - slackY < 0) yLeast = -kInfinity;
          if (v.y + slackY > 0) yMost = kInfinity;
          continue;
        }
        addVertex(v);
        xSlack_ = std::max(xSlack_, 2 * (slackX + std::abs(v.x) / v.z * zError) / v.z);
        ySlack_ = std::max(ySlack_, 2 * (slackY + std::abs(v.y) / v.z * zError) / v.z);
        if (crossingCount < crossings.size()) crossings[crossingCount++] = v;
        addEdge(aIn ? a : v, aIn ? v : b);
      } else if (aIn && !reachesEye) {
        addEdge(a, b);
      }
    }
  }
  if (reachesEye) {  // a corner on the eye's own plane may be seen anywhere
    for (const Vertex& v : corners) {
      if (std::abs(v.z) <= zTiny) return everywhere();
    }
  }
  if (!(xSlack_ < 1e300 && ySlack_ < 1e300)) return everywhere();
  isEverywhere_ = reachesEye;
  // The face that the clipping makes: its outline is among the connections of the crossings.
  for (std::size_t i = 0; i < crossingCount; ++i) {
    for (std::size_t j = i + 1; j < crossingCount; ++j)
      addEdge(crossings[i], crossings[j]);
  }
  TileCells cells;
  std::tie(cells.firstColumn, cells.lastColumn) =
      cellsOf(xLeast - xSlack_, xMost + xSlack_, grid_->columnLow, grid_->columnHigh, grid_->columns);
  std::tie(cells.firstRow, cells.lastRow) =
      cellsOf(yLeast - ySlack_, yMost + ySlack_, grid_->rowLow, grid_->rowHigh, grid_->rows);
  return cells.empty() ? TileCells{} : cells;
}

bool ClippedFootprint::spans(const TileCells& rect, std::span<ColumnSpan> spans) const {
  if (isEverywhere_) return false;
  bool sparesAny = false;
  for (int row = rect.firstRow; row <= rect.lastRow; ++row) {
    // Twice the slack: a crossing is exact for a line that lies a rounding beside the one that is meant.
    const double low = row + grid_->rowLow - 2 * ySlack_, high = row + grid_->rowHigh + 2 * ySlack_;
    double least = kInfinity, most = -kInfinity;
    for (std::size_t e = 0; e < edgeCount_; ++e) {
      const Point& a = edges_[e].a.y <= edges_[e].b.y ? edges_[e].a : edges_[e].b;
      const Point& b = edges_[e].a.y <= edges_[e].b.y ? edges_[e].b : edges_[e].a;
      if (b.y < low || a.y > high) continue;
      const bool isFlat = b.y - a.y <= 4 * ySlack_;
      const auto at = [&](double y) { return a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)); };
      const double first = isFlat || a.y >= low ? a.x : at(low),
                   second = isFlat || b.y <= high ? b.x : at(high);
      least = std::min({least, first, second});
      most = std::max({most, first, second});
    }
    const auto [first, last] =
        cellsOf(least - xSlack_, most + xSlack_, grid_->columnLow, grid_->columnHigh, grid_->columns);
    const int firstColumn = std::max(first, rect.firstColumn), lastColumn = std::min(last, rect.lastColumn);
    ColumnSpan& span = spans[static_cast<std::size_t>(row - rect.firstRow)];
    span = firstColumn <= lastColumn
               ? ColumnSpan{static_cast<std::uint8_t>(firstColumn), static_cast<std::uint8_t>(lastColumn)}
               : ColumnSpan{};
    sparesAny = sparesAny || firstColumn != rect.firstColumn || lastColumn != rect.lastColumn;
  }
  return sparesAny;
}

}  // namespace tessera::cull
