#include "common/hierarchy/frustum_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/hierarchy/tile_cone.h"

namespace tessera {

namespace {

constexpr std::uint32_t kFirstDepthPlane = 4;
constexpr std::uint8_t kBelowNegative = 1, kBelowPositive = 2;

/// By how much a plane must be widened: an angle, and a length at the eye.
struct Widening {
  double angle = 0, length = 0;
  void hold(const Widening& other) {
    angle = std::max(angle, other.angle);
    length = std::max(length, other.length);
  }
  void apply(BoundedPlane& plane) const {
    widen(plane, angle);
    plane.errorConstant += length;
  }
};

/// One tile as one eye sees it.
struct EyeCone {
  TileCone cone;
  Vec3 fromEye;  ///< from the hierarchy's

  EyeCone(const Frustum& frustum, const Vec3& eye)
      : cone(frustum, std::nullopt), fromEye(frustum.eye - eye) {}

  /// What holds it where sign * plane is not negative.
  [[nodiscard]] Widening over(const BoundedPlane& plane, double sign) const {
    constexpr double kSlack = 1 + 16 * kUnitRoundoff;
    if (!cone.isProper) return {std::numeric_limits<double>::infinity(), 0};
    const double angle = cone.overhang(plane, sign) / cone.minDepth * kSlack;
    const double rounding = 8 * kUnitRoundoff * plane.normal.cwiseAbs().dot(fromEye.cwiseAbs()) + 0x1p-1060;
    const double behind = std::max(0.0, -sign * plane.normal.dot(fromEye));
    return {angle, (behind + angle * fromEye.norm() + rounding) * kSlack};
  }
  /// Near and far are counted from each eye, along the normal of the image rectangle as its own doubles have
  /// it: as they stand, moved by the eye.
  [[nodiscard]] Widening overDepth(const BoundedPlane& plane) const {
    constexpr double kSlack = 1 + 16 * kUnitRoundoff;
    const Vec3 axis = plane.normal.dot(cone.axis) < 0 ? Vec3(-cone.axis) : cone.axis;
    const double angle = ((axis - plane.normal).norm() + cone.axisError) * kSlack;
    return {angle, kSlack * (plane.normal.cwiseAbs().dot(fromEye.cwiseAbs()) + angle * fromEye.norm())};
  }
};

}  // namespace

struct FrustumHierarchy::EyeCones {
  std::vector<EyeCone> left, right;

  [[nodiscard]] Widening over(std::uint32_t tile, const BoundedPlane& plane, double sign) const {
    Widening widening = left[tile].over(plane, sign);
    widening.hold(right[tile].over(plane, sign));
    return widening;
  }
  [[nodiscard]] Widening overDepth(std::uint32_t tile, const BoundedPlane& plane) const {
    Widening widening = left[tile].overDepth(plane);
    widening.hold(right[tile].overDepth(plane));
    return widening;
  }
};

void FrustumHierarchy::holdEyes(std::span<const Frustum> left, std::span<const Frustum> right) {
  grid_.reset();
  EyeCones eyes;
  for (std::uint32_t t = 0; t < tileCount(); ++t) {
    eyes.left.emplace_back(left[t], eye_);
    eyes.right.emplace_back(right[t], eye_);
  }
  for (std::uint32_t t = 0; t < tileCount(); ++t) {
    for (std::uint32_t p = 0; p < tiles_[t].count; ++p) {
      BoundedPlane& plane = tiles_[t].planes[p];
      (p < kFirstDepthPlane ? eyes.over(t, plane, 1) : eyes.overDepth(t, plane)).apply(plane);
    }
  }
  for (std::uint32_t p = 0; p < primary_.count; ++p) {
    BoundedPlane& plane = primary_.planes[p];
    Widening widening;
    for (std::uint32_t t = 0; t < tileCount(); ++t)
      widening.hold(p < kFirstDepthPlane ? eyes.over(t, plane, 1) : eyes.overDepth(t, plane));
    widening.apply(plane);
  }
  // Children come after their parents, so from the back every node knows what is below it.
  const std::size_t tiles = tileCount();
  tilesBelow_.assign(nodes_.size() * tiles, 0);
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    const Node& node = nodes_[i];
    std::uint8_t* below = tilesBelow_.data() + i * tiles;
    if (node.isLeaf()) {
      for (const LeafTile& leaf : leafTiles(node))
        below[leaf.tile] = kBelowNegative | kBelowPositive;
      continue;
    }
    const std::uint8_t* negative = tilesBelow_.data() + node.negative * tiles;
    const std::uint8_t* positive = tilesBelow_.data() + node.positive * tiles;
    Widening widening;
    for (std::uint32_t t = 0; t < tiles; ++t) {
      below[t] =
          static_cast<std::uint8_t>((negative[t] ? kBelowNegative : 0) | (positive[t] ? kBelowPositive : 0));
      // A tile in both halves may lie on either side.
      if (below[t] == kBelowPositive) widening.hold(eyes.over(t, bisections_[i], 1));
      if (below[t] == kBelowNegative) widening.hold(eyes.over(t, bisections_[i], -1));
    }
    widening.apply(bisections_[i]);
  }
}

}  // namespace tessera
