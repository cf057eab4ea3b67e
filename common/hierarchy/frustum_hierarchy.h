#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/bounded_plane.h"
#include "common/geometry/frustum.h"

namespace tessera {

/// The planes of a frustum that a culler tests, relative to the eye: four sides, then near and far where
/// there are any.
struct FrustumPlanes {
  std::array<BoundedPlane, 6> planes;
  std::uint32_t count = 0;
  /// A mask with one bit for each plane.
  [[nodiscard]] std::uint32_t all() const { return (1u << count) - 1; }
};

/// The frustum hierarchy (FH) of a uniform grid of tiles that share one eye: a binary tree that bisects the
/// wall by planes through the eye, along the longer side first (Nirnimesh, Harish, Narayanan 2006, section
/// 3). Its leaves are the tiles. The topology depends on the grid alone; update() moves the planes.
///
/// Every plane carries a bound (BoundedPlane) under which "outside" means: outside the exact frustum, as
/// defined by its doubles, of every tile on the other side. A tile's own corners are rounded, so they may
/// stick out over the bisection plane or the wall's sides by some rounding; how far is measured at each
/// update and added to the bound.
class FrustumHierarchy {
 public:
  struct Node {
    std::uint32_t negative = 0, positive = 0;  ///< children; 0 for a leaf
    std::uint32_t tile = 0;                    ///< of a leaf: row * columns + column
    std::uint16_t firstColumn = 0, endColumn = 0, firstRow = 0, endRow = 0;
    [[nodiscard]] bool isLeaf() const { return negative == 0; }
  };

  FrustumHierarchy(std::uint16_t columns, std::uint16_t rows);

  /// `wall` is the primary frustum; `tiles` has columns*rows frusta of the same eye, row by row from the top;
  /// near and far are taken from `wall`. Does not allocate.
  void update(const Frustum& wall, std::span<const Frustum> tiles);

  [[nodiscard]] std::uint32_t tileCount() const { return static_cast<std::uint32_t>(tiles_.size()); }
  [[nodiscard]] const Vec3& eye() const { return eye_; }
  /// Node 0 is the root.
  [[nodiscard]] const Node& node(std::uint32_t index) const { return nodes_[index]; }
  /// Of an inner node; the positive child is right of it or below it.
  [[nodiscard]] const BoundedPlane& bisection(std::uint32_t index) const { return bisections_[index]; }
  [[nodiscard]] const FrustumPlanes& primary() const { return primary_; }
  [[nodiscard]] const FrustumPlanes& tile(std::uint32_t tile) const { return tiles_[tile]; }

 private:
  using Corners = std::array<Vec3, 4>;
  void build();
  void measureDepths();
  void updateNearAndFar(const Frustum& wall);
  void updateTile(std::uint32_t tile);
  void updateBisection(std::uint32_t index);
  [[nodiscard]] double overhang(const BoundedPlane& plane, const Node& node, double sign) const;
  [[nodiscard]] const Corners& corners(int column, int row) const;

  std::uint16_t columns_, rows_;
  std::vector<Node> nodes_;
  std::vector<BoundedPlane> bisections_;
  std::vector<FrustumPlanes> tiles_;
  FrustumPlanes primary_;

  Vec3 eye_ = Vec3::Zero();
  Corners wallCorners_;  ///< relative to the eye, as all of the below
  std::vector<Corners> tileCorners_;
  Vec3 axis_ = Vec3::Zero();  ///< unit normal of the image rectangle, away from the eye
  double axisError_ = 0;      ///< how far any tile's own normal may be from it
  double minDepth_ = 0;       ///< of the tiles' corners along the axis
  bool proper_ = true;        ///< all tiles are certainly convex; else no plane but a tile's own culls
};

}  // namespace tessera
