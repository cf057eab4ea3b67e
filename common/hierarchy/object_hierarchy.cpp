#include "common/hierarchy/object_hierarchy.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace tessera {

Bounds boundsOf(std::span<const Vec3> points, const Vec3& margin) {
  Bounds bounds;
  bounds.aabb = aabbOf(points, margin);
  bounds.obb = pcaObbOf(points, margin);
  bounds.sphere = sphereOf(points, bounds.aabb.center(), margin);
  return bounds;
}

ObjectHierarchy::ObjectHierarchy(Arrays arrays)
    : subtreeEnd_(std::move(arrays.subtreeEnd)),
      leafBegin_(std::move(arrays.leafBegin)),
      parent_(std::move(arrays.parent)),
      leafNode_(std::move(arrays.leafNode)),
      aabbs_(std::move(arrays.aabbs)),
      obbs_(std::move(arrays.obbs)),
      spheres_(std::move(arrays.spheres)) {
  moving_.assign(nodeCount(), 0);
}

void ObjectHierarchy::setAbsentLeaves(const VisibleList& leaves) {
  if (!isCanonical(leaves, leafCount())) std::abort();
  absent_ = leaves;
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
  std::uint32_t inner = 0;
  for (std::uint32_t node = 0; node < nodeCount(); ++node)
    inner += isTerminal(node) ? 0 : 1;
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

std::uint32_t ObjectHierarchyBuilder::addGroup(std::span<const Bounds> leaves) {
  const std::uint32_t node = oh_.nodeCount();
  const std::uint32_t first = oh_.leafCount();
  if (leaves.empty()) return first;
  if (leaves.size() == 1) {
    append({node + 1, first, open_.back()}, leaves[0]);
  } else {
    enclosing_.clear();
    for (const Bounds& leaf : leaves)
      enclosing_.add(leaf);
    append({node + 1, first, open_.back()}, enclosing_.result(BoxFit::Pca));
  }
  for (std::size_t i = 0; i < leaves.size(); ++i)
    oh_.leafNode_.push_back(node);
  return first;
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
  oh_.moving_.assign(oh_.nodeCount(), 0);
  for (std::uint32_t node = oh_.nodeCount(); node-- > 0;) {
    if (oh_.isTerminal(node)) continue;
    enclosing_.clear();
    for (std::uint32_t child = node + 1; child != oh_.subtreeEnd_[node]; child = oh_.subtreeEnd_[child]) {
      enclosing_.add(oh_.aabbs_[child], oh_.obbs_[child], oh_.spheres_[child]);
    }
    const Bounds bounds = enclosing_.result(BoxFit::Pca);
    oh_.aabbs_[node] = bounds.aabb;
    oh_.obbs_[node] = bounds.obb;
    oh_.spheres_[node] = bounds.sphere;
  }
}

}  // namespace tessera
