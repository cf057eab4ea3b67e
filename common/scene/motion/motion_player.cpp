#include "common/scene/motion/motion_player.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/hierarchy/transformed_bounds.h"
#include "common/scene/motion/deform_bounds.h"

namespace tessera::motion {

namespace {

using Order = std::vector<std::pair<std::uint64_t, std::uint32_t>>;

std::uint64_t keyOf(std::uint32_t graphLeaf, std::uint32_t part) {
  return std::uint64_t{graphLeaf} << 32U | part;
}

Order orderOf(std::span<const LeafPart> leaves) {
  Order order;
  order.reserve(leaves.size());
  for (std::uint32_t leaf = 0; leaf < leaves.size(); ++leaf)
    order.emplace_back(keyOf(leaves[leaf].graphLeaf, leaves[leaf].part), leaf);
  std::sort(order.begin(), order.end());
  return order;
}

VisibleList leavesIn(const VisibleList& graphLeaves, const Order& order) {
  std::vector<std::uint32_t> ids;
  const auto at = [&](std::uint32_t graphLeaf) {
    return std::lower_bound(order.begin(), order.end(), std::pair{keyOf(graphLeaf, 0), std::uint32_t{0}});
  };
  for (const LeafRange range : graphLeaves) {
    for (auto entry = at(range.first); entry != order.end() && entry->first < keyOf(range.last, 0); ++entry)
      ids.push_back(entry->second);
  }
  std::sort(ids.begin(), ids.end());
  VisibleList list;
  for (const std::uint32_t id : ids)
    appendRange(list, {id, id + 1});
  return list;
}

bool isSame(const LeafPose& a, const LeafPose& b) {
  return a.localToWorld == b.localToWorld && a.joints == b.joints && a.weights == b.weights;
}

}  // namespace

VisibleList leavesOf(const VisibleList& graphLeaves, std::span<const LeafPart> leaves) {
  return leavesIn(graphLeaves, orderOf(leaves));
}

Result<std::unique_ptr<MotionPlayer>> MotionPlayer::make(Motion motion, std::span<const LeafPart> leaves,
                                                         bool animates) {
  std::unique_ptr<SkeletonPlayer> skeleton;
  if (!motion.skeleton.empty()) {
    auto read = SkeletonPlayer::read(motion.skeleton);
    if (!read) return read.error();
    skeleton = std::move(*read);
    const auto isThere = [&](const auto& item) { return item.node < skeleton->nodeCount(); };
    if (!std::all_of(motion.units.begin(), motion.units.end(), isThere) ||
        !std::all_of(motion.leaves.begin(), motion.leaves.end(), isThere)) {
      return runtimeError("scene motion", "refers to nodes that its graph does not have",
                          "build the scene's index again");
    }
  }
  std::unique_ptr<MotionPlayer> player(new MotionPlayer(std::move(motion), leaves, animates));
  player->skeleton_ = std::move(skeleton);
  if (!player->skeleton_ && animates) player->nodes_.emplace(player->motion_);
  return player;
}

MotionPlayer::MotionPlayer(Motion motion, std::span<const LeafPart> leaves, bool animates)
    : motion_(std::move(motion)), animates_(animates), order_(orderOf(leaves)) {
  hidden_ = motion_.hiddenAsLoaded;
  absent_ = leavesIn(hidden_, order_);
  if (!animates) return;
  for (std::uint32_t i = 0; i < motion_.leaves.size(); ++i) {
    const std::uint64_t key = keyOf(motion_.leaves[i].graphLeaf, motion_.leaves[i].part);
    const auto found = std::lower_bound(order_.begin(), order_.end(), std::pair{key, std::uint32_t{0}});
    if (found == order_.end() || found->first != key) continue;
    states_.push_back({.source = i});
    states_.back().pose.leaf = found->second;
  }
  std::sort(states_.begin(), states_.end(),
            [](const State& a, const State& b) { return a.pose.leaf < b.pose.leaf; });
}

void MotionPlayer::advance(double timeS, const Vec3& eye) {
  moved_.clear();
  absentChanged_ = false;
  if (skeleton_) {
    skeleton_->advance(timeS, eye, animates_);
    updateAbsent();
  }
  if (nodes_) nodes_->advance(timeS);
  for (State& state : states_) {
    if (update(state)) moved_.push_back(state.pose.leaf);
  }
}

bool MotionPlayer::update(State& state) {
  std::optional<LeafPose> now = poseNow(motion_.leaves[state.source]);
  // Numbers beyond all bounds: it stays where it was.
  if (!now || (state.isKnown && isSame(*now, state.pose))) return false;
  now->leaf = state.pose.leaf;
  state.pose = std::move(*now);
  state.isKnown = true;
  return true;
}

std::optional<LeafPose> MotionPlayer::poseNow(const Leaf& leaf) const {
  const Deformation* deformation =
      leaf.deformation == kNone ? nullptr : &motion_.deformations[leaf.deformation];
  if (deformation && deformation->skin != kNone) return skinnedPose(leaf, *deformation);
  LeafPose pose;
  pose.localToWorld = (skeleton_ ? skeleton_->world(leaf.node) : nodes_->world(leaf.node)) * leaf.nodeToLeaf;
  Bounds local = leaf.bounds;
  if (deformation) {
    const std::span<const float> weights = nodes_->weights(leaf.node).first(deformation->targetBoxes.size());
    pose.weights.assign(weights.begin(), weights.end());
    if (!std::all_of(weights.begin(), weights.end(), [](float w) { return std::isfinite(w); })) return {};
    local = morphedBounds(leaf.bounds.aabb, deformation->targetBoxes, weights);
  }
  const std::optional<Bounds> bounds = transformed(local, pose.localToWorld, BoxFit::Pca);
  if (!bounds) return {};
  pose.bounds = *bounds;
  return pose;
}

/// The node of a skinned mesh has no say in where it is. The leaf's own coordinates are those of the world
/// about its first joint, so that joints' maps are small enough for floats wherever it walks.
std::optional<LeafPose> MotionPlayer::skinnedPose(const Leaf& leaf, const Deformation& deformation) const {
  const Skin& skin = motion_.skins[deformation.skin];
  LeafPose pose;
  const Vec3 origin = nodes_->world(skin.joints[0]).topRightCorner<3, 1>();
  pose.localToWorld.topRightCorner<3, 1>() = origin;
  pose.joints.reserve(12 * skin.joints.size());
  for (std::size_t joint = 0; joint < skin.joints.size(); ++joint) {
    Mat4 world = nodes_->world(skin.joints[joint]);
    world.topRightCorner<3, 1>() -= origin;
    const Eigen::Matrix<float, 3, 4> map = (world * skin.inverseBind[joint]).topRows<3>().cast<float>();
    if (!map.allFinite()) return {};
    pose.joints.insert(pose.joints.end(), map.data(), map.data() + 12);
  }
  if (!deformation.targetBoxes.empty()) {
    const std::span<const float> weights = nodes_->weights(leaf.node).first(deformation.targetBoxes.size());
    if (!std::all_of(weights.begin(), weights.end(), [](float w) { return std::isfinite(w); })) return {};
    pose.weights.assign(weights.begin(), weights.end());
  }
  const std::optional<Bounds> bounds = skinnedBounds(deformation, pose.joints, pose.weights, origin);
  if (!bounds) return {};
  pose.bounds = *bounds;
  return pose;
}

void MotionPlayer::updateAbsent() {
  VisibleList hidden;
  for (const Unit& unit : motion_.units) {
    // Units come in the order of nodes, those inside another one after it.
    if (skeleton_->isShown(unit.node)) continue;
    const std::uint32_t first =
        hidden.empty() ? unit.firstGraphLeaf : std::max(unit.firstGraphLeaf, hidden.back().last);
    if (first < unit.lastGraphLeaf) appendRange(hidden, {first, unit.lastGraphLeaf});
  }
  if (hidden == hidden_) return;
  hidden_ = std::move(hidden);
  absent_ = leavesIn(hidden_, order_);
  absentChanged_ = true;
}

const LeafPose* MotionPlayer::poseOf(std::uint32_t leaf) const {
  const auto found =
      std::lower_bound(states_.begin(), states_.end(), leaf,
                       [](const State& state, std::uint32_t id) { return state.pose.leaf < id; });
  return found != states_.end() && found->pose.leaf == leaf && found->isKnown ? &found->pose : nullptr;
}

const Bounds& MotionPlayer::restBoundsOf(std::uint32_t leaf) const {
  const auto found =
      std::lower_bound(states_.begin(), states_.end(), leaf,
                       [](const State& state, std::uint32_t id) { return state.pose.leaf < id; });
  return motion_.leaves[found->source].bounds;
}

std::vector<std::uint32_t> MotionPlayer::posed() const {
  std::vector<std::uint32_t> leaves;
  for (const State& state : states_) {
    if (state.isKnown) leaves.push_back(state.pose.leaf);
  }
  return leaves;
}

}  // namespace tessera::motion
