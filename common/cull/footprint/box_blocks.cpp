#include "common/cull/footprint/box_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera::cull {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

float roundedUp(double x) {
  const auto nearest = static_cast<float>(x);
  return double{nearest} < x ? std::nextafter(nearest, kInfinity) : nearest;
}

/// Rounded outward. What is not finite stays so: such a box is never decided by a kernel.
Aabb aabbOf(const Obb& box) {
  Vec3 half = box.halfAxes[0].cwiseAbs() + box.halfAxes[1].cwiseAbs() + box.halfAxes[2].cwiseAbs();
  half += 8 * kUnitRoundoff * (half + box.center.cwiseAbs()) + Vec3::Constant(1e-300);
  Aabb aabb;
  aabb.min = box.center - half;
  aabb.max = box.center + half;
  return aabb;
}

/// The union of boxes; NaN where one of them is not finite.
class Union {
 public:
  void add(const Aabb& box) {
    isFinite_ = isFinite_ && isFinite(box.min) && isFinite(box.max);
    box_.extend(box);
  }
  [[nodiscard]] Aabb box() const {
    Aabb nan;
    nan.min = nan.max = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
    return isFinite_ ? box_ : nan;
  }

 private:
  Aabb box_;
  bool isFinite_ = true;
};

}  // namespace

Obb BoxTree::boxOf(const ObjectHierarchy& oh, std::uint32_t leaf) const {
  const std::uint32_t node = oh.nodeOfLeaf(leaf);
  const bool aligned = bounds_ == BoundsKind::Aabb || (bounds_ == BoundsKind::Hybrid && oh.isMoving(node));
  return aligned ? Obb::fromAabb(oh.aabb(node)) : oh.obb(node);
}

void BoxTree::setLeaf(std::uint32_t leaf, const Obb& box) {
  OrientedBlock& block = leaves_[leaf / kLanes];
  const std::size_t lane = leaf % kLanes;
  double extent = 0;
  for (int axis = 0; axis < 3; ++axis)
    block.center[axis][lane] = box.center[axis];
  for (std::size_t k = 0; k < 3; ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      const double component = scale_ * box.halfAxes[k][axis];
      block.half[3 * k + static_cast<std::size_t>(axis)][lane] = static_cast<float>(component);
      extent += std::abs(component);
    }
  }
  block.extent[lane] = roundedUp(extent * (1 + 16 * kUnitRoundoff) + 0x1p-96);
}

OrientedBox BoxTree::single(std::uint32_t leaf) const {
  const OrientedBlock& block = leaves_[leaf / kLanes];
  const std::size_t lane = leaf % kLanes;
  OrientedBox box;
  for (std::size_t i = 0; i < 3; ++i)
    box.center[i] = block.center[i][lane];
  for (std::size_t i = 0; i < 9; ++i)
    box.half[i] = block.half[i][lane];
  box.extent = block.extent[lane];
  return box;
}

void BoxTree::keepSingles() {
  if (!singles_.empty()) return;
  singles_.resize(leafCount_);
  for (std::uint32_t leaf = 0; leaf < leafCount_; ++leaf)
    singles_[leaf] = single(leaf);
}

void BoxTree::setNode(std::size_t level, std::uint32_t node, const Aabb& box) {
  boxes_[level][node] = box;
  AlignedBlock& block = levels_[level].blocks[node / kLanes];
  const std::size_t lane = node % kLanes;
  for (int axis = 0; axis < 3; ++axis) {
    const double center = 0.5 * box.min[axis] + 0.5 * box.max[axis];
    const double half = std::max(box.max[axis] - center, center - box.min[axis]);
    block.center[axis][lane] = center;
    block.half[axis][lane] = roundedUp(scale_ * (half * (1 + 8 * kUnitRoundoff)) + 0x1p-96);
  }
}

Aabb BoxTree::aabbOfNode(const ObjectHierarchy& oh, std::size_t level, std::uint32_t node) const {
  Union all;
  const std::size_t first = node * kLanes;
  if (level == 0) {
    for (std::size_t leaf = first; leaf < std::min<std::size_t>(first + kLanes, leafCount_); ++leaf)
      all.add(aabbOf(boxOf(oh, static_cast<std::uint32_t>(leaf))));
  } else {
    const std::vector<Aabb>& below = boxes_[level - 1];
    for (std::size_t child = first; child < std::min(first + kLanes, below.size()); ++child)
      all.add(below[child]);
  }
  return all.box();
}

void BoxTree::build(const ObjectHierarchy& oh, BoundsKind bounds) {
  bounds_ = bounds;
  leafCount_ = oh.leafCount();
  leaves_.clear();
  singles_.clear();
  levels_.clear();
  boxes_.clear();
  if (leafCount_ == 0) return;
  const Aabb& all = oh.aabb(0);
  const double size = (all.max - all.min).maxCoeff();
  int exponent = 0;
  if (size > 0 && std::isfinite(size)) static_cast<void>(std::frexp(size, &exponent));
  scale_ = std::ldexp(1.0, -exponent);

  const auto blocksFor = [](std::size_t count) { return (count + kLanes - 1) / kLanes; };
  leaves_.resize(blocksFor(leafCount_));
  for (std::uint32_t leaf = 0; leaf < leafCount_; ++leaf)
    setLeaf(leaf, boxOf(oh, leaf));
  // The last block is filled up with copies, whose results are thrown away.
  const Obb last = boxOf(oh, leafCount_ - 1);
  for (std::size_t leaf = leafCount_; leaf < leaves_.size() * kLanes; ++leaf)
    setLeaf(static_cast<std::uint32_t>(leaf), last);

  for (std::size_t count = leaves_.size(); count > 1; count = blocksFor(count)) {
    const std::size_t level = levels_.size();
    levels_.push_back({std::vector<AlignedBlock>(blocksFor(count)), static_cast<std::uint32_t>(count)});
    boxes_.emplace_back(count);
    for (std::uint32_t node = 0; node < count; ++node)
      setNode(level, node, aabbOfNode(oh, level, node));
    AlignedBlock& end = levels_[level].blocks.back();
    for (std::size_t lane = (count - 1) % kLanes + 1; lane < kLanes; ++lane) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        end.center[axis][lane] = end.center[axis][lane - 1];
        end.half[axis][lane] = end.half[axis][lane - 1];
      }
    }
    if (count <= kLanes) break;
  }
}

void BoxTree::refit(const ObjectHierarchy& oh, std::span<const std::uint32_t> leaves) {
  touched_.assign(leaves.begin(), leaves.end());
  for (const std::uint32_t leaf : leaves) {
    setLeaf(leaf, boxOf(oh, leaf));
    if (!singles_.empty()) singles_[leaf] = single(leaf);
  }
  const std::uint32_t last = leafCount_ - 1;
  if (std::find(leaves.begin(), leaves.end(), last) != leaves.end()) {
    for (std::size_t leaf = leafCount_; leaf < leaves_.size() * kLanes; ++leaf)
      setLeaf(static_cast<std::uint32_t>(leaf), boxOf(oh, last));
  }
  std::sort(touched_.begin(), touched_.end());
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    for (std::uint32_t& node : touched_)
      node /= static_cast<std::uint32_t>(kLanes);
    touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
    for (const std::uint32_t node : touched_)
      setNode(level, node, aabbOfNode(oh, level, node));
  }
}

}  // namespace tessera::cull
