#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/frustum.h"
#include "common/hierarchy/frustum_hierarchy.h"
#include "common/hierarchy/tile_cone.h"

namespace tessera {

/// The frustum hierarchy of an even grid of tiles, bisected along the longer side first. The topology depends
/// on the grid alone; update() moves the planes.
///
/// Where tiles touch, its leaves fill their parents, so no terminal test is needed. Where there are bezels
/// between them or they overlap, what arrives at a leaf has still to be tested against the tile's sides.
///
/// A tile's own corners are rounded, and tiles may overlap, so they may stick out over the bisection plane or
/// the wall's sides; how far is measured at each update and added to the planes' bound.
class GridFrusta : public FrustumHierarchy {
 public:
  enum class Neighbours { Touch, GapOrOverlap };

  GridFrusta(std::uint16_t columns, std::uint16_t rows, PlaneSource source = PlaneSource::Corners,
             Neighbours neighbours = Neighbours::Touch);

  /// `wall` is the primary frustum; `tiles` has columns*rows frusta of the same eye, row by row from the top;
  /// near and far are taken from `wall`. Does not allocate.
  void update(const Frustum& wall, std::span<const Frustum> tiles) {
    updateGrid(wall, tiles);
    updatePlanes(wall, tiles);
  }
  /// The same in two: the eye and grid() alone, some fifteen times faster than the planes, and all else.
  /// `lattice`: the frustum of all the grid's cells; that of the wall where tiles touch.
  void updateGrid(const Frustum& lattice, std::span<const Frustum> tiles);
  void updatePlanes(const Frustum& wall, std::span<const Frustum> tiles);

 private:
  /// Columns and rows of tiles below a node.
  struct Cells {
    std::uint16_t firstColumn = 0, endColumn = 0, firstRow = 0, endRow = 0;
  };
  void build();
  void updateBisection(std::uint32_t index);
  [[nodiscard]] double overhang(const BoundedPlane& plane, const Cells& cells, double sign) const;
  [[nodiscard]] const TileCone& cone(int column, int row) const {
    return cones_[static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column)];
  }

  std::uint16_t columns_, rows_;
  PlaneSource source_;
  std::vector<Cells> cells_;  ///< parallel to nodes_
  std::vector<TileCone> cones_;
  double minDepth_ = 0;  ///< of all tiles' corners along the wall's axis
  bool testsTiles_ = false;
  bool proper_ = true;  ///< all tiles are certainly convex; else no plane but a tile's own culls
};

}  // namespace tessera
