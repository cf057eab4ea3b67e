#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <vector>

#include "common/geometry/vec.h"
#include "common/wall/wall.h"
#include "proto/messages.h"

namespace tessera {

/// Moves the camera as an operator's mouse, keyboard and gamepad say.
///
///   orbit (O)         left drag turns about the point looked at, right or middle drag shifts, the wheel
///   zooms fly (G)           left drag looks, W A S D and arrows move along the view, Q E down and up, the
///   wheel sets the speed first person (P)  the same, but the eye keeps its height unless Q or E is pressed
///   all               1 to 9: named views; F or Home: all in view; Shift: faster; gamepad: sticks move and
///                     look, triggers go down and up
///
/// World space, y up. Used by one thread.
class Navigator {
 public:
  enum class Mode : std::uint8_t { Orbit, Fly, FirstPerson };

  /// Starts at the first of the views, which are those of the keys 1 to 9; at least one. The sphere holds the
  /// scene; `fovYRad` frames it.
  Navigator(std::vector<CameraPose> views, const Vec3& sceneCenter, double sceneRadius, double fovYRad);

  /// Something that a person did. What means nothing here is ignored.
  void handle(const proto::Input& input);
  /// The pose after so many more seconds with what is pressed now. Always fit for viewOf.
  [[nodiscard]] CameraPose advance(double seconds);

  [[nodiscard]] Mode mode() const { return mode_; }

 private:
  void goTo(const CameraPose& pose);
  void frameAll();
  void drag(double dx, double dy);
  void look(double turnRad, double pitchRad);
  [[nodiscard]] Vec3 forward() const;
  [[nodiscard]] Vec3 right() const;
  [[nodiscard]] bool isPressed(std::int32_t key) const { return keys_.contains(key); }

  std::vector<CameraPose> views_;
  Vec3 center_;
  double radius_, fovYRad_;
  Mode mode_ = Mode::Orbit;
  Vec3 eye_ = Vec3::Zero();
  double yawRad_ = 0, pitchRad_ = 0;  ///< of the view: to the right of -z, above the horizon
  double distance_ = 1;               ///< to the point looked at
  double speed_ = 0.3;                ///< radii a second
  std::set<std::int32_t> keys_;
  std::set<std::int32_t> buttons_;
  double x_ = 0, y_ = 0;  ///< of the pointer
  std::array<float, 6> axes_ = {};
};

}  // namespace tessera
