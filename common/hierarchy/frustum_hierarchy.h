#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/bounded_plane.h"
#include "common/geometry/frustum.h"
#include "common/hierarchy/grid_coordinates.h"

namespace tessera {

/// The planes of a frustum that a culler tests, relative to the eye: four sides (bottom, right, top, left),
/// then near and far where there are any.
struct FrustumPlanes {
  std::array<BoundedPlane, 6> planes;
  std::uint32_t count = 0;
  /// A mask with one bit for each plane.
  [[nodiscard]] std::uint32_t all() const { return (1u << count) - 1; }
};

/// The frustum hierarchy (FH) over the tiles of a wall that share one eye: a binary tree that bisects the
/// wall by planes through the eye (Nirnimesh, Harish, Narayanan 2006, section 3), as cullers read it.
/// GridFrusta and GeneralFrusta make one, PlacedFrusta moves one into a model's coordinates.
///
/// Every plane carries a bound (BoundedPlane) under which "outside" means: outside the exact frustum, as
/// defined by its doubles, of every tile on the other side.
class FrustumHierarchy {
 public:
  struct Node {
    std::uint32_t negative = 0, positive = 0;          ///< children; 0 for a leaf
    std::uint32_t firstLeafTile = 0, endLeafTile = 0;  ///< of a leaf
    /// Planes of the primary frustum that still bound what is below the child; the others are replaced by
    /// the bisection plane itself.
    std::uint32_t keepNegative = ~0u, keepPositive = ~0u;
    [[nodiscard]] bool isLeaf() const { return negative == 0; }
  };
  /// A tile that a leaf of FH stands for. Where leaves do not fill their parents (gaps, overlaps), what
  /// arrives has still to be tested against `mask`, the tile's planes that the way here does not imply: the
  /// terminal test of section 4.2. A tile may stand in several leaves, and a leaf for several tiles.
  struct LeafTile {
    std::uint32_t tile = 0;
    std::uint32_t mask = 0;
    bool boundedByPrimary = true;  ///< the planes left of the primary frustum are the tile's own
  };

  [[nodiscard]] std::uint32_t tileCount() const { return static_cast<std::uint32_t>(tiles_.size()); }
  [[nodiscard]] const Vec3& eye() const { return eye_; }
  [[nodiscard]] std::uint32_t nodeCount() const { return static_cast<std::uint32_t>(nodes_.size()); }
  /// Node 0 is the root.
  [[nodiscard]] const Node& node(std::uint32_t index) const { return nodes_[index]; }
  [[nodiscard]] std::span<const LeafTile> leafTiles(const Node& leaf) const {
    return {leafTiles_.data() + leaf.firstLeafTile, leafTiles_.data() + leaf.endLeafTile};
  }
  /// Of an inner node.
  [[nodiscard]] const BoundedPlane& bisection(std::uint32_t index) const { return bisections_[index]; }
  /// Holds all tiles. May have no planes, where the tiles surround the eye.
  [[nodiscard]] const FrustumPlanes& primary() const { return primary_; }
  [[nodiscard]] const FrustumPlanes& tile(std::uint32_t tile) const { return tiles_[tile]; }
  /// Where the tiles are an even grid and nothing stands against them.
  [[nodiscard]] const std::optional<GridCoordinates>& grid() const { return grid_; }

  /// Widens every plane such that a tile holds what either of two eyes sees through it, so that one traversal
  /// serves a stereo pair: after an update with the frusta of an eye between them. `left` and `right` are the
  /// tiles' frusta by each eye, with the image rectangles of the tiles. grid() is nothing from then on, until
  /// the next update.
  ///
  /// Derivation: a point of the cone of eye e is p = e + q, q in the cone of its corner rays, so that
  /// n.q >= -a |q| for a plane n whose sides those rays stick out over by the angle a. With d = e - eye(),
  /// relative to eye() the value is n.(d + q) >= n.d - a |q| >= n.d - a |d| - a |p|.
  void holdEyes(std::span<const Frustum> left, std::span<const Frustum> right);

 protected:
  FrustumHierarchy() = default;
  ~FrustumHierarchy() = default;
  FrustumHierarchy(const FrustumHierarchy&) = default;
  FrustumHierarchy& operator=(const FrustumHierarchy&) = default;

  Vec3 eye_ = Vec3::Zero();
  std::vector<Node> nodes_;
  std::vector<LeafTile> leafTiles_;
  std::vector<BoundedPlane> bisections_;
  std::vector<FrustumPlanes> tiles_;
  FrustumPlanes primary_;
  std::optional<GridCoordinates> grid_;

 private:
  struct EyeCones;
  std::vector<std::uint8_t> tilesBelow_;  ///< holdEyes' notes: which tiles are below a child
};

}  // namespace tessera
