// Keyframes against closed forms and keys worked out by hand.
#include "common/scene/motion/channel.h"

#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "common/scene/motion/node_player.h"

namespace tessera::motion {
namespace {

std::vector<double> at(const Channel& channel, double timeS) {
  std::vector<double> out(std::max<std::size_t>(channel.width, 4));
  sample(channel, timeS, out);
  out.resize(channel.width);
  return out;
}

Channel scalar(Interpolation interpolation, std::vector<float> times, std::vector<float> values) {
  return {.node = 0,
          .path = Path::Weights,
          .interpolation = interpolation,
          .periodS = times.back(),
          .width = 1,
          .timesS = std::move(times),
          .values = std::move(values)};
}

TEST(Channel, StepHoldsAKeyUntilTheNext) {
  const Channel channel = scalar(Interpolation::Step, {1, 2, 4}, {10, 20, 30});
  EXPECT_EQ(at(channel, 0)[0], 10) << "before the first key";
  EXPECT_EQ(at(channel, 1)[0], 10);
  EXPECT_EQ(at(channel, 1.999)[0], 10);
  EXPECT_EQ(at(channel, 2)[0], 20);
  EXPECT_EQ(at(channel, 3.999)[0], 20);
  EXPECT_EQ(at(channel, 4)[0], 10) << "a new round";
  EXPECT_EQ(at(channel, 4 * 7 + 2.5)[0], 20);
}

TEST(Channel, LinearIsAStraightLine) {
  Channel channel = scalar(Interpolation::Linear, {0.5F, 1, 3}, {2, 4, -4});
  EXPECT_EQ(at(channel, 0.25)[0], 2);
  EXPECT_DOUBLE_EQ(at(channel, 0.75)[0], 3);
  EXPECT_DOUBLE_EQ(at(channel, 2)[0], 0);
  EXPECT_DOUBLE_EQ(at(channel, 2.75)[0], -3);
  channel.periodS = 10;  // another channel of the animation lasts longer
  EXPECT_EQ(at(channel, 7)[0], -4) << "after the last key";
  channel.periodS = 0;
  EXPECT_EQ(at(channel, 7)[0], 2) << "an animation without length stands at its start";
}

TEST(Channel, SingleKeyStandsStill) {
  for (const Interpolation kind : {Interpolation::Step, Interpolation::Linear}) {
    const Channel channel = scalar(kind, {1.5F}, {7});
    for (const double t : {0.0, 1.0, 1.5, 2.0, 100.0})
      EXPECT_EQ(at(channel, t)[0], 7);
  }
  const Channel spline = scalar(Interpolation::CubicSpline, {1.5F}, {100, 7, 100});
  for (const double t : {0.0, 1.0, 1.5, 2.0, 100.0})
    EXPECT_EQ(at(spline, t)[0], 7);
}

TEST(Channel, CubicSplineIsThePolynomialThatItsKeysDefine) {
  // Values and tangents of p(t) = 2t^3 - 5t^2 + 3t - 1: a cubic Hermite spline is the cubic itself.
  const auto p = [](double t) { return ((2 * t - 5) * t + 3) * t - 1; };
  const auto slope = [](double t) { return (6 * t - 10) * t + 3; };
  std::vector<float> times = {0, 0.5F, 1.25F, 3}, values;
  for (const float t : times) {
    const double at = static_cast<double>(t);
    values.insert(values.end(),
                  {static_cast<float>(slope(at)), static_cast<float>(p(at)), static_cast<float>(slope(at))});
  }
  const Channel channel = scalar(Interpolation::CubicSpline, times, values);
  for (double t = 0; t < 3; t += 0.01)
    EXPECT_NEAR(at(channel, t)[0], p(t), 1e-5) << t;
}

TEST(Channel, RotationTurnsEvenlyByTheShorterWay) {
  Channel channel = {.path = Path::Rotation, .width = 4, .timesS = {0, 1, 2}};
  const auto key = [](double angle, float sign) {
    return std::vector<float>{0, sign * static_cast<float>(std::sin(angle / 2)), 0,
                              sign * static_cast<float>(std::cos(angle / 2))};
  };
  const double angles[] = {0.2, 1.7, 1.7 + 1e-9};
  for (int i = 0; i < 3; ++i) {
    const auto q = key(angles[i], i == 1 ? -1.0F : 1.0F);  // -q is the same rotation
    channel.values.insert(channel.values.end(), q.begin(), q.end());
  }
  channel.periodS = 3;
  for (double t = 0; t <= 1; t += 0.01) {
    const auto q = at(channel, t);
    const double angle = 0.2 + 1.5 * t;
    EXPECT_NEAR(std::abs(q[1]), std::sin(angle / 2), 1e-6);
    EXPECT_NEAR(std::abs(q[3]), std::cos(angle / 2), 1e-6);
    EXPECT_GT(q[1] * q[3], 0);
    EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-12);
  }
  const auto nearly = at(channel, 1.5);
  EXPECT_NEAR(std::abs(nearly[1]), std::sin(0.85), 1e-6);
}

TEST(Channel, RotationsAgreeWithEigensSlerp) {
  std::mt19937_64 random(3);
  std::normal_distribution<float> normal;
  for (int round = 0; round < 2000; ++round) {
    Eigen::Quaternionf a(normal(random), normal(random), normal(random), normal(random));
    Eigen::Quaternionf b(normal(random), normal(random), normal(random), normal(random));
    a.normalize(), b.normalize();
    Channel channel = {.path = Path::Rotation, .periodS = 8, .width = 4, .timesS = {2, 4}};
    channel.values = {a.x(), a.y(), a.z(), a.w(), b.x(), b.y(), b.z(), b.w()};
    const double t = std::uniform_real_distribution<double>(0, 1)(random);
    const Eigen::Quaterniond expected = a.cast<double>().slerp(t, b.cast<double>());
    const auto q = at(channel, 2 + 2 * t);
    const double cosine =
        q[0] * expected.x() + q[1] * expected.y() + q[2] * expected.z() + q[3] * expected.w();
    ASSERT_NEAR(std::abs(cosine), 1, 1e-6);
  }
}

TEST(Channel, SplineRotationsAreOfLengthOne) {
  Channel channel = {.path = Path::Rotation,
                     .interpolation = Interpolation::CubicSpline,
                     .periodS = 1,
                     .width = 4,
                     .timesS = {0, 1},
                     .values = {0, 0, 0, 0, 0, 0, 0, 1, 3, 0, 0, 0, 0, 2, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}};
  for (double t = 0; t < 1; t += 0.05) {
    const auto q = at(channel, t);
    EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-12);
  }
  const auto half = at(channel, 0.5);
  // By hand: 0.5 p0 + 0.125 out0 + 0.5 p1 - 0.125 in1 = (0.875, -0.25, 0, 0.5).
  EXPECT_NEAR(half[0] / half[3], 0.875 / 0.5, 1e-9);
  EXPECT_NEAR(half[1] / half[3], -0.25 / 0.5, 1e-9);
}

