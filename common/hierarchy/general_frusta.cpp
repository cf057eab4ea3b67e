#include "common/hierarchy/general_frusta.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <Eigen/Geometry>

namespace tessera {

namespace {

double angleOf(const TileCone& cone, const BoundedPlane& plane, double sign) {
  return cone.isProper ? cone.overhang(plane, sign) / cone.minDepth * (1 + 8 * kUnitRoundoff)
                       : std::numeric_limits<double>::infinity();
}

}  // namespace

void GeneralFrusta::update(std::span<const Frustum> frusta) {
  if (frusta.empty()) std::abort();
  for (const Frustum& frustum : frusta) {
    if (frustum.eye != frusta[0].eye) std::abort();
  }
  const bool sameCount = cones_.size() == frusta.size();
  eye_ = frusta[0].eye;
  cones_.resize(frusta.size());
  for (std::size_t t = 0; t < frusta.size(); ++t)
    cones_[t] = TileCone(frusta[t], std::nullopt);
  updateTiles(frusta);
  updatePrimary();
  if (!sameCount || !updateBisections()) {
    build();
    static_cast<void>(updateBisections());
  }
}

void GeneralFrusta::updateTiles(std::span<const Frustum> frusta) {
  tiles_.resize(frusta.size());
  for (std::size_t t = 0; t < frusta.size(); ++t) {
    FrustumPlanes& planes = tiles_[t];
    cones_[t].sides(planes, options_.source);
    planes.count = 4;
    if (frusta[t].near) addDepthPlane(planes, cones_[t].axis, cones_[t].axisError, *frusta[t].near, 1);
    if (frusta[t].far) addDepthPlane(planes, cones_[t].axis, cones_[t].axisError, *frusta[t].far, -1);
  }
}

/// A pyramid about the mean direction, where all frusta lie well before the eye; else no planes.
void GeneralFrusta::updatePrimary() {
  constexpr double kLeastCosine = 0.02;
  primary_.count = 0;
  Vec3 mean = Vec3::Zero();
  for (const TileCone& cone : cones_) {
    if (!cone.isProper) return;
    for (const Vec3& k : cone.corners)
      mean += k.normalized();
  }
  if (!(mean.norm() > 0)) return;
  const Vec3 axis = mean.normalized();
  const Vec3 right = (cones_[0].corners[1] - cones_[0].corners[0]).cross(axis).cross(axis).normalized() * -1;
  const Vec3 up = right.cross(axis);
  double left = 0, rightmost = 0, bottom = 0, top = 0;
  bool first = true;
  for (const TileCone& cone : cones_) {
    for (const Vec3& k : cone.corners) {
      const double depth = axis.dot(k);
      if (!(depth > kLeastCosine * k.norm())) return;
      const double x = right.dot(k) / depth, y = up.dot(k) / depth;
      left = first ? x : std::min(left, x), rightmost = first ? x : std::max(rightmost, x);
      bottom = first ? y : std::min(bottom, y), top = first ? y : std::max(top, y);
      first = false;
    }
  }
  const auto corner = [&](double x, double y) { return Vec3(axis + x * right + y * up); };
  const std::array<Vec3, 4> corners = {corner(left, bottom), corner(rightmost, bottom),
                                       corner(rightmost, top), corner(left, top)};
  for (std::size_t i = 0; i < 4; ++i) {
    primary_.planes[i] = planeThroughEye(corners[i], corners[(i + 1) % 4]);
    double angle = 0;
    for (const TileCone& cone : cones_)
      angle = std::max(angle, angleOf(cone, primary_.planes[i], 1));
    widen(primary_.planes[i], angle);
  }
  primary_.count = 4;
}

GeneralFrusta::Half GeneralFrusta::halfOf(const BoundedPlane& plane, std::uint32_t tile) const {
  const double scale = plane.normal.norm();
  if (angleOf(cones_[tile], plane, 1) <= 0.5 * kStaleAngle * scale) return Half::Positive;
  if (angleOf(cones_[tile], plane, -1) <= 0.5 * kStaleAngle * scale) return Half::Negative;
  return Half::Both;
}

bool GeneralFrusta::chooseSplit(std::span<const Part> parts, Split& best) const {
  if (parts.size() < 2) return false;
  double planes = 0;
  for (const Part& part : parts)
    planes += std::popcount(part.mask);
  double bestCost = planes;  // all of them tested here
  bool found = false;
  // Of a big set a sample of the sides is good enough: each halves it about as well as its neighbours. Odd
  // steps come by all four sides.
  constexpr std::size_t kMostCandidates = 256;
  const std::size_t step = (4 * parts.size() / kMostCandidates) | 1;
  for (std::size_t candidate = 0; candidate < 4 * parts.size(); candidate += step) {
    const std::uint32_t tile = parts[candidate / 4].tile;
    const auto side = static_cast<std::uint32_t>(candidate % 4);
    if (!cones_[tile].isProper) continue;
    const BoundedPlane& plane = cones_[tile].cornerSides[side];
    double negative = 0, positive = 0, negativePlanes = 0, positivePlanes = 0, both = 0;
    for (const Part& part : parts) {
      const Half half = halfOf(plane, part.tile);
      const double own = part.tile == tile ? 1 : 0;  // the split implies this side
      const double left = std::popcount(part.mask);
      if (half != Half::Negative) ++positive, positivePlanes += left - own;
      if (half != Half::Positive) ++negative, negativePlanes += left;
      if (half == Half::Both) ++both;
    }
    const double count = static_cast<double>(parts.size());
    if (both > 0 && !options_.separateOverlaps) continue;
    if (negative == count && positive == count) continue;
    // An object is taken to lie in a half as often as frusta do, and to be tested there against all that is
    // left: what is split further costs less, so a split that does not pay even so never will.
    const double share = (negative - both / 2) / count;
    const double cost = 1 + share * negativePlanes + (1 - share) * positivePlanes;
    if (cost < bestCost) {
      bestCost = cost;
      best.tile = tile;
      best.side = side;
      found = true;
    }
  }
  return found;
}

void GeneralFrusta::build() {
  ++builds_;
  nodes_.clear(), leafTiles_.clear(), splits_.clear(), parts_.clear(), halves_.clear();
  // Straddling frusta stand in several leaves; no more than this many places in all.
  const std::size_t mostLeafTiles = 64 + 16 * cones_.size();
  std::vector<std::vector<Part>> partsOf(1);
  for (std::uint32_t t = 0; t < cones_.size(); ++t)
    partsOf[0].push_back({t, tiles_[t].all()});
  nodes_.push_back({});
  splits_.push_back({});
  std::size_t pending = cones_.size();
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    const std::vector<Part> parts = std::move(partsOf[i]);
    Split split{};
    if (pending > mostLeafTiles || !chooseSplit(parts, split)) {
      nodes_[i].firstLeafTile = static_cast<std::uint32_t>(leafTiles_.size());
      for (const Part& part : parts)
        leafTiles_.push_back({.tile = part.tile, .mask = part.mask, .boundedByPrimary = false});
      nodes_[i].endLeafTile = static_cast<std::uint32_t>(leafTiles_.size());
      continue;
    }
    const BoundedPlane& plane = cones_[split.tile].cornerSides[split.side];
    split.firstPart = static_cast<std::uint32_t>(parts_.size());
    std::vector<Part> negative, positive;
    for (const Part& part : parts) {
      const Half half = halfOf(plane, part.tile);
      parts_.push_back(part);
      halves_.push_back(half);
      if (half != Half::Positive) negative.push_back(part);
      if (half != Half::Negative) {
        positive.push_back(part);
        if (part.tile == split.tile) positive.back().mask &= ~(1u << split.side);
      }
    }
    split.endPart = static_cast<std::uint32_t>(parts_.size());
    pending += negative.size() + positive.size() - parts.size();
    splits_[i] = split;
    nodes_[i].negative = static_cast<std::uint32_t>(nodes_.size());
    nodes_[i].positive = nodes_[i].negative + 1;
    nodes_.resize(nodes_.size() + 2);
    splits_.resize(nodes_.size());
    partsOf.push_back(std::move(negative));
    partsOf.push_back(std::move(positive));
  }
  bisections_.resize(nodes_.size());
}

/// Derives the planes from the frusta as they are now, and widens each by what sticks out over it. False
/// where the arrangement has changed so much that the topology no longer fits.
bool GeneralFrusta::updateBisections() {
  bool fits = true;
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].isLeaf()) continue;
    const Split& split = splits_[i];
    BoundedPlane& plane = bisections_[i] = cones_[split.tile].cornerSides[split.side];
    double angle = 0;
    for (std::uint32_t p = split.firstPart; p < split.endPart; ++p) {
      if (halves_[p] == Half::Both) continue;
      angle = std::max(angle, angleOf(cones_[parts_[p].tile], plane, halves_[p] == Half::Positive ? 1 : -1));
    }
    fits = fits && angle <= kStaleAngle * plane.normal.norm();
    widen(plane, angle);
  }
  return fits && !nodes_.empty();
}

}  // namespace tessera
