#include "proto/pose_codec.h"

#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "proto/protocol_error.h"
#include "tests/proto/test_messages.h"

namespace tessera::proto {
namespace {

using test::ExactBytes;
using test::MessageMaker;

std::optional<ProtocolError> refusal(const std::vector<int>& bytes) {
  std::vector<std::byte> raw;
  for (const int byte : bytes)
    raw.push_back(static_cast<std::byte>(byte));
  const ExactBytes exact(raw);
  const auto decoded = decodePoseBytes(exact.view());
  if (decoded) return std::nullopt;
  return protocolErrorOf(decoded.error());
}

TEST(PoseCodec, RoundTripsWithOneEncodingOnly) {
  MessageMaker maker(1);
  for (int round = 0; round < 2000; ++round) {
    const Poses poses = maker.poses();
    std::vector<std::byte> bytes, again;
    encodePoseBytes(poses.poses, bytes);
    const ExactBytes exact(bytes);
    const auto decoded = decodePoseBytes(exact.view());
    ASSERT_TRUE(decoded.ok()) << decoded.error().text();
    ASSERT_EQ(*decoded, poses.poses);
    encodePoseBytes(*decoded, again);
    ASSERT_EQ(again, bytes);
  }
}

TEST(PoseCodec, DamagedBytesAreRefusedOrHarmless) {
  MessageMaker maker(2);
  for (int round = 0; round < 300; ++round) {
    std::vector<std::byte> bytes;
    encodePoseBytes(maker.poses().poses, bytes);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const ExactBytes prefix{std::span<const std::byte>(bytes).first(size)};
      ASSERT_FALSE(decodePoseBytes(prefix.view()).ok());
    }
    for (int flip = 0; flip < 50; ++flip) {
      std::vector<std::byte> damaged = bytes;
      damaged[maker.below(bytes.size())] ^= static_cast<std::byte>(1U << maker.below(8));
      const ExactBytes exact(damaged);
      const auto decoded = decodePoseBytes(exact.view());
      if (!decoded) continue;
      std::vector<std::byte> again;
      encodePoseBytes(*decoded, again);
      ASSERT_EQ(again, damaged);  // whatever is accepted has one encoding
    }
  }
}

TEST(PoseCodec, RefusesWhatBreaksARule) {
  const std::vector<int> weight = {0, 0, 0x80, 0x3f}, infinite = {0, 0, 0x80, 0x7f};
  const auto with = [](std::vector<int> head, const std::vector<int>& tail) {
    head.insert(head.end(), tail.begin(), tail.end());
    return head;
  };
  EXPECT_EQ(refusal({0}), std::nullopt);
  EXPECT_EQ(refusal(with({1, 7, 8, 1}, weight)), std::nullopt);
  EXPECT_EQ(refusal({}), ProtocolError::Truncated);
  EXPECT_EQ(refusal({0, 0}), ProtocolError::TrailingBytes);
  EXPECT_EQ(refusal(with({1, 7, 8, 1}, infinite)), ProtocolError::BadNumber);
  EXPECT_EQ(refusal(with({1, 0x87, 0, 8, 1}, weight)), ProtocolError::BadNumber) << "a padded varint";
  EXPECT_EQ(refusal(with({1, 7, 16, 1}, weight)), ProtocolError::BadEnum);
  EXPECT_EQ(refusal(with({1, 7, 11, 1}, weight)), ProtocolError::BadEnum);
  EXPECT_EQ(refusal({1, 7, 0, 0, 0, 0, 0, 0}), ProtocolError::Malformed) << "changes nothing";
  EXPECT_EQ(refusal({1, 7, 8, 0, 0, 0, 0, 0}), ProtocolError::BadCount) << "no weights";
  EXPECT_EQ(refusal(with({1, 7, 8, 0x81, 0x20}, weight)), ProtocolError::BadCount) << "4097 weights";
  EXPECT_EQ(refusal(with({1, 7, 4, 1}, weight)), ProtocolError::Truncated) << "a joint is 12 floats";
  EXPECT_EQ(refusal({0x81, 0x80, 0x04}), ProtocolError::BadCount) << "65537 poses";
  EXPECT_EQ(refusal({0x80, 0x80, 0x04}), ProtocolError::Truncated);
  EXPECT_EQ(refusal(with({1, 0xff, 0xff, 0xff, 0xff, 0x10, 8, 1}, weight)), ProtocolError::BadNumber);
  // The id after the last one there is.
  const std::vector<int> last = with({2, 0xff, 0xff, 0xff, 0xff, 0x0f, 8, 1}, weight);
  EXPECT_EQ(refusal(with(last, with({0, 8, 1}, weight))), ProtocolError::BadNumber);
}

TEST(PoseCodec, RefusesNumbersThatAreNotFiniteAndTooManySteps) {
  MessageMaker maker(5);
  Pose pose = {.id = 3, .form = PoseForm::Matrix};
  const auto refused = [&] {
    std::vector<std::byte> bytes;
    encodePoseBytes({&pose, 1}, bytes);
    const auto decoded = decodePoseBytes(bytes);
    return decoded ? std::nullopt : protocolErrorOf(decoded.error());
  };
  EXPECT_EQ(refused(), std::nullopt);
  pose.localToWorld(1, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refused(), ProtocolError::BadNumber);
  pose = {.id = 3, .form = PoseForm::Steps};
  pose.steps.counts[4] = -kMaxPoseSteps;
  EXPECT_EQ(refused(), std::nullopt);
  pose.steps.counts[4] = kMaxPoseSteps + 1;
  EXPECT_EQ(refused(), ProtocolError::BadNumber);
  pose = {.id = 3, .joints = std::vector<float>(12 * (kMaxPoseJoints + 1))};
  EXPECT_EQ(refused(), ProtocolError::BadCount);
}

/// The largest shift of points of the box, corners among them; in long double.
double shiftOf(const Mat4& a, const Mat4& b, const Aabb& box, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  long double most = 0;
  for (unsigned i = 0; i < 40; ++i) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) {
      const double t = i < 8 ? (i >> k & 1U) : unit(random);
      p[k] = box.min[k] + t * (box.max[k] - box.min[k]);
    }
    long double squared = 0;
    for (int row = 0; row < 3; ++row) {
      long double shift = static_cast<long double>(a(row, 3)) - b(row, 3);
      for (int k = 0; k < 3; ++k)
        shift += (static_cast<long double>(a(row, k)) - b(row, k)) * p[k];
      squared += shift * shift;
    }
    most = std::max(most, std::sqrt(squared));
  }
  return static_cast<double>(most);
}

