#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/base/result.h"
#include "common/hierarchy/bounds_refit.h"
#include "common/hierarchy/object_hierarchy.h"
#include "common/scene/motion/motion_player.h"
#include "common/scene/scene.h"
#include "common/wall/wall.h"
#include "proto/messages.h"
#include "server/master/motion_options.h"

namespace tessera {

/// The scene as it is in a frame: plays its motion and keeps a hierarchy with the bounds and the absent
/// leaves of now. Used by the frame loop alone.
class SceneMotion {
 public:
  /// Null where nothing can change. `scene` must outlive it.
  [[nodiscard]] static Result<std::unique_ptr<SceneMotion>> make(const Scene& scene,
                                                                 const MotionOptions& options);

  /// Moves on to a frame, to be called for ascending ones from 1, and makes the view of it: depths that the
  /// wall leaves open are fitted to what the scene is then. Levels of detail choose by the eye of the first
  /// screen, for the whole wall.
  void advance(std::uint64_t frame, const Wall& wall, const CameraPose& pose, WallView& view);

  [[nodiscard]] const ObjectHierarchy& hierarchy() const { return hierarchy_; }
  /// Leaves that the last advance() moved, ascending; all that ever were moved.
  [[nodiscard]] std::span<const std::uint32_t> moved() const { return player_->moved(); }
  [[nodiscard]] std::span<const std::uint32_t> posed() const { return posed_; }
  /// Whether the leaf is elsewhere, or in another shape, than its record tells.
  [[nodiscard]] bool hasPose(std::uint32_t leaf) const { return player_->poseOf(leaf) != nullptr; }
  /// What tells a tile that has the leaf's record where it is. Precondition: hasPose.
  [[nodiscard]] proto::Pose poseOf(std::uint32_t leaf) const;

 private:
  SceneMotion(const Scene& scene, const MotionOptions& options, std::unique_ptr<motion::MotionPlayer> player);
  void advance(std::uint64_t frame, const Vec3& eye);
  void place(std::uint32_t leaf);

  const Scene* scene_;
  MotionOptions options_;
  std::unique_ptr<motion::MotionPlayer> player_;
  ObjectHierarchy hierarchy_;
  BoundsRefit refit_;
  std::unordered_map<std::uint32_t, proto::PoseSteps> steps_;  ///< of leaves that are sent in steps
  std::vector<std::uint32_t> posed_;
};

}  // namespace tessera
