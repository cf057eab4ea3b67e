#include "client/input_collector.h"

#include <limits>

#include <gtest/gtest.h>

#include "proto/codec.h"

namespace tessera {
namespace {

using proto::Input;
using proto::InputKind;

class Collector : public ::testing::Test {
 protected:
  std::vector<Input> take() {
    std::vector<Input> inputs;
    collector_.takeInto(inputs);
    for (const Input& input : inputs) {
      const proto::Bytes bytes = proto::encode(input);
      const auto frame = proto::parseFrame(bytes, proto::Expect::FromTile);
      EXPECT_TRUE(frame && proto::decodeInput(frame->payload)) << "a master would refuse it";
    }
    return inputs;
  }
  InputCollector collector_;
};

TEST_F(Collector, NothingGivesNothing) {
  EXPECT_TRUE(take().empty());
}

TEST_F(Collector, KeysAndButtonsComeInOrder) {
  collector_.key(65, true, 3);
  collector_.button(1, true, 0, 0.25, 0.75);
  collector_.key(65, false, 0);
  const auto inputs = take();
  ASSERT_EQ(inputs.size(), 3U);
  EXPECT_EQ(inputs[0], (Input{.kind = InputKind::Key, .code = 65, .pressed = true, .modifiers = 3}));
  EXPECT_EQ(inputs[1], (Input{.kind = InputKind::Button, .code = 1, .pressed = true, .x = 0.25, .y = 0.75}));
  EXPECT_EQ(inputs[2], (Input{.kind = InputKind::Key, .code = 65, .pressed = false}));
  EXPECT_TRUE(take().empty());
}

TEST_F(Collector, MovesInARowAreOneAndTheSamePlaceIsNone) {
  collector_.moveTo(0.1, 0.1);
  collector_.moveTo(0.2, 0.3);
  auto inputs = take();
  ASSERT_EQ(inputs.size(), 1U);
  EXPECT_EQ(inputs[0].x, 0.2);
  EXPECT_EQ(inputs[0].y, 0.3);
  collector_.moveTo(0.2, 0.3);
  EXPECT_TRUE(take().empty());
  collector_.moveTo(0.3, 0.3);
  collector_.button(0, true, 0, 0.3, 0.3);
  collector_.moveTo(0.4, 0.3);
  inputs = take();
  ASSERT_EQ(inputs.size(), 3U) << "a move before a button is not the one after it";
  EXPECT_EQ(inputs[0].x, 0.3);
  EXPECT_EQ(inputs[2].x, 0.4);
}

TEST_F(Collector, TurnsOfTheWheelAreAddedUp) {
  collector_.scroll(0, 1);
  collector_.scroll(-0.5, 1.5);
  const auto inputs = take();
  ASSERT_EQ(inputs.size(), 1U);
  EXPECT_EQ(inputs[0], (Input{.kind = InputKind::Scroll, .x = -0.5, .y = 2.5}));
}

TEST_F(Collector, AGamepadIsToldOfWhenItChanges) {
  const std::array<float, 6> rest = {0, 0, 0, 0, -1, -1}, pushed = {1, 0, 0, 0, -1, -1};
  collector_.gamepad(2, rest, 0);
  EXPECT_TRUE(take().empty()) << "one at rest has not changed";
  collector_.gamepad(2, pushed, 5);
  collector_.gamepad(2, pushed, 5);
  auto inputs = take();
  ASSERT_EQ(inputs.size(), 1U);
  EXPECT_EQ(inputs[0], (Input{.kind = InputKind::Gamepad, .code = 2, .axes = pushed, .buttons = 5}));
  collector_.noGamepad(2);
  collector_.noGamepad(2);
  inputs = take();
  ASSERT_EQ(inputs.size(), 1U) << "one that is unplugged lets go";
  EXPECT_EQ(inputs[0].axes, rest);
  EXPECT_EQ(inputs[0].buttons, 0U);
}

TEST_F(Collector, WhatTheProtocolDoesNotAllowIsMadeToFit) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  collector_.key(-1, true, 0);
  collector_.key(100000, true, 0);
  collector_.key(65, true, -1);
  collector_.button(0, true, 0, -3, 17);
  collector_.moveTo(kNaN, 2);
  collector_.scroll(kNaN, 1e9);
  collector_.gamepad(0, {kInfinity, 7, -7, 0, 0, 0}, 0xFFFFFFFF);
  collector_.gamepad(99, {}, 1);
  const auto inputs = take();
  ASSERT_EQ(inputs.size(), 5U) << "a key without a number is not told";
  EXPECT_EQ(inputs[0].modifiers, 63U);
  EXPECT_EQ(inputs[1].x, 0);
  EXPECT_EQ(inputs[1].y, 1);
  EXPECT_EQ(inputs[3].y, proto::kMaxScrollSteps);
  EXPECT_EQ(inputs[4].axes[1], 1);
}

TEST_F(Collector, AFloodIsBoundedAndKeepsItsQuit) {
  for (int i = 0; i < 10'000; ++i)
    collector_.key(i % 300, true, 0);
  collector_.quit();
  collector_.quit();
  std::size_t all = 0, quits = 0;
  for (;;) {
    const auto inputs = take();
    if (inputs.empty()) break;
    EXPECT_LE(inputs.size(), InputCollector::kMostAtOnce);
    all += inputs.size();
    for (const Input& input : inputs)
      quits += input.kind == InputKind::Quit ? 1U : 0U;
  }
  EXPECT_LT(all, 300U);
  EXPECT_EQ(quits, 1U);
}

TEST_F(Collector, AllThatIsTakenStaysBelowWhatAMasterAllows) {
  EXPECT_LE(60 * InputCollector::kMostAtOnce, 1000U);
}

}  // namespace
}  // namespace tessera
