#include "server/master/scene_motion.h"

#include <utility>

#include "common/hierarchy/transformed_bounds.h"
#include "common/scene/scene_motion.h"
#include "proto/pose_codec.h"

namespace tessera {

Result<std::unique_ptr<SceneMotion>> SceneMotion::make(const Scene& scene, const MotionOptions& options) {
  auto player = motionPlayerOf(scene, options.animate);
  if (!player) return player.error();
  if (!*player) return std::unique_ptr<SceneMotion>();
  return std::unique_ptr<SceneMotion>(new SceneMotion(scene, options, std::move(*player)));
}

SceneMotion::SceneMotion(const Scene& scene, const MotionOptions& options,
                         std::unique_ptr<motion::MotionPlayer> player)
    : scene_(&scene),
      options_(options),
      player_(std::move(player)),
      hierarchy_(scene.hierarchy),
      refit_(hierarchy_, BoxFit::AxisAligned) {
  hierarchy_.setAbsentLeaves(player_->absent());
}

void SceneMotion::advance(std::uint64_t frame, const Wall& wall, const CameraPose& pose, WallView& view) {
  const Sphere& sphere = scene_->sphere();
  viewInto(wall, pose, sphere.center, sphere.radius, view);
  advance(frame, view.screens[0].eye);
  const Sphere& now = hierarchy_.sphere(0);
  if (options_.animate && now.radius > 0) viewInto(wall, pose, now.center, now.radius, view);
}

void SceneMotion::advance(std::uint64_t frame, const Vec3& eye) {
  const std::size_t known = posed_.size();
  player_->advance(static_cast<double>(frame - 1) / options_.framesPerSecond, eye);
  for (const std::uint32_t leaf : player_->moved())
    place(leaf);
  if (player_->absentChanged()) hierarchy_.setAbsentLeaves(player_->absent());
  refit_.refit();
  if (known == 0 || !player_->moved().empty()) posed_ = player_->posed();
}

/// The bounds hold the leaf where tiles will draw it, by the very numbers that they are sent.
void SceneMotion::place(std::uint32_t leaf) {
  const motion::LeafPose& pose = *player_->poseOf(leaf);
  Bounds bounds = pose.bounds;
  if (options_.quantizeBoundM > 0 && pose.joints.empty() && pose.weights.empty()) {
    const Mat4& base = scene_->leaves[leaf].localToWorld;
    const Bounds& rest = player_->restBoundsOf(leaf);
    const auto steps = proto::toSteps(base, pose.localToWorld, rest.aabb, options_.quantizeBoundM);
    const auto reached =
        steps ? transformed(rest, proto::fromSteps(base, *steps), BoxFit::Pca) : std::nullopt;
    if (reached) {
      bounds = *reached;
      steps_.insert_or_assign(leaf, *steps);
    } else {
      steps_.erase(leaf);
    }
  }
  static_cast<void>(refit_.setBounds(leaf, bounds));
}

proto::Pose SceneMotion::poseOf(std::uint32_t leaf) const {
  const motion::LeafPose& from = *player_->poseOf(leaf);
  proto::Pose pose{.id = leaf, .form = proto::PoseForm::Matrix};
  if (const auto steps = steps_.find(leaf); steps != steps_.end()) {
    pose.form = proto::PoseForm::Steps;
    pose.steps = steps->second;
  } else {
    pose.localToWorld = from.localToWorld;
  }
  pose.joints = from.joints;
  pose.weights = from.weights;
  return pose;
}

}  // namespace tessera
