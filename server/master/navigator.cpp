#include "server/master/navigator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace tessera {

namespace {

// Numbers of GLFW's keys and buttons, which windows send.
namespace key {
constexpr std::int32_t kA = 65, kD = 68, kE = 69, kF = 70, kG = 71, kO = 79, kP = 80, kQ = 81, kS = 83,
                       kW = 87;
constexpr std::int32_t kOne = 49, kNine = 57, kRight = 262, kLeft = 263, kDown = 264, kUp = 265, kHome = 268;
constexpr std::int32_t kLeftShift = 340, kRightShift = 344;
}  // namespace key
constexpr std::int32_t kLeftButton = 0;
constexpr double kSteepest = 89 * std::numbers::pi / 180;
constexpr double kTurnPerWindow = std::numbers::pi;  ///< a drag over a whole tile
constexpr double kStickDeadZone = 0.15, kStickTurnPerS = 1.5;
constexpr double kFaster = 4, kZoomPerStep = 0.9;

double stick(float value) {
  const double v = std::isfinite(value) ? std::clamp(static_cast<double>(value), -1.0, 1.0) : 0;
  return std::abs(v) < kStickDeadZone ? 0 : v;
}

}  // namespace

Navigator::Navigator(std::vector<CameraPose> views, const Vec3& sceneCenter, double sceneRadius,
                     double fovYRad)
    : views_(std::move(views)), center_(sceneCenter), radius_(sceneRadius), fovYRad_(fovYRad) {
  goTo(views_.front());
}

Vec3 Navigator::forward() const {
  const double level = std::cos(pitchRad_);
  return {level * std::sin(yawRad_), std::sin(pitchRad_), -level * std::cos(yawRad_)};
}

Vec3 Navigator::right() const {
  return {std::cos(yawRad_), 0, std::sin(yawRad_)};
}

void Navigator::goTo(const CameraPose& pose) {
  const Vec3 view = pose.target - pose.eye;
  const double length = view.stableNorm();
  if (!(length > 0) || !view.allFinite()) return;
  eye_ = pose.eye;
  distance_ = length;
  pitchRad_ = std::clamp(std::asin(std::clamp(view.y() / length, -1.0, 1.0)), -kSteepest, kSteepest);
  if (std::hypot(view.x(), view.z()) > 1e-9 * length) yawRad_ = std::atan2(view.x(), -view.z());
}

void Navigator::frameAll() {
  distance_ = radius_ / std::sin(std::min(fovYRad_, std::numbers::pi / 2) / 2);
  eye_ = center_ - distance_ * forward();
}

void Navigator::look(double turnRad, double pitchRad) {
  const Vec3 target = eye_ + distance_ * forward();
  yawRad_ = std::remainder(yawRad_ + turnRad, 2 * std::numbers::pi);
  pitchRad_ = std::clamp(pitchRad_ + pitchRad, -kSteepest, kSteepest);
  if (mode_ == Mode::Orbit) eye_ = target - distance_ * forward();
}

void Navigator::drag(double dx, double dy) {
  if (buttons_.empty()) return;
  if (buttons_.contains(kLeftButton)) {
    // In orbit the scene follows the hand, else the view does.
    const double sign = mode_ == Mode::Orbit ? 1 : -1;
    return look(sign * dx * kTurnPerWindow, sign * dy * kTurnPerWindow);
  }
  const double perWindow = 2 * distance_ * std::tan(std::min(fovYRad_, std::numbers::pi / 2) / 2);
  const Vec3 up = right().cross(forward());
  eye_ += perWindow * (dy * up - dx * right());
}

void Navigator::handle(const proto::Input& input) {
  switch (input.kind) {
    case proto::InputKind::Key:
      if (!input.pressed) {
        keys_.erase(input.code);
        return;
      }
      keys_.insert(input.code);
      if (input.code == key::kO) mode_ = Mode::Orbit;
      if (input.code == key::kG) mode_ = Mode::Fly;
      if (input.code == key::kP) mode_ = Mode::FirstPerson;
      if (input.code == key::kF || input.code == key::kHome) frameAll();
      if (input.code >= key::kOne && input.code <= key::kNine) {
        const auto view = static_cast<std::size_t>(input.code - key::kOne);
        if (view < views_.size()) goTo(views_[view]);
      }
      return;
    case proto::InputKind::Button:
      x_ = input.x, y_ = input.y;
      if (input.pressed) buttons_.insert(input.code);
      if (!input.pressed) buttons_.erase(input.code);
      return;
    case proto::InputKind::Move:
      drag(input.x - x_, input.y - y_);
      x_ = input.x, y_ = input.y;
      return;
    case proto::InputKind::Scroll: {
      const double steps = std::clamp(input.y, -50.0, 50.0);
      if (mode_ != Mode::Orbit) {
        speed_ = std::clamp(speed_ * std::pow(kZoomPerStep, -steps), 1e-4, 100.0);
        return;
      }
      const Vec3 target = eye_ + distance_ * forward();
      distance_ = std::clamp(distance_ * std::pow(kZoomPerStep, steps), 1e-6 * radius_, 1e6 * radius_);
      eye_ = target - distance_ * forward();
      return;
    }
    case proto::InputKind::Gamepad:
      axes_ = input.axes;
      return;
    case proto::InputKind::Quit:
      return;
  }
}

CameraPose Navigator::advance(double seconds) {
  const auto axis = [&](std::int32_t more, std::int32_t alsoMore, std::int32_t less, std::int32_t alsoLess) {
    return (isPressed(more) || isPressed(alsoMore) ? 1.0 : 0.0) -
           (isPressed(less) || isPressed(alsoLess) ? 1.0 : 0.0);
  };
  // GLFW's gamepads: left stick, right stick (down is positive), triggers (-1 at rest).
  const bool hasPad = std::any_of(axes_.begin(), axes_.end(), [](float a) { return a != 0; });
  const double padUp = hasPad ? (stick(axes_[5]) - stick(axes_[4])) / 2 : 0;
  const double ahead = axis(key::kW, key::kUp, key::kS, key::kDown) - stick(axes_[1]);
  const double aside = axis(key::kD, key::kRight, key::kA, key::kLeft) + stick(axes_[0]);
  const double rise = axis(key::kE, key::kE, key::kQ, key::kQ) + padUp;
  look(stick(axes_[2]) * kStickTurnPerS * seconds, -stick(axes_[3]) * kStickTurnPerS * seconds);
  const bool isFast = isPressed(key::kLeftShift) || isPressed(key::kRightShift);
  const double step = std::clamp(seconds, 0.0, 0.25) * speed_ * radius_ * (isFast ? kFaster : 1);
  Vec3 along = forward();
  if (mode_ == Mode::FirstPerson) along = Vec3(std::sin(yawRad_), 0, -std::cos(yawRad_));
  eye_ += step * (ahead * along + aside * right() + rise * Vec3::UnitY());
  // Beyond that the scene is a point, and numbers lose their meaning.
  const Vec3 fromCenter = eye_ - center_;
  const double most = 1e7 * radius_;
  if (fromCenter.norm() > most) eye_ = center_ + fromCenter.normalized() * most;
  CameraPose pose;
  pose.eye = eye_;
  pose.target = eye_ + std::max(distance_, 0x1p-36 * eye_.cwiseAbs().maxCoeff()) * forward();
  pose.fovYRad = views_.front().fovYRad;
  return pose;
}

}  // namespace tessera
