#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "common/cull/culler.h"
#include "common/geometry/exact_frustum.h"
#include "common/hierarchy/object_hierarchy.h"
#include "common/wall/wall.h"

namespace tessera::test {

using Triangle = std::array<Vec3, 3>;

/// A grid of tiles of 64x48 pixels, without near and far.
[[nodiscard]] Wall gridWall(int columns, int rows, double fovYDeg);

/// Random geometry, easy and hard. Seeded: the same numbers on every run.
class Geometry {
 public:
  explicit Geometry(std::uint64_t seed) : random_(seed) {}

  [[nodiscard]] Vec3 vector(double size) {
    return {size * unit_(random_), size * unit_(random_), size * unit_(random_)};
  }
  [[nodiscard]] double unit01() { return unit01_(random_); }
  [[nodiscard]] std::uint64_t below(std::uint64_t limit) { return random_() % limit; }
  [[nodiscard]] std::mt19937_64& engine() { return random_; }

  /// Anywhere within `size` of the centre, `size` or up to a thousand times smaller itself.
  [[nodiscard]] Triangle any(const Vec3& center, double size);
  /// Hard to judge: a corner on a tile's edge, ray or plane, or off it by an ulp; also points and segments.
  [[nodiscard]] Triangle hard(std::span<const Frustum> tiles);
  /// About the eye, spanning its plane, or enclosing everything.
  [[nodiscard]] Triangle aboutTheEye(const Vec3& eye, double size);

 private:
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> unit_{-1, 1}, unit01_{0, 1};
};

/// A scene of single triangles in a tree of random shape.
struct TriangleScene {
  std::vector<Triangle> leaves;
  ObjectHierarchy hierarchy;

  void build(std::mt19937_64& random);
  [[nodiscard]] std::vector<Bounds> bounds() const;
};

/// Which leaves meet which tile, in exact arithmetic; by tile, then leaf.
[[nodiscard]] std::vector<std::vector<bool>> exactVisibility(std::span<const Frustum> tiles,
                                                             std::span<const Triangle> leaves);

struct Candidate {
  std::string name;
  cull::Options options;
};
/// Every algorithm with every bound, and every switch where it has an effect.
[[nodiscard]] std::vector<Candidate> allCandidates();

/// The first leaf that must be in a tile's list and is not, as "leaf L of tile T", or a list that is not
/// canonical; empty where all is well. `order` maps leaf ids of the lists to indices of `meets`; empty: the
/// same.
[[nodiscard]] std::string firstDrop(const cull::Result& result, const std::vector<std::vector<bool>>& meets,
                                    std::span<const std::uint32_t> order = {});

}  // namespace tessera::test
