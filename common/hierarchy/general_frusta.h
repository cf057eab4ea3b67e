#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/frustum.h"
#include "common/hierarchy/frustum_hierarchy.h"
#include "common/hierarchy/tile_cone.h"

namespace tessera {

/// The frustum hierarchy of any set of frusta that share one eye: gaps, overlaps, different sizes, several
/// screens. Built by recursive bisection: of all sides of the frusta, the plane is taken that promises the
/// fewest plane tests; a frustum that straddles it goes to both halves, so an overlapping region becomes a
/// leaf of its own with all its frusta where that is cheaper than testing them apart (section 3 of
/// Nirnimesh, Harish, Narayanan 2006). What arrives at a leaf meets the terminal test against the planes that
/// its way there has not implied (section 4.2).
///
/// The topology is kept while the arrangement stays rigid (a moving camera); it is built anew when frusta
/// come to stick out over their half by more than kStaleAngle, as when an observer moves before fixed
/// screens.
class GeneralFrusta : public FrustumHierarchy {
 public:
  struct Options {
    /// Overlapping frusta are separated where the plane tests this saves outweigh the doubled ones; off:
    /// they always share a leaf.
    bool separateOverlaps = true;
    PlaneSource source = PlaneSource::Corners;
  };
  GeneralFrusta() = default;
  explicit GeneralFrusta(const Options& options) : options_(options) {}

  /// At least one frustum; all of one eye (aborts otherwise).
  void update(std::span<const Frustum> frusta);
  /// How often the topology was built.
  [[nodiscard]] std::uint32_t builds() const { return builds_; }

 private:
  static constexpr double kStaleAngle = 1e-6;

  /// Which half of a bisection a frustum lies in, with an angle of at most kStaleAngle across.
  enum class Half { Negative, Positive, Both };
  struct Part {
    std::uint32_t tile;
    std::uint32_t mask;  ///< planes of the tile that the way here does not imply
  };
  struct Split {
    std::uint32_t tile, side;  ///< whose plane
    std::uint32_t firstPart, endPart;
  };

  void build();
  [[nodiscard]] bool chooseSplit(std::span<const Part> parts, Split& best) const;
  [[nodiscard]] Half halfOf(const BoundedPlane& plane, std::uint32_t tile) const;
  [[nodiscard]] bool updateBisections();
  void updateTiles(std::span<const Frustum> frusta);
  void updatePrimary();

  Options options_;
  std::vector<TileCone> cones_;
  std::vector<Split> splits_;  ///< parallel to nodes_; of inner nodes
  std::vector<Part> parts_;    ///< of all inner nodes, by Split
  std::vector<Half> halves_;   ///< parallel to parts_
  std::uint32_t builds_ = 0;
};

}  // namespace tessera
