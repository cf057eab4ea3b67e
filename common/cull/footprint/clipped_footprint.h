#pragma once

#include <span>

#include "common/cull/footprint/tile_rect.h"
#include "common/geometry/box.h"
#include "common/hierarchy/grid_coordinates.h"

namespace tessera::cull {

/// The footprint of any box on a uniform grid, one at a time and in double: for boxes that reach behind the
/// eye, which kernels leave open. The box is clipped at the near distance, and the rest projected.
///
/// Bound, u = 2^-53: as in kernels.h, a corner's x, y and z err by 16u F m each at most. The box is clipped
/// that much before the near distance, so every exact point behind it has a computed one beside it; the
/// crossing of an edge errs by 16u of its ends. A quotient x/z of a vertex v errs by (e + |x/z| e) / z, the
/// largest of which widens all.
class ClippedFootprint {
 public:
  explicit ClippedFootprint(const GridCoordinates& grid);

  /// The smallest rectangle. What is not finite is everywhere.
  [[nodiscard]] TileCells rectOf(const Obb& box);

  /// Of the box of the last rectOf, for each row of its rectangle from the first on: the columns that its
  /// outline covers there. `spans` has a place for each row. False where that is the whole rectangle.
  bool spans(const TileCells& rect, std::span<ColumnSpan> spans) const;

 private:
  struct Vertex {
    double x, y, z;
  };
  struct Point {
    double x, y;
  };
  struct Edge {
    Point a, b;
  };
  bool clip(const Obb& box);
  void addEdge(const Vertex& a, const Vertex& b);
  [[nodiscard]] TileCells everywhere() const;

  const GridCoordinates* grid_;
  Vec3 column_, row_, depth_;
  double xError_ = 0, yError_ = 0, zError_ = 0;  ///< times m
  // Of the last box.
  static constexpr std::size_t kMostEdges = 12 + 15;
  Edge edges_[kMostEdges];
  std::size_t edgeCount_ = 0;
  double xSlack_ = 0, ySlack_ = 0;  ///< in tiles
  bool isEverywhere_ = true;
};

}  // namespace tessera::cull
