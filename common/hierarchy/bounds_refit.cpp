#include "common/hierarchy/bounds_refit.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <optional>
#include <utility>

#include "common/hierarchy/transformed_bounds.h"

namespace tessera {

namespace {

/// A node with more children gets its axis-aligned box also under BoxFit::Pca: the eigenvectors of thousands
/// of boxes cost a frame and say little.
constexpr std::uint32_t kMaxPcaChildren = 1024;

bool areSame(const Bounds& a, const Bounds& b) {
  return a.aabb.min == b.aabb.min && a.aabb.max == b.aabb.max && a.obb.center == b.obb.center &&
         a.obb.halfAxes == b.obb.halfAxes && a.sphere.center == b.sphere.center &&
         a.sphere.radius == b.sphere.radius;
}

}  // namespace

BoundsRefit::BoundsRefit(ObjectHierarchy& oh, BoxFit fit) : oh_(oh), fit_(fit) {
  touched_.assign((std::size_t{oh.nodeCount()} + 63) / 64, 0);
}

std::uint32_t BoundsRefit::aloneInNode(std::uint32_t leaf) const {
  if (leaf >= oh_.leafCount()) std::abort();
  const std::uint32_t node = oh_.nodeOfLeaf(leaf);
  if (oh_.leaves(node) != LeafRange{leaf, leaf + 1}) std::abort();
  return node;
}

std::uint32_t BoundsRefit::restOf(std::uint32_t leaf) {
  if (restIndex_.empty()) restIndex_.assign(oh_.leafCount(), kNone);
  if (restIndex_[leaf] == kNone) {
    restIndex_[leaf] = static_cast<std::uint32_t>(rests_.size());
    const std::uint32_t node = oh_.nodeOfLeaf(leaf);
    rests_.push_back({oh_.aabbs_[node], oh_.obbs_[node], oh_.spheres_[node]});
    for (std::uint32_t n = node; n != ObjectHierarchy::kNoParent && oh_.moving_[n] == 0; n = oh_.parent_[n])
      oh_.moving_[n] = 1;
  }
  return restIndex_[leaf];
}

BoundsRefit::Moved BoundsRefit::move(std::uint32_t leaf, const Mat4& restToNow) {
  const std::uint32_t node = aloneInNode(leaf);
  const std::uint32_t known = restIndex_.empty() ? kNone : restIndex_[leaf];
  const Bounds rest =
      known != kNone ? rests_[known] : Bounds{oh_.aabbs_[node], oh_.obbs_[node], oh_.spheres_[node]};
  const std::optional<Bounds> now = transformed(rest, restToNow, fit_);
  if (!now) {
    ++refusedMoves_;
    return Moved::KeptLastPlace;
  }
  restOf(leaf);
  place(node, *now);
  return Moved::Done;
}

BoundsRefit::Moved BoundsRefit::setBounds(std::uint32_t leaf, const Bounds& bounds) {
  const std::uint32_t node = aloneInNode(leaf);
  if (!isUsable(bounds)) {
    ++refusedMoves_;
    return Moved::KeptLastPlace;
  }
  rests_[restOf(leaf)] = bounds;
  place(node, bounds);
  return Moved::Done;
}

void BoundsRefit::place(std::uint32_t node, const Bounds& bounds) {
  if (areSame(bounds, {oh_.aabbs_[node], oh_.obbs_[node], oh_.spheres_[node]})) return;
  store(node, bounds);
  changed_ = true;
  changedLeaves_.push_back(oh_.leaves(node).first);
  for (std::uint32_t n = oh_.parent_[node]; n != ObjectHierarchy::kNoParent; n = oh_.parent_[n]) {
    std::uint64_t& word = touched_[n / 64];
    const std::uint64_t bit = std::uint64_t{1} << n % 64;
    if ((word & bit) != 0) return;  // so are all above it
    word |= bit;
  }
}

std::uint32_t BoundsRefit::refit() {
  if (!changed_) return 0;
  std::uint32_t count = 0;
  // A child's number is above its parent's, so descending order is bottom-up.
  for (std::size_t i = touched_.size(); i-- > 0;) {
    for (std::uint64_t word = touched_[i]; word != 0; ++count) {
      const int bit = 63 - std::countl_zero(word);
      word ^= std::uint64_t{1} << bit;
      recompute(static_cast<std::uint32_t>(64 * i) + static_cast<std::uint32_t>(bit));
    }
    touched_[i] = 0;
  }
  changed_ = false;
  std::swap(oh_.changedLeaves_, changedLeaves_);
  changedLeaves_.clear();
  ++oh_.revision_;
  return count;
}

std::uint32_t BoundsRefit::countChildren(std::uint32_t node, std::uint32_t limit) const {
  std::uint32_t count = 0;
  for (std::uint32_t c = node + 1; c != oh_.subtreeEnd_[node] && count < limit; c = oh_.subtreeEnd_[c])
    ++count;
  return count;
}

void BoundsRefit::recompute(std::uint32_t node) {
  const std::uint32_t end = oh_.subtreeEnd_[node];
  if (fit_ == BoxFit::Pca && countChildren(node, kMaxPcaChildren + 1) <= kMaxPcaChildren) {
    enclosing_.clear();
    for (std::uint32_t c = node + 1; c != end; c = oh_.subtreeEnd_[c])
      enclosing_.add(oh_.aabbs_[c], oh_.obbs_[c], oh_.spheres_[c]);
    store(node, enclosing_.result(BoxFit::Pca));
    return;
  }
  // What EnclosingBounds does with BoxFit::AxisAligned, without copying the children's bounds first.
  Bounds bounds;
  for (std::uint32_t c = node + 1; c != end; c = oh_.subtreeEnd_[c])
    bounds.aabb.extend(oh_.aabbs_[c]);
  bounds.obb = Obb::fromAabb(bounds.aabb);
  const Vec3 center = bounds.aabb.center();
  double reach = 0;
  for (std::uint32_t c = node + 1; c != end; c = oh_.subtreeEnd_[c])
    reach = std::max(reach, lengthOf(oh_.spheres_[c].center - center) + oh_.spheres_[c].radius);
  const double diagonal = lengthOf((bounds.aabb.max - center).cwiseMax(center - bounds.aabb.min));
  bounds.sphere = {center, std::min(reach, diagonal) * (1 + 16 * kUnitRoundoff) + 0x1p-1060};
  store(node, bounds);
}

void BoundsRefit::store(std::uint32_t node, const Bounds& bounds) {
  oh_.aabbs_[node] = bounds.aabb;
  oh_.obbs_[node] = bounds.obb;
  oh_.spheres_[node] = bounds.sphere;
}

}  // namespace tessera