Mat4 anyPose(std::mt19937_64& random, double translation) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(-1, 1);
  Mat4 m = Mat4::Identity();
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
  m.topLeftCorner<3, 3>() = turn.toRotationMatrix() * std::exp2(3 * unit(random));
  m.topRightCorner<3, 1>() = translation * Vec3(unit(random), unit(random), unit(random));
  return m;
}

TEST(PoseSteps, KeepTheirBound) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::size_t steps = 0, bytes = 0;
  for (int round = 0; round < 20'000; ++round) {
    const double translation = std::pow(10.0, static_cast<double>(random() % 8));  // to 1e7
    const Mat4 base = anyPose(random, translation), now = anyPose(random, translation);
    Aabb box;
    const double size = std::pow(10.0, 3 * unit(random));
    for (int i = 0; i < 2; ++i)
      box.extend(size * Vec3(unit(random), unit(random), random() % 4 == 0 ? 0.25 : unit(random)));
    const double bound = std::pow(10.0, -2 - 2 * unit(random));
    const auto made = toSteps(base, now, box, bound);
    ASSERT_TRUE(made) << "bound " << bound << ", translation " << translation;
    const Mat4 reached = fromSteps(base, *made);
    ASSERT_LE(shiftOf(reached, now, box, random), bound) << "size " << size;
    ASSERT_EQ(reached.row(3), now.row(3));
    const Pose pose = {.id = 0, .form = PoseForm::Steps, .localToWorld = Mat4::Identity(), .steps = *made};
    std::vector<std::byte> encoded;
    encodePoseBytes({&pose, 1}, encoded);
    bytes += encoded.size();
    ++steps;
  }
  RecordProperty("bytes_per_pose", static_cast<int>(bytes / steps));
  EXPECT_LT(bytes / steps, 64U);  // a matrix takes 98
}

TEST(PoseSteps, AreNotMadeWhereNoneAreFineEnough) {
  Aabb box;
  box.extend(Vec3(-1, -1, -1));
  box.extend(Vec3(1, 1, 1));
  Mat4 base = Mat4::Identity(), now = base;
  now(0, 3) = 1e10 + 0.3;
  EXPECT_FALSE(toSteps(base, now, box, 1e-7)) << "a double is coarser there";
  EXPECT_TRUE(toSteps(base, now, box, 1e-4));
  now(0, 3) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(toSteps(base, now, box, 1));
  EXPECT_FALSE(toSteps(base, base, Aabb(), 1));
  Aabb point;
  point.extend(Vec3::Zero());
  EXPECT_TRUE(toSteps(base, base, point, 1e-3));
}

}  // namespace
}  // namespace tessera::proto
