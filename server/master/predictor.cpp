#include "server/master/predictor.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace tessera {

namespace {

constexpr double kNewest = 0.5;      // share of the last step in the smoothed one
constexpr double kMostChange = 0.5;  // from step to step, of the longer one

Mat3 axesOf(const CameraPose& pose) {
  const Vec3 back = (pose.eye - pose.target).normalized();
  const Vec3 right = pose.up.cross(back).normalized();
  Mat3 axes;
  axes << right, back.cross(right), back;
  return axes;
}

/// The turn from one pose's axes to another's.
Vec3 turnBetween(const CameraPose& from, const CameraPose& to) {
  const Mat3 rotation = axesOf(to) * axesOf(from).transpose();
  const Eigen::AngleAxisd turn(rotation);
  const Vec3 vector = turn.axis() * turn.angle();
  return vector.allFinite() ? vector : Vec3::Zero();
}

/// What to go on with after a step: nothing where it has little in common with the one before.
Vec3 smoothed(const Vec3& before, const Vec3& lastStep, const Vec3& step) {
  const double longer = std::max(lastStep.norm(), step.norm());
  if (longer == 0 || (step - lastStep).norm() > kMostChange * longer) return Vec3::Zero();
  return before.isZero() ? step : Vec3((1 - kNewest) * before + kNewest * step);
}

}  // namespace

void CameraMotion::add(const CameraPose& pose) {
  if (hasLast_) {
    const Vec3 step = pose.eye - last_.eye, turn = turnBetween(last_, pose);
    step_ = smoothed(step_, lastStep_, step);
    turn_ = smoothed(turn_, lastTurn_, turn);
    lastStep_ = step;
    lastTurn_ = turn;
  }
  last_ = pose;
  hasLast_ = true;
}

CameraPose CameraMotion::ahead(double frames, double mostPath) const {
  CameraPose pose = last_;
  const double angle = std::min(turn_.norm() * frames, kMostTurnRad);
  const double path = std::min(step_.norm() * frames, mostPath);
  if (path > 0) pose.eye += path * step_.normalized();
  Vec3 toTarget = last_.target - last_.eye;
  if (angle > 0) {
    const Eigen::AngleAxisd turn(angle, turn_.normalized());
    toTarget = turn * toTarget;
    pose.up = turn * last_.up;
  }
  pose.target = pose.eye + toTarget;
  return pose;
}

Predictor::Predictor(const ObjectHierarchy& scene, const Wall& wall, const PredictorOptions& options)
    : options_(options),
      grown_(grownWall(wall, options.grownShare)),
      culler_(scene, grown_.wall, options.cull) {}

const std::vector<VisibleList>& Predictor::predict(const CameraPose& pose, const Sphere& scene) {
  motion_.add(pose);
  constexpr std::array kShares = {0.25, 0.5, 1.0};
  const double frames = kShares[turn_] * options_.horizonFrames;
  turn_ = (turn_ + 1) % kShares.size();
  const CameraPose ahead = motion_.ahead(frames, scene.radius);
  viewInto(grown_.wall, grown_.poseFor(ahead), scene.center, scene.radius, view_);
  culler_.update(view_);
  return culler_.cull().lists;
}

}  // namespace tessera
