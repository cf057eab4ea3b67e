#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/hierarchy/visible_list.h"
#include "common/scene/motion/motion.h"
#include "common/scene/motion/node_player.h"
#include "common/scene/motion/skeleton_player.h"

namespace tessera::motion {

/// Which part of which drawable of the graph a leaf is.
struct LeafPart {
  std::uint32_t graphLeaf = 0, part = 0;
};

/// Where a leaf is, and in which shape. The bounds hold it, in world coordinates, as tiles draw it from just
/// these numbers.
struct LeafPose {
  std::uint32_t leaf = 0;
  Mat4 localToWorld = Mat4::Identity();
  Bounds bounds = {};
  std::vector<float> joints = {};   ///< of a skinned leaf: 12 for each joint, by column
  std::vector<float> weights = {};  ///< of a leaf with morph targets
};

/// Plays what moves in a scene, for one eye. Deterministic: the same calls give the same numbers. Not
/// thread-safe.
class MotionPlayer {
 public:
  /// `leaves`: of the scene, by leaf id. Without `animates` nothing moves; leaves still come and go with
  /// levels of detail and switches.
  [[nodiscard]] static Result<std::unique_ptr<MotionPlayer>> make(Motion motion,
                                                                  std::span<const LeafPart> leaves,
                                                                  bool animates);

  /// Moves on to a time, in seconds from the start and not before the last one; `eye` in world coordinates.
  void advance(double timeS, const Vec3& eye);

  /// What the last advance() changed against the one before, by leaf id; of the first one all that may move.
  [[nodiscard]] std::span<const std::uint32_t> moved() const { return moved_; }
  /// Of a leaf that has been in moved() at least once; else null.
  [[nodiscard]] const LeafPose* poseOf(std::uint32_t leaf) const;
  /// In the leaf's own coordinates, undeformed; of a leaf with a pose.
  [[nodiscard]] const Bounds& restBoundsOf(std::uint32_t leaf) const;
  /// All leaves that have one, ascending.
  [[nodiscard]] std::vector<std::uint32_t> posed() const;

  /// The leaves that are not shown now, and whether the last advance() changed them.
  [[nodiscard]] const VisibleList& absent() const { return absent_; }
  [[nodiscard]] bool absentChanged() const { return absentChanged_; }

 private:
  struct State {
    std::uint32_t source = 0;  ///< of motion_.leaves
    bool isKnown = false;
    LeafPose pose = {};
  };

  MotionPlayer(Motion motion, std::span<const LeafPart> leaves, bool animates);
  [[nodiscard]] bool update(State& state);
  [[nodiscard]] std::optional<LeafPose> poseNow(const Leaf& leaf) const;
  [[nodiscard]] std::optional<LeafPose> skinnedPose(const Leaf& leaf, const Deformation& deformation) const;
  void updateAbsent();

  Motion motion_;
  bool animates_;
  std::optional<NodePlayer> nodes_;
  std::unique_ptr<SkeletonPlayer> skeleton_;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order_;  ///< graph leaf and part, leaf; sorted
  std::vector<State> states_;                                   ///< sorted by leaf
  std::vector<std::uint32_t> moved_;
  VisibleList hidden_, absent_;  ///< of the graph's leaves; of the scene's
  bool absentChanged_ = false;
};

/// The leaves of a scene, by leaf id, that `graphLeaves` of its graph are.
[[nodiscard]] VisibleList leavesOf(const VisibleList& graphLeaves, std::span<const LeafPart> leaves);

}  // namespace tessera::motion
