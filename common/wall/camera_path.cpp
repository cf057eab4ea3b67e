#include "common/wall/camera_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/wall/view_axes.h"

namespace tessera {

namespace {

constexpr double kRadiansPerDeg = std::numbers::pi / 180;

/// The curve that a keyframe's quantity (`get`) follows from keyframe `segment` to the next.
template <class Get>
auto curveAt(const std::vector<CameraKeyframe>& keyframes, std::size_t segment, double timeS, Get get) {
  using T = decltype(get(keyframes[0]));
  const CameraKeyframe& start = keyframes[segment];
  const CameraKeyframe& end = keyframes[segment + 1];
  // At an end of the path the slope is that of the chord: the neighbour beyond is the keyframe itself.
  const CameraKeyframe& before = segment > 0 ? keyframes[segment - 1] : start;
  const CameraKeyframe& after = segment + 2 < keyframes.size() ? keyframes[segment + 2] : end;

  const double durationS = end.timeS - start.timeS;
  const double t = (timeS - start.timeS) / durationS;
  const double rest = 1 - t;
  const T startSlope = (get(end) - get(before)) * (durationS / (end.timeS - before.timeS));
  const T endSlope = (get(after) - get(start)) * (durationS / (after.timeS - start.timeS));
  return T(get(start) * (rest * rest * (1 + 2 * t)) + startSlope * (t * rest * rest) +
           get(end) * (t * t * (3 - 2 * t)) - endSlope * (t * t * rest));
}

Vec3 forwardOf(const Vec3& eye, const Vec3& target) {
  return direction(target - eye).value_or(-Vec3::UnitZ());
}

double viewLength(const CameraKeyframe& keyframe) {
  return (keyframe.target - keyframe.eye).stableNorm();
}

/// A target `length` before the eye, or as much farther as rounding at the eye demands.
Vec3 targetAlong(const Vec3& eye, const Vec3& forward, double length) {
  return eye + forward * std::max(length, 0x1p-36 * eye.cwiseAbs().maxCoeff());
}

/// A pose in bounding radii from the centre, in the world.
CameraPose placedInScene(const CameraPose& pose, const Vec3& center, double radius) {
  CameraPose placed = pose;
  placed.eye = center + radius * pose.eye;
  placed.target = center + radius * pose.target;
  // A small scene far out may leave too few digits between the two for a direction.
  const double shortest = 0x1p-40 * placed.eye.cwiseAbs().maxCoeff();
  if (!((placed.target - placed.eye).stableNorm() > shortest)) {
    placed.target = targetAlong(placed.eye, forwardOf(pose.eye, pose.target), radius);
  }
  return placed;
}

}  // namespace

CameraPath::CameraPath(CameraSpace space, std::vector<CameraKeyframe> keyframes)
    : space_(space), keyframes_(std::move(keyframes)) {
  for (CameraKeyframe& keyframe : keyframes_) {
    const Vec3 forward = forwardOf(keyframe.eye, keyframe.target);
    keyframe.up = upAcross(forward, keyframe.up).value_or(anyUpAcross(forward));
  }
}

CameraPose CameraPath::poseAt(double timeS, const Vec3& sceneCenter, double sceneRadius) const {
  const auto next =
      std::upper_bound(keyframes_.begin(), keyframes_.end(), timeS,
                       [](double time, const CameraKeyframe& keyframe) { return time < keyframe.timeS; });
  const bool isBefore = next == keyframes_.begin() || std::isnan(timeS);
  const std::size_t segment = isBefore ? 0 : static_cast<std::size_t>(next - keyframes_.begin()) - 1;
  const CameraKeyframe& start = keyframes_[segment];
  const bool isHeld = isBefore || next == keyframes_.end() || start.timeS == timeS;
  const CameraPose pose = isHeld ? CameraPose{start.eye,
                                              start.target,
                                              start.up,
                                              start.fovYRad,
                                              start.headM.has_value(),
                                              start.headM.value_or(Vec3::Zero())}
                                 : interpolated(segment, timeS);
  return space_ == CameraSpace::Scene ? placedInScene(pose, sceneCenter, sceneRadius) : pose;
}

CameraPose CameraPath::interpolated(std::size_t segment, double timeS) const {
  const auto curve = [&](auto get) { return curveAt(keyframes_, segment, timeS, get); };
  CameraPose pose;
  pose.eye = curve([](const CameraKeyframe& keyframe) { return keyframe.eye; });
  pose.target = curve([](const CameraKeyframe& keyframe) { return keyframe.target; });
  if (keyframes_[segment].fovYRad) {
    const double fovYRad = curve([](const CameraKeyframe& keyframe) { return *keyframe.fovYRad; });
    pose.fovYRad = std::clamp(fovYRad, kMinFovYDeg * kRadiansPerDeg, kMaxFovYDeg * kRadiansPerDeg);
  }
  if (keyframes_[segment].headM) {
    pose.hasHead = true;
    pose.headM = curve([](const CameraKeyframe& keyframe) { return *keyframe.headM; });
  }

  // The curves of eye and target may meet, and the view may come to lie along up: there the nearer keyframe
  // says how to look on.
  const CameraKeyframe& before = keyframes_[segment];
  const CameraKeyframe& after = keyframes_[segment + 1];
  const CameraKeyframe& nearer = timeS - before.timeS <= after.timeS - timeS ? before : after;
  constexpr double kMinViewLengthRatio = 1e-6;
  const double shortest = kMinViewLengthRatio * std::min(viewLength(before), viewLength(after));
  if (!((pose.target - pose.eye).stableNorm() > shortest)) {
    pose.target = targetAlong(pose.eye, forwardOf(nearer.eye, nearer.target), viewLength(nearer));
  }
  const Vec3 forward = forwardOf(pose.eye, pose.target);
  std::optional<Vec3> maybeUp =
      upAcross(forward, curve([](const CameraKeyframe& keyframe) { return keyframe.up; }));
  if (!maybeUp) maybeUp = upAcross(forward, nearer.up);
  pose.up = maybeUp ? *maybeUp : anyUpAcross(forward);
  return pose;
}

std::vector<double> CameraPath::sampleTimes(std::size_t frames) const {
  const double firstS = keyframes_.front().timeS;
  const double lastS = keyframes_.back().timeS;
  std::vector<double> timesS(frames, firstS);
  for (std::size_t i = 1; i < frames; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(frames - 1);
    timesS[i] = i + 1 == frames ? lastS : std::min(firstS + (lastS - firstS) * share, lastS);
  }
  return timesS;
}

}  // namespace tessera
