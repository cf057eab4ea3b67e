#pragma once

#include <cstdint>
#include <vector>

#include "common/hierarchy/frustum_hierarchy.h"

namespace tessera::cull {

/// Remembers, for nodes that a plane rejected, how far outside they were, and tells from the eye's path and
/// the planes' turning alone whether they still are (Real-Time Rendering, section 14.3; Assarsson and Moeller
/// 2000: for a viewer that only moves the distance changes by the same amount for all nodes, for one that
/// only turns by no more than the angle times the node's distance from the eye).
///
/// Derivation. With n the exact unit normal of a plane through the eye e (or at a distance D from it), a
/// point p = x - e of the node has n.p - D <= -m. Over one step n' = n + dn, e' = e + de, D' = D + dD: n'.p'
/// - D' = n.p - D + dn.p' - n.de - dD. Summed over steps, with S the sum of n.de + dD, A of |dn|, L of |de|,
/// and |p'| never more than reach + L: the node is outside while m + S - A (reach + L) > 0. The stored
/// normals differ from the exact ones by a relative d = |errorPerUnit| / |n|, so A also takes 2d + 2d' a step
/// and E, which is subtracted, takes (2d + 8u)|de| and the rounding of the sums.
class MotionCache {
 public:
  /// Forgets everything; `slots` frusta and `nodes` nodes.
  void reset(std::uint32_t slots, std::uint32_t nodes);
  [[nodiscard]] bool fits(std::uint32_t slots, std::uint32_t nodes) const {
    return slots_ == slots && nodes_ == nodes;
  }

  /// Moves one frustum's planes to this frame.
  void advance(std::uint32_t slot, const FrustumPlanes& planes, const Vec3& eye);

  /// True where the node is certainly outside the frustum still. NaN anywhere: false.
  [[nodiscard]] bool isOutside(std::uint32_t slot, std::uint32_t node) const {
    const Entry& entry = entries_[std::size_t{slot} * nodes_ + node];
    if (entry.plane == kNone) return false;
    const Track& track = tracks_[std::size_t{slot} * kPlanes + entry.plane];
    const double turned = track.turned - entry.turned;
    const double reach = entry.reach + track.length;
    const double left = entry.margin + track.approach - track.error - turned * reach;
    return left > 1e-12 * (entry.magnitude + turned * reach) + 0x1p-1000;  // the latter for underflow
  }

  /// Notes that the plane rejects the node now, `outsideBy` (> 0) in the plane's own units.
  void remember(std::uint32_t slot, std::uint32_t node, std::uint32_t plane, double outsideBy, double reach);
  void forget(std::uint32_t slot, std::uint32_t node) {
    entries_[std::size_t{slot} * nodes_ + node].plane = kNone;
  }

 private:
  static constexpr std::uint32_t kPlanes = 6, kNone = UINT32_MAX;
  /// Of one plane, since the reset.
  struct Track {
    Vec3 unitNormal = Vec3::Zero();
    double length = 0;    ///< of the eye's path (L)
    double approach = 0;  ///< by how much everything came to lie further outside (S)
    double turned = 0;    ///< of the plane's normal (A)
    double error = 0;     ///< E
    double defect = 0;    ///< d of the present plane
    double scale = 1;     ///< |normal| of the present plane
    double distance = 0;  ///< D / |normal|
  };
  struct Entry {
    double margin = 0, turned = 0, reach = 0, magnitude = 0;
    std::uint32_t plane = kNone;
  };
  std::uint32_t slots_ = 0, nodes_ = 0;
  std::vector<std::uint32_t> counts_;  ///< planes of each slot
  std::vector<Vec3> eyes_;
  std::vector<Track> tracks_;
  std::vector<Entry> entries_;
};

}  // namespace tessera::cull
