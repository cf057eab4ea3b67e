#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "common/cull/bounds_view.h"
#include "common/cull/motion_cache.h"
#include "common/cull/options.h"
#include "common/hierarchy/frustum_hierarchy.h"

namespace tessera::cull {

/// Tests bounds against all planes of a frustum, with the switches, and keeps what they remember from frame
/// to frame: slot 0 for the primary frustum, 1 + t for tile t.
class PlaneTester {
 public:
  /// Before the first test of a frame. Where remembering for every tile would take more than
  /// kMostCacheBytes, only the primary frustum remembers.
  void beginFrame(const ObjectHierarchy& oh, const FrustumHierarchy& frusta, const Switches& switches,
                  bool testsTiles);

  /// Tests the planes of `mask`. False: outside. Planes that the bound is wholly inside of leave the mask:
  /// nothing below the node can be outside of them.
  template <class View>
  bool test(View& bounds, const FrustumPlanes& planes, std::uint32_t slot, std::uint32_t node,
            std::uint32_t& mask, TestCounts& counts) {
    ++counts.nodes;
    const bool remembers = slot < slots_;
    if (remembers && switches_.motionCoherence && motion_.isOutside(slot, node)) {
      ++counts.remembered;
      return false;
    }
    std::uint32_t left = mask;
    std::uint8_t* last = nullptr;
    if (remembers && switches_.planeCoherency) {
      last = &lastPlane_[std::size_t{slot} * nodes_ + node];
      if (*last < planes.count && (left & (1u << *last))) {
        const std::uint32_t p = *last;
        if (!testOne(bounds, planes.planes[p], p, slot, node, mask, counts)) return false;
        left &= ~(1u << p);
      }
    }
    std::uint32_t spared = 0;
    if (switches_.octantTest) {
      spared = sparedByOctant(bounds.center(), slot) & left;
      counts.octantSpared += static_cast<std::uint64_t>(std::popcount(spared));
      left &= ~spared;
    }
    for (std::uint32_t p = 0; p < planes.count; ++p) {
      if (!(left & (1u << p))) continue;
      if (!testOne(bounds, planes.planes[p], p, slot, node, mask, counts)) {
        if (last) *last = static_cast<std::uint8_t>(p);
        return false;
      }
    }
    if (spared != 0) {
      mask &= switches_.octantPitfall
                  ? ~spared
                  : ~insideBySymmetry(bounds.center(), bounds.centerRadius(), slot, spared, mask);
    }
    return true;
  }

 private:
  static constexpr std::uint64_t kMostCacheBytes = 256u << 20;

  template <class View>
  bool testOne(View& bounds, const BoundedPlane& plane, std::uint32_t p, std::uint32_t slot,
               std::uint32_t node, std::uint32_t& mask, TestCounts& counts) {
    ++(slot == 0 ? counts.primary : counts.tile);
    const Side side = bounds.side(plane, counts);
    if (side == Side::Inside) mask &= ~(1u << p);
    if (side != Side::Outside) return true;
    if (switches_.motionCoherence && slot < slots_)
      motion_.remember(slot, node, p, bounds.outsideBy(plane), bounds.reach());
    return false;
  }

  /// The middle plane between two opposite ones: positive nearer to the second.
  struct Middle {
    std::array<Vec3, 2> unitNormals = {Vec3::Zero(), Vec3::Zero()};
    std::array<double, 2> distances = {0, 0};
    Vec3 normal = Vec3::Zero();
    double distance = 0;
    std::uint32_t first = 0, second = 0;  ///< mask bits; both 0 where there is no such pair
  };
  static std::array<Middle, 3> middlesOf(const FrustumPlanes& planes);

  /// Of left and right, bottom and top, near and far the one that is farther from the centre. A bound about a
  /// centre between the two cannot be outside of that one; elsewhere, and where rounding chooses wrongly, a
  /// plane that might have rejected is left out: excess, never a drop.
  std::uint32_t sparedByOctant(const Vec3& center, std::uint32_t slot) const {
    std::uint32_t spared = 0;
    for (const Middle& middle : octants_[slot])
      spared |= middle.normal.dot(center) >= middle.distance ? middle.first : middle.second;
    return spared;
  }

  /// Those of the spared planes that a ball about the centre is wholly inside of, because it is inside of the
  /// opposite plane, which is nearer. Wrong for a box only in what it adds: a mask never makes a drop.
  std::uint32_t insideBySymmetry(const Vec3& center, double radius, std::uint32_t slot, std::uint32_t spared,
                                 std::uint32_t mask) const {
    std::uint32_t inside = 0;
    for (const Middle& middle : octants_[slot]) {
      const bool sparesFirst = (spared & middle.first) != 0;
      if (!sparesFirst && !(spared & middle.second)) continue;
      const std::size_t nearer = sparesFirst ? 1 : 0;
      if (mask & (sparesFirst ? middle.second : middle.first)) continue;  // cut by the nearer
      if (middle.unitNormals[nearer].dot(center) - middle.distances[nearer] >= radius)
        inside |= sparesFirst ? middle.first : middle.second;
    }
    return inside;
  }

  Switches switches_;
  std::uint32_t slots_ = 0, nodes_ = 0;  ///< of what is remembered
  std::uint64_t revision_ = 0;
  std::vector<std::array<Middle, 3>> octants_;  ///< by slot
  std::vector<std::uint8_t> lastPlane_;
  MotionCache motion_;
};

}  // namespace tessera::cull
