#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/geometry/vec.h"
#include "common/wall/wall.h"

namespace tessera {

/// Limits of a camera path; configs/camera.schema.json states the same.
inline constexpr std::uintmax_t kMaxCameraFileBytes = std::uintmax_t{64} << 20;
inline constexpr double kMaxCameraCoordinate = 1e15;
inline constexpr double kMaxCameraTimeS = 1e9;
inline constexpr double kMinKeyframeStepS = 1e-6;

/// What the lengths of a camera path are measured in.
enum class CameraSpace {
  World,  ///< the scene's own coordinates
  Scene,  ///< bounding radii from the scene's centre, so that one path suits any scene
};

/// One point that the path passes through, in the path's space.
struct CameraKeyframe {
  double timeS = 0;
  Vec3 eye = Vec3::Zero();
  Vec3 target = Vec3(0, 0, -1);
  Vec3 up = Vec3(0, 1, 0);
  std::optional<double> fovYRad = {};  ///< on all keyframes of a path or on none
  std::optional<Vec3> headM = {};      ///< an observer's place in the room; likewise
};

/// A camera's flight through keyframes. Eye, target, up, field of view and head each follow a C1 cubic
/// Hermite curve whose slope at a keyframe is that of the chord between its two neighbours (Catmull-Rom with
/// uneven times), at the ends of the path that of the outermost chord. A curve may swing out a little beyond
/// its keyframes, but not by more than the chords are long, however uneven the times. Immutable, hence safe
/// to share between threads.
class CameraPath {
 public:
  [[nodiscard]] CameraSpace space() const { return space_; }
  /// At least one, `timeS` strictly increasing, every one a valid pose with `up` made unit and across the
  /// view.
  [[nodiscard]] const std::vector<CameraKeyframe>& keyframes() const { return keyframes_; }

  /// The pose at `timeS` (clamped to the path) in world space, always fit for viewOf: finite, eye and target
  /// apart, `up` of length 1 and across the view. Eye, target and field of view at a keyframe's time are
  /// exactly the keyframe's. `sceneCenter`, `sceneRadius` (> 0) matter to paths in scene space only.
  [[nodiscard]] CameraPose poseAt(double timeS, const Vec3& sceneCenter, double sceneRadius) const;

  /// `frames` times, evenly from the first keyframe to the last, both included; one frame is the first.
  [[nodiscard]] std::vector<double> sampleTimes(std::size_t frames) const;

 private:
  friend Result<CameraPath> parseCameraPath(std::string_view text, const std::string& sourceName);
  CameraPath(CameraSpace space, std::vector<CameraKeyframe> keyframes);

  [[nodiscard]] CameraPose interpolated(std::size_t segment, double timeS) const;

  CameraSpace space_;
  std::vector<CameraKeyframe> keyframes_;
};

/// Reads and validates a camera path: JSON with comments, described by configs/camera.schema.json. The error
/// names the file and the line. Safe on hostile files.
[[nodiscard]] Result<CameraPath> readCameraPath(const std::filesystem::path& path);

/// The same for text already in memory; `sourceName` stands for the file in messages.
[[nodiscard]] Result<CameraPath> parseCameraPath(std::string_view text, const std::string& sourceName);

}  // namespace tessera