TEST(NodePlayer, MovesWhatHangsBelowAnAnimatedNode) {
  Motion motion;
  motion.nodes.resize(4);
  motion.nodes[0].trs.translation = {10, 0, 0};
  motion.nodes[1].parent = 0;
  motion.nodes[2].parent = 1;
  motion.nodes[2].hasMatrix = true;
  motion.nodes[2].matrix(1, 3) = 2;
  motion.nodes[3].parent = 0;
  motion.nodes[3].weights = {0.25F, 0.5F};
  const auto half = static_cast<float>(std::numbers::sqrt2 / 2);
  motion.channels = {
      {.node = 1,
       .path = Path::Rotation,
       .periodS = 4,
       .width = 4,
       .timesS = {0, 1},
       .values = {0, 0, 0, 1, 0, 0, half, half}},
      {.node = 1,
       .path = Path::Translation,
       .periodS = 4,
       .width = 3,
       .timesS = {0, 2},
       .values = {0, 0, 0, 0, 0, 8}},
      {.node = 1,
       .path = Path::Scale,
       .interpolation = Interpolation::Step,
       .periodS = 4,
       .width = 3,
       .timesS = {0, 3},
       .values = {1, 1, 1, 3, 3, 3}},
      {.node = 3, .path = Path::Weights, .periodS = 4, .width = 2, .timesS = {0, 4}, .values = {0, 1, 4, 3}}};
  NodePlayer player(motion);
  EXPECT_EQ(player.weights(3)[1], 0.5F) << "as loaded";
  player.advance(1);
  EXPECT_EQ(player.world(0), matrixOf({.translation = {10, 0, 0}}));
  EXPECT_EQ(player.world(3), player.world(0));
  EXPECT_FLOAT_EQ(player.weights(3)[0], 1);
  EXPECT_FLOAT_EQ(player.weights(3)[1], 1.5);
  // A quarter turn about z takes (0, 2, 0) to (-2, 0, 0).
  const Vec3 at1 = player.world(2).topRightCorner<3, 1>();
  EXPECT_NEAR((at1 - Vec3(8, 0, 4)).norm(), 0, 1e-6);
  player.advance(3.5);
  const Vec3 at3 = player.world(2).topRightCorner<3, 1>();
  EXPECT_NEAR((at3 - Vec3(4, 0, 8)).norm(), 0, 1e-6);
  player.advance(1);
  EXPECT_EQ(Vec3(player.world(2).topRightCorner<3, 1>()), at1) << "any order of times";
}

}  // namespace
}  // namespace tessera::motion
