#include "common/cull/motion_cache.h"

#include <cmath>

namespace tessera::cull {

void MotionCache::reset(std::uint32_t slots, std::uint32_t nodes) {
  slots_ = slots;
  nodes_ = nodes;
  counts_.assign(slots, 0);
  eyes_.assign(slots, Vec3::Zero());
  tracks_.assign(std::size_t{slots} * kPlanes, {});
  entries_.assign(std::size_t{slots} * nodes, {});
}

void MotionCache::advance(std::uint32_t slot, const FrustumPlanes& planes, const Vec3& eye) {
  constexpr double u = kUnitRoundoff;
  if (counts_[slot] != planes.count) {  // the first frame, or a depth plane came or went
    for (std::uint32_t node = 0; node < nodes_; ++node)
      forget(slot, node);
    counts_[slot] = planes.count;
    eyes_[slot] = eye;
    for (std::uint32_t p = 0; p < kPlanes; ++p)
      tracks_[std::size_t{slot} * kPlanes + p] = {};
  }
  const Vec3 step = eye - eyes_[slot];
  const double length = step.cwiseAbs().sum();  // no less than |step|
  eyes_[slot] = eye;
  for (std::uint32_t p = 0; p < planes.count; ++p) {
    Track& track = tracks_[std::size_t{slot} * kPlanes + p];
    const BoundedPlane& plane = planes.planes[p];
    const double scale = plane.normal.norm();
    const Vec3 normal = plane.normal / scale;
    const double distance = plane.distance / scale;
    const double defect = plane.errorPerUnit.norm() / scale + 8 * u;
    track.approach += track.unitNormal.dot(step) + (distance - track.distance);
    track.turned += (normal - track.unitNormal).norm() + 2 * track.defect + 2 * defect + 8 * u;
    track.length += length * (1 + 8 * u);
    track.error += (2 * track.defect + 2 * defect + 8 * u) * length + 8 * u * std::abs(track.approach) +
                   8 * u * (std::abs(distance) + std::abs(track.distance)) + 2 * plane.errorConstant / scale;
    track.unitNormal = normal;
    track.defect = defect;
    track.scale = scale;
    track.distance = distance;
  }
}

void MotionCache::remember(std::uint32_t slot, std::uint32_t node, std::uint32_t plane, double outsideBy,
                           double reach) {
  const Track& track = tracks_[std::size_t{slot} * kPlanes + plane];
  Entry& entry = entries_[std::size_t{slot} * nodes_ + node];
  if (!(track.defect < 1e-3)) {
    entry.plane = kNone;
    return;
  }
  const double margin = outsideBy / track.scale * (1 - 4 * track.defect);
  // The sums so far are taken off here, so that asking is one expression.
  entry.margin = margin - track.approach + track.error;
  entry.turned = track.turned;
  entry.reach = reach - track.length;
  entry.magnitude = std::abs(margin) + std::abs(track.approach) + track.error;
  entry.plane = plane;
}

}  // namespace tessera::cull
