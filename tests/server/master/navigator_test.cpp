#include "server/master/navigator.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using proto::Input;
using proto::InputKind;

constexpr std::int32_t kF = 70, kG = 71, kP = 80, kTwo = 50, kW = 87, kE = 69, kShift = 340;

Navigator navigator() {
  return Navigator(
      {CameraPose{.eye = {0, 2, 10}, .target = {0, 2, 0}}, CameraPose{.eye = {5, 5, 5}, .target = {0, 0, 0}}},
      Vec3(0, 2, 0), 4, 1);
}

Input key(std::int32_t code, bool pressed = true) {
  return {.kind = InputKind::Key, .code = code, .pressed = pressed};
}
Input button(std::int32_t code, bool pressed, double x, double y) {
  return {.kind = InputKind::Button, .code = code, .pressed = pressed, .x = x, .y = y};
}
Input move(double x, double y) {
  return {.kind = InputKind::Move, .x = x, .y = y};
}

Vec3 viewOf(const CameraPose& pose) {
  return (pose.target - pose.eye).normalized();
}

TEST(Navigator, startsAtTheFirstViewAndGoesToOthers) {
  Navigator n = navigator();
  CameraPose pose = n.advance(0.1);
  EXPECT_LT((pose.eye - Vec3(0, 2, 10)).norm(), 1e-12);
  EXPECT_LT((pose.target - Vec3(0, 2, 0)).norm(), 1e-12);
  n.handle(key(kTwo));
  pose = n.advance(0.1);
  EXPECT_LT((pose.eye - Vec3(5, 5, 5)).norm(), 1e-12);
  EXPECT_LT((viewOf(pose) - Vec3(-1, -1, -1).normalized()).norm(), 1e-12);
}

TEST(Navigator, orbitKeepsWhatIsLookedAtAndItsDistance) {
  Navigator n = navigator();
  n.handle(button(0, true, 0.5, 0.5));
  n.handle(move(0.75, 0.5));  // a quarter of a tile: a quarter of half a turn
  const CameraPose pose = n.advance(0);
  EXPECT_LT((pose.target - Vec3(0, 2, 0)).norm(), 1e-12);
  EXPECT_NEAR((pose.eye - pose.target).norm(), 10, 1e-12);
  EXPECT_NEAR(pose.eye.y(), 2, 1e-12);
  EXPECT_NEAR(std::acos(viewOf(pose).dot(Vec3(0, 0, -1))), std::numbers::pi / 4, 1e-12);
  n.handle(button(0, false, 0.75, 0.5));
  n.handle(move(0.1, 0.1));
  EXPECT_EQ(n.advance(0).eye, pose.eye) << "moves without a button";
}

TEST(Navigator, theWheelZoomsAndFrameAllShowsAll) {
  Navigator n = navigator();
  n.handle({.kind = InputKind::Scroll, .y = 3});
  CameraPose pose = n.advance(0);
  EXPECT_NEAR((pose.eye - pose.target).norm(), 10 * std::pow(0.9, 3), 1e-9);
  n.handle(key(kF));
  pose = n.advance(0);
  // The sphere of radius 4 just fits the cone of one radian.
  EXPECT_NEAR((pose.eye - Vec3(0, 2, 0)).norm() * std::sin(0.5), 4, 1e-9);
}

TEST(Navigator, keysMoveAlongTheViewAsLongAsTheyAreDown) {
  Navigator n = navigator();
  n.handle(key(kG));
  n.handle(key(kW));
  const double a = n.advance(0.1).eye.z();
  const double b = n.advance(0.1).eye.z();
  EXPECT_LT(a, 10);
  EXPECT_NEAR(b - a, a - 10, 1e-12);
  n.handle(key(kShift));
  EXPECT_NEAR(n.advance(0.1).eye.z() - b, 4 * (a - 10), 1e-12);
  n.handle(key(kW, false));
  const Vec3 rest = n.advance(0.1).eye;
  EXPECT_EQ(n.advance(0.1).eye, rest);
}

TEST(Navigator, inFirstPersonTheEyeKeepsItsHeight) {
  Navigator n = navigator();
  n.handle(key(kP));
  n.handle(button(0, true, 0.5, 0.5));
  n.handle(move(0.5, 0.3));
  n.handle(button(0, false, 0.5, 0.3));
  n.handle(key(kW));
  const CameraPose pose = n.advance(0.2);
  EXPECT_NE(viewOf(pose).y(), 0);
  EXPECT_DOUBLE_EQ(pose.eye.y(), 2);
  n.handle(key(kE));
  EXPECT_GT(n.advance(0.2).eye.y(), 2);
}

TEST(Navigator, gamepadsMoveAndLookBeyondTheirDeadZone) {
  Navigator n = navigator();
  n.handle(key(kG));
  Input pad{.kind = InputKind::Gamepad};
  pad.axes = {0.1F, -0.1F, 0.1F, 0, -1, -1};
  n.handle(pad);
  EXPECT_LT((n.advance(0.1).eye - Vec3(0, 2, 10)).norm(), 1e-12);
  pad.axes = {0, -1, 0.5F, 0, -1, -1};
  n.handle(pad);
  const CameraPose pose = n.advance(0.1);
  EXPECT_LT(pose.eye.z(), 10);
  EXPECT_GT(viewOf(pose).x(), 0);
}

/// Whatever is done, poses stay numbers that a wall can be seen from.
TEST(Navigator, anyInputGivesAPose) {
  Navigator n = navigator();
  std::uint32_t state = 1;
  const auto random = [&state](std::uint32_t below) {
    state = state * 1664525U + 1013904223U;
    return (state >> 8U) % below;
  };
  for (int i = 0; i < 200000; ++i) {
    Input input;
    input.kind = static_cast<InputKind>(random(6));
    input.code = static_cast<std::int32_t>(random(350));
    input.pressed = random(2) == 0;
    input.x = random(1001) / 1000.0;
    input.y =
        input.kind == InputKind::Scroll ? static_cast<double>(random(2001)) - 1000 : random(1001) / 1000.0;
    for (float& axis : input.axes)
      axis = static_cast<float>(random(2001)) / 1000 - 1;
    n.handle(input);
    const CameraPose pose = n.advance(random(100) / 10.0);
    ASSERT_TRUE(pose.eye.allFinite() && pose.target.allFinite()) << i;
    const Vec3 view = viewOf(pose);
    ASSERT_NEAR(view.norm(), 1, 1e-9) << i;
    ASSERT_GT(view.cross(Vec3(0, 1, 0)).norm(), 1e-3) << i;
  }
}

}  // namespace
}  // namespace tessera
