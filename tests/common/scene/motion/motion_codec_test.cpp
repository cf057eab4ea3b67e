#include "common/scene/motion/motion_codec.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "common/hierarchy/object_hierarchy.h"
#include "common/scene/motion/node_player.h"

namespace tessera::motion {
namespace {

Motion someMotion(std::mt19937_64& random) {
  std::uniform_real_distribution<float> unit(-1, 1);
  const auto below = [&](std::uint64_t limit) { return static_cast<std::uint32_t>(random() % limit); };
  const auto vec3 = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  Motion motion;
  motion.nodes.resize(5);
  for (std::uint32_t i = 0; i < 5; ++i) {
    Node& node = motion.nodes[i];
    if (i > 0 && below(3) > 0) node.parent = below(i);
    node.hasMatrix = i == 2;
    if (node.hasMatrix) {
      node.matrix.topRows<3>() =
          Eigen::Matrix<double, 3, 4>::NullaryExpr([&] { return double(unit(random)); });
    } else {
      node.trs = {.translation = vec3(), .rotation = {0.5, -0.5, 0.5, 0.5}, .scale = vec3()};
    }
    node.weights.resize(i % 3);
  }
  for (std::uint32_t node : {0U, 1U, 3U, 4U}) {
    Channel channel = {.node = node, .path = node == 1 ? Path::Weights : static_cast<Path>(below(3))};
    channel.interpolation = static_cast<Interpolation>(below(3));
    channel.width = channel.path == Path::Rotation ? 4 : channel.path == Path::Weights ? 1 : 3;
    const std::uint32_t keys = 1 + below(4);
    for (std::uint32_t key = 0; key < keys; ++key)
      channel.timesS.push_back(static_cast<float>(key) + 0.5F);
    channel.values.resize(keys * channel.width *
                          (channel.interpolation == Interpolation::CubicSpline ? 3 : 1));
    for (float& value : channel.values)
      value = unit(random);
    channel.periodS = 7;
    motion.channels.push_back(channel);
  }
  motion.skins.push_back({{0, 3}, {Mat4::Identity(), 2 * Mat4::Identity()}});
  motion.skins[0].inverseBind[1](3, 3) = 1;
  Aabb box;
  box.extend(vec3());
  motion.deformations.push_back({.skin = 0, .jointBoxes = {box, Aabb()}, .targetBoxes = {box}});
  for (std::uint32_t i = 0; i < 3; ++i) {
    Leaf leaf = {.graphLeaf = i, .part = below(9), .node = i == 1 ? 1 : below(5)};
    const std::vector<Vec3> points = {vec3(), vec3(), vec3()};
    leaf.bounds = boundsOf(points, Vec3::Zero());
    if (i == 1) leaf.deformation = 0;
    motion.leaves.push_back(leaf);
  }
  motion.hiddenAsLoaded = {{1, 2}, {4, 9}};
  return motion;
}

Motion someSkeleton() {
  Motion motion;
  motion.skeleton = "bytes of OpenSceneGraph";
  motion.units = {{.node = 3, .firstGraphLeaf = 0, .lastGraphLeaf = 4},
                  {.node = 5, .firstGraphLeaf = 4, .lastGraphLeaf = 4}};
  motion.leaves.resize(1);
  motion.leaves[0].bounds = boundsOf(std::vector<Vec3>{Vec3::Ones()}, Vec3::Zero());
  motion.leaves[0].node = 70;  // of the skeleton, whose size is not known here
  return motion;
}

TEST(MotionCodec, RoundTrips) {
  std::mt19937_64 random(3);
  for (int round = 0; round < 50; ++round) {
    const Motion motion = round == 0 ? someSkeleton() : someMotion(random);
    const std::string bytes = encodeMotion(motion);
    const auto decoded = decodeMotion(bytes);
    ASSERT_TRUE(decoded.ok()) << decoded.error().text();
    EXPECT_EQ(encodeMotion(*decoded), bytes);
    ASSERT_EQ(decoded->leaves.size(), motion.leaves.size());
    for (std::size_t i = 0; i < motion.leaves.size(); ++i) {
      EXPECT_EQ(decoded->leaves[i].nodeToLeaf, motion.leaves[i].nodeToLeaf);
      EXPECT_EQ(decoded->leaves[i].bounds.obb.halfAxes, motion.leaves[i].bounds.obb.halfAxes);
      EXPECT_EQ(decoded->leaves[i].part, motion.leaves[i].part);
    }
    ASSERT_EQ(decoded->channels.size(), motion.channels.size());
    for (std::size_t i = 0; i < motion.channels.size(); ++i)
      EXPECT_EQ(decoded->channels[i].values, motion.channels[i].values);
    EXPECT_EQ(decoded->hiddenAsLoaded, motion.hiddenAsLoaded);
    EXPECT_EQ(decoded->skeleton, motion.skeleton);
  }
}

TEST(MotionCodec, NothingIsStoredOfWhatStandsStill) {
  Motion motion;
  motion.nodes.resize(100);
  EXPECT_EQ(encodeMotion(motion), "");
  const auto decoded = decodeMotion("");
  ASSERT_TRUE(decoded.ok());
  EXPECT_TRUE(decoded->empty());
}

TEST(MotionCodec, DamagedBytesAreRefusedOrCanBePlayed) {
  std::mt19937_64 random(5);
  const std::string bytes = encodeMotion(someMotion(random));
  for (std::size_t size = 1; size < bytes.size(); ++size)
    EXPECT_FALSE(decodeMotion(bytes.substr(0, size)).ok()) << size;
  EXPECT_FALSE(decodeMotion(bytes + '\0').ok());
  std::size_t accepted = 0;
  for (int round = 0; round < 40'000; ++round) {
    std::string damaged = bytes;
    const std::size_t at = random() % damaged.size();
    switch (round % 3) {
      case 0:
        damaged[at] = static_cast<char>(damaged[at] ^ (1 << random() % 8));
        break;
      case 1:
        damaged[at] = static_cast<char>(random());
        break;
      default:  // a whole number at once
        for (std::size_t i = at; i < std::min(at + 4, damaged.size()); ++i)
          damaged[i] = static_cast<char>(0xFF);
        break;
    }
    const auto decoded = decodeMotion(damaged);
    if (!decoded) continue;
    ++accepted;
    NodePlayer player(*decoded);
    player.advance(1.25);
  }
  EXPECT_GT(accepted, 1000U) << "most numbers may be others";
}

TEST(MotionCodec, RefusesReferencesToNothing) {
  std::mt19937_64 random(9);
  const Motion good = someMotion(random);
  const auto refuses = [&](auto spoil) {
    Motion motion = good;
    spoil(motion);
    return !decodeMotion(encodeMotion(motion)).ok();
  };
  EXPECT_FALSE(refuses([](Motion&) {}));
  EXPECT_TRUE(refuses([](Motion& m) { m.nodes[2].parent = 2; })) << "a node above itself";
  EXPECT_TRUE(refuses([](Motion& m) { m.channels[0].node = 5; }));
  EXPECT_TRUE(refuses([](Motion& m) { m.channels[0].node = 2; })) << "a node with a matrix";
  EXPECT_TRUE(refuses([](Motion& m) { m.channels[1].width = 2; }));
  EXPECT_TRUE(refuses([](Motion& m) { m.channels[0].timesS.clear(), m.channels[0].values.clear(); }));
  EXPECT_TRUE(refuses([](Motion& m) { m.channels[0].values.pop_back(); }));
  EXPECT_TRUE(refuses([](Motion& m) { m.channels[0].timesS[0] = std::numeric_limits<float>::quiet_NaN(); }));
  EXPECT_TRUE(refuses([](Motion& m) { m.skins[0].joints[1] = 5; }));
  EXPECT_TRUE(refuses([](Motion& m) { m.skins[0].inverseBind.pop_back(); }));
  EXPECT_TRUE(refuses([](Motion& m) { m.deformations[0].skin = 1; }));
  EXPECT_TRUE(refuses([](Motion& m) { m.deformations[0].jointBoxes.pop_back(); }));
  EXPECT_TRUE(refuses([](Motion& m) { m.deformations[0].targetBoxes.resize(3); }))
      << "more targets than weights";
  EXPECT_TRUE(refuses([](Motion& m) { m.leaves[0].node = 5; }));
  EXPECT_TRUE(refuses([](Motion& m) { m.leaves[1].deformation = 1; }));
  EXPECT_TRUE(refuses([](Motion& m) { m.hiddenAsLoaded = {{4, 9}, {1, 2}}; }));
}

}  // namespace
}  // namespace tessera::motion
