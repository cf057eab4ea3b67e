#include "common/hierarchy/object_hierarchy.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace tessera {

namespace {

/// Sphere about the box's centre that holds the children's spheres, or the box where that is smaller.
Sphere enclosingSphere(const Aabb& box, std::span<const Sphere> children) {
  const Vec3 center = box.center();
  double reach = 0;
  for (const Sphere& s : children)
    reach = std::max(reach, (s.center - center).norm() + s.radius);
  const double diagonal = (box.max - center).cwiseMax(center - box.min).norm();
  return {center, std::min(reach, diagonal) * (1 + 16 * kUnitRoundoff)};
}

}  // namespace

Bounds boundsOf(std::span<const Vec3> points, const Vec3& margin) {
  Bounds bounds;
  bounds.aabb = aabbOf(points, margin);
  bounds.obb = pcaObbOf(points, margin);
  bounds.sphere = sphereOf(points, bounds.aabb.center(), margin);
  return bounds;
}

std::uint32_t ObjectHierarchy::depth() const {
  std::vector<std::uint32_t> depths(nodeCount(), 0);
  std::uint32_t deepest = 0;
  for (std::uint32_t node = 1; node < nodeCount(); ++node) {
    depths[node] = depths[parent_[node]] + 1;
    deepest = std::max(deepest, depths[node]);
  }
  return deepest;
}

double ObjectHierarchy::meanBranching() const {
  const std::uint32_t inner = nodeCount() - leafCount();
  return inner == 0 ? 0.0 : static_cast<double>(nodeCount() - 1) / inner;
}

ObjectHierarchyBuilder::ObjectHierarchyBuilder() {
  openNode();
}

void ObjectHierarchyBuilder::openNode() {
  const std::uint32_t node = oh_.nodeCount();
  append({kOpen, oh_.leafCount(), open_.empty() ? ObjectHierarchy::kNoParent : open_.back()}, {});
  open_.push_back(node);
}

std::uint32_t ObjectHierarchyBuilder::addLeaf(const Bounds& bounds) {
  const std::uint32_t node = oh_.nodeCount();
  const std::uint32_t leaf = oh_.leafCount();
  append({node + 1, leaf, open_.back()}, bounds);
  oh_.leafNode_.push_back(node);
  return leaf;
}

void ObjectHierarchyBuilder::closeNode() {
  if (open_.size() < 2) std::abort();  // the root is closed by finish
  close();
}

void ObjectHierarchyBuilder::close() {
  const std::uint32_t node = open_.back();
  open_.pop_back();
  const std::uint32_t end = oh_.nodeCount();
  if (end == node + 1) {
    removeLast();
    return;
  }
  oh_.subtreeEnd_[node] = end;
  // Only marked: moving the arrays here would cost the square of a long chain.
  if (oh_.subtreeEnd_[node + 1] == end) dropped_[node] = true;
}

void ObjectHierarchyBuilder::append(const Links& links, const Bounds& bounds) {
  oh_.subtreeEnd_.push_back(links.subtreeEnd);
  oh_.leafBegin_.push_back(links.leafBegin);
  oh_.parent_.push_back(links.parent);
  oh_.aabbs_.push_back(bounds.aabb);
  oh_.obbs_.push_back(bounds.obb);
  oh_.spheres_.push_back(bounds.sphere);
  dropped_.push_back(false);
}

void ObjectHierarchyBuilder::removeLast() {
  oh_.subtreeEnd_.pop_back();
  oh_.leafBegin_.pop_back();
  oh_.parent_.pop_back();
  oh_.aabbs_.pop_back();
  oh_.obbs_.pop_back();
  oh_.spheres_.pop_back();
  dropped_.pop_back();
}

ObjectHierarchy ObjectHierarchyBuilder::finish() {
  if (open_.size() != 1) std::abort();
  close();
  ObjectHierarchy walked = std::exchange(oh_, {});
  const std::vector<bool> dropped = std::exchange(dropped_, {});
  const std::uint32_t count = walked.nodeCount();
  std::vector<std::uint32_t> keptBefore(count + 1, 0);
  for (std::uint32_t n = 0; n < count; ++n) {
    keptBefore[n + 1] = keptBefore[n] + (dropped[n] ? 0 : 1);
  }
  std::vector<std::uint32_t> keptParent(count, ObjectHierarchy::kNoParent);
  for (std::uint32_t n = 0; n < count; ++n) {
    if (const std::uint32_t p = walked.parent_[n]; p != ObjectHierarchy::kNoParent) {
      keptParent[n] = dropped[p] ? keptParent[p] : keptBefore[p];
    }
    if (dropped[n]) continue;
    append({keptBefore[walked.subtreeEnd_[n]], walked.leafBegin_[n], keptParent[n]},
           {walked.aabbs_[n], walked.obbs_[n], walked.spheres_[n]});
  }
  oh_.leafNode_ = std::move(walked.leafNode_);
  for (std::uint32_t& node : oh_.leafNode_)
    node = keptBefore[node];
  oh_.leafBegin_.push_back(oh_.leafCount());
  computeInnerBounds();
  ObjectHierarchy built = std::exchange(oh_, {});
  dropped_.clear();
  openNode();  // ready for another scene
  return built;
}

void ObjectHierarchyBuilder::computeInnerBounds() {
  std::vector<Vec3> corners;
  std::vector<Sphere> spheres;
  for (std::uint32_t node = oh_.nodeCount(); node-- > 0;) {
    if (oh_.isLeaf(node)) continue;
    corners.clear();
    spheres.clear();
    Aabb box;
    double reach = 0;
    for (std::uint32_t child = node + 1; child != oh_.subtreeEnd_[node]; child = oh_.subtreeEnd_[child]) {
      box.extend(oh_.aabbs_[child]);
      spheres.push_back(oh_.spheres_[child]);
      for (const Vec3& corner : oh_.obbs_[child].corners()) {
        corners.push_back(corner);
        reach = std::max(reach, corner.cwiseAbs().maxCoeff());
      }
    }
    // A corner is three rounded sums of numbers no larger than the corner and the box together.
    const Vec3 margin = Vec3::Constant(16 * kUnitRoundoff * reach);
    oh_.aabbs_[node] = box;
    oh_.obbs_[node] = pcaObbOf(corners, margin);
    oh_.spheres_[node] = enclosingSphere(box, spheres);
  }
}

}  // namespace tessera
