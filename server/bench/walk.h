#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry/box.h"
#include "common/hierarchy/general_frusta.h"
#include "common/hierarchy/grid_frusta.h"
#include "common/wall/camera_path.h"
#include "common/wall/wall.h"

namespace tessera::bench {

/// A plain grid of 480x270 pixel tiles with a field of view of 50 degrees over the whole wall.
[[nodiscard]] Wall gridWall(int columns, int rows);

/// The views of one wall along a camera path through a scene.
class Walk {
 public:
  Walk(const Wall& wall, const CameraPath& path, const Sphere& scene, std::uint64_t frames)
      : wall_(&wall), path_(&path), scene_(scene), times_(path.sampleTimes(frames)) {}

  [[nodiscard]] std::uint64_t frames() const { return times_.size(); }
  [[nodiscard]] WallView view(std::uint64_t frame) const {
    return viewOf(*wall_, pose(frame), scene_.center, scene_.radius);
  }

  /// How fast the camera is: medians over the frames. Every figure about coherence depends on it.
  struct Step {
    double degrees = 0, sceneRadii = 0;
  };
  [[nodiscard]] Step step() const;

 private:
  [[nodiscard]] CameraPose pose(std::uint64_t frame) const {
    return path_->poseAt(times_[frame], scene_.center, scene_.radius);
  }
  const Wall* wall_;
  const CameraPath* path_;
  Sphere scene_;
  std::vector<double> times_;
};

/// One frustum hierarchy over a whole wall: that of a grid where it is one even grid, else a general one.
class WallFrusta {
 public:
  explicit WallFrusta(const Wall& wall);
  void update(const WallView& view);
  [[nodiscard]] const FrustumHierarchy& get() const {
    return grid_ ? static_cast<const FrustumHierarchy&>(*grid_) : general_;
  }

 private:
  std::optional<GridFrusta> grid_;
  GeneralFrusta general_;
};

}  // namespace tessera::bench
