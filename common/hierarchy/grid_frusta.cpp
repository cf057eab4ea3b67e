#include "common/hierarchy/grid_frusta.h"

#include <algorithm>
#include <limits>

namespace tessera {

namespace {

constexpr std::uint32_t kBottom = 1, kRight = 2, kTop = 4, kLeft = 8;

}  // namespace

GridFrusta::GridFrusta(std::uint16_t columns, std::uint16_t rows, PlaneSource source, Neighbours neighbours)
    : columns_(columns), rows_(rows), source_(source) {
  const std::size_t tileCount = std::size_t{columns} * rows;
  tiles_.resize(tileCount);
  cones_.resize(tileCount);
  build();
  bisections_.resize(nodes_.size());
  testsTiles_ = neighbours == Neighbours::GapOrOverlap && tileCount > 1;
}

void GridFrusta::build() {
  nodes_.push_back({});
  cells_.push_back({.firstColumn = 0, .endColumn = columns_, .firstRow = 0, .endRow = rows_});
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    const Cells cells = cells_[i];
    const int width = cells.endColumn - cells.firstColumn, height = cells.endRow - cells.firstRow;
    Node node;
    if (width == 1 && height == 1) {
      node.firstLeafTile = static_cast<std::uint32_t>(leafTiles_.size());
      node.endLeafTile = node.firstLeafTile + 1;
      leafTiles_.push_back({.tile = std::uint32_t{cells.firstRow} * columns_ + cells.firstColumn});
      nodes_[i] = node;
      continue;
    }
    Cells negative = cells, positive = cells;
    if (width >= height) {
      negative.endColumn = positive.firstColumn = static_cast<std::uint16_t>(cells.firstColumn + width / 2);
      node.keepNegative = ~kRight;
      node.keepPositive = ~kLeft;
    } else {  // rows count from the top: the negative half is the upper one
      negative.endRow = positive.firstRow = static_cast<std::uint16_t>(cells.firstRow + height / 2);
      node.keepNegative = ~kBottom;
      node.keepPositive = ~kTop;
    }
    node.negative = static_cast<std::uint32_t>(nodes_.size());
    node.positive = node.negative + 1;
    nodes_[i] = node;
    nodes_.resize(nodes_.size() + 2);
    cells_.push_back(negative);
    cells_.push_back(positive);
  }
}

void GridFrusta::updateGrid(const Frustum& lattice, std::span<const Frustum> tiles) {
  eye_ = lattice.eye;
  grid_ = GridCoordinates::of(lattice, tiles, columns_, rows_);
}

void GridFrusta::updatePlanes(const Frustum& wall, std::span<const Frustum> tiles) {
  TileCone whole(wall, std::nullopt);
  double axisError = whole.axisError;
  minDepth_ = std::numeric_limits<double>::infinity();
  proper_ = true;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    cones_[t] = TileCone(tiles[t], whole.axis);
    axisError = std::max(axisError, cones_[t].axisError);
    minDepth_ = std::min(minDepth_, cones_[t].minDepth);
    proper_ = proper_ && cones_[t].isProper;
  }
  for (std::size_t t = 0; t < tiles.size(); ++t)
    cones_[t].sides(tiles_[t], source_);
  whole.sides(primary_, source_);
  for (std::size_t i = 0; i < 4; ++i)
    widen(primary_.planes[i], overhang(primary_.planes[i], cells_[0], 1));
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (!nodes_[i].isLeaf()) updateBisection(i);
  }
  primary_.count = 4;
  for (FrustumPlanes& tile : tiles_)
    tile.count = 4;
  const auto addDepth = [&](double distance, double sign) {
    addDepthPlane(primary_, whole.axis, axisError, distance, sign);
    for (FrustumPlanes& tile : tiles_)
      addDepthPlane(tile, whole.axis, axisError, distance, sign);
  };
  if (wall.near) addDepth(*wall.near, 1);
  if (wall.far) addDepth(*wall.far, -1);
  if (!testsTiles_) return;
  for (LeafTile& leaf : leafTiles_) {
    leaf.mask = tiles_[leaf.tile].all();
    leaf.boundedByPrimary = false;
  }
}

/// How far the corners of the cells' tiles stick out over the outside (sign 1: where the plane is negative)
/// of a plane, as the angle by which the plane must be widened. The frustum of a convex tile is the cone of
/// its corner rays, so a point p of it is a sum of l_i k_i, l_i >= 0, with sum l_i <= depth(p) / minDepth_;
/// where every n.k_i >= -m, n.p >= -m depth(p) / minDepth_ >= -m |p| / minDepth_.
double GridFrusta::overhang(const BoundedPlane& plane, const Cells& cells, double sign) const {
  if (!proper_) return std::numeric_limits<double>::infinity();
  double most = 0;
  for (int row = cells.firstRow; row < cells.endRow; ++row) {
    for (int column = cells.firstColumn; column < cells.endColumn; ++column)
      most = std::max(most, cone(column, row).overhang(plane, sign));
  }
  return most / minDepth_ * (1 + 8 * kUnitRoundoff);
}

void GridFrusta::updateBisection(std::uint32_t index) {
  const Cells& cells = cells_[index];
  const Cells& negative = cells_[nodes_[index].negative];
  const Cells& positive = cells_[nodes_[index].positive];
  BoundedPlane& plane = bisections_[index];
  if (negative.endColumn == positive.firstColumn) {
    const int column = negative.endColumn - 1;
    plane =
        planeThroughEye(cone(column, cells.firstRow).corners[2], cone(column, cells.endRow - 1).corners[1]);
  } else {
    const int row = negative.endRow - 1;
    plane =
        planeThroughEye(cone(cells.endColumn - 1, row).corners[1], cone(cells.firstColumn, row).corners[0]);
  }
  widen(plane, std::max(overhang(plane, positive, 1), overhang(plane, negative, -1)));
}

}  // namespace tessera
