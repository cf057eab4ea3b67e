#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "common/base/result.h"
#include "common/geometry/vec.h"

namespace tessera::motion {

/// Runs the skeleton of a scene of OpenSceneGraph's own formats: switches, sequences, levels of detail and
/// update callbacks. Not thread-safe.
class SkeletonPlayer {
 public:
  /// `osgb`: Motion::skeleton, which must be trusted.
  [[nodiscard]] static Result<std::unique_ptr<SkeletonPlayer>> read(std::string_view osgb);
  ~SkeletonPlayer();
  SkeletonPlayer(const SkeletonPlayer&) = delete;
  SkeletonPlayer& operator=(const SkeletonPlayer&) = delete;

  /// Levels of detail choose by the eye (world coordinates). Callbacks and sequences run where `animates`,
  /// and want times that ascend, in seconds.
  void advance(double timeS, const Vec3& eye, bool animates);

  [[nodiscard]] std::uint32_t nodeCount() const;
  [[nodiscard]] const Mat4& world(std::uint32_t node) const;
  /// Every node above chose the way to it.
  [[nodiscard]] bool isShown(std::uint32_t node) const;

 private:
  struct Graph;
  explicit SkeletonPlayer(std::unique_ptr<Graph> graph);
  std::unique_ptr<Graph> graph_;
};

}  // namespace tessera::motion
