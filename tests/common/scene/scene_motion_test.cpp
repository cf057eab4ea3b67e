// What moves in whole scenes: levels of detail, switches, sequences and callbacks of OpenSceneGraph,
// animations of glTF.
#include "common/scene/scene_motion.h"

#include <cmath>
#include <filesystem>
#include <numbers>

#include <gtest/gtest.h>
#include <osg/AnimationPath>
#include <osg/Geometry>
#include <osg/LOD>
#include <osg/MatrixTransform>
#include <osg/PositionAttitudeTransform>
#include <osg/Sequence>
#include <osg/Switch>
#include <osgDB/WriteFile>

#include "common/scene/load_scene.h"
#include "common/scene/motion/motion_codec.h"
#include "tests/common/scene/gltf_builder.h"

namespace tessera::test {
namespace {

osg::ref_ptr<osg::Geometry> triangleAt(float x) {
  osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
  vertices->push_back(osg::Vec3(x, 0, 0));
  vertices->push_back(osg::Vec3(x + 1, 0, 0));
  vertices->push_back(osg::Vec3(x, 1, 0));
  geometry->setVertexArray(vertices);
  geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, 3));
  return geometry;
}

Result<Scene> loaded(osg::Node& graph, const LoadOptions& options = {.up = UpAxis::Y}) {
  const TempFolder folder;
  const std::string file = folder.path() / "scene.osgb";
  EXPECT_TRUE(osgDB::writeNodeFile(graph, file));
  return loadScene(file, options);
}

std::unique_ptr<motion::MotionPlayer> playerOf(const Scene& scene, bool animates) {
  auto player = motionPlayerOf(scene, animates);
  EXPECT_TRUE(player) << (player ? "" : player.error().text());
  return player ? std::move(*player) : nullptr;
}

std::shared_ptr<Scene> sceneOf(osg::Node& graph, const LoadOptions& options = {.up = UpAxis::Y}) {
  auto scene = loaded(graph, options);
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().text());
  return scene ? std::make_shared<Scene>(std::move(*scene)) : nullptr;
}

Vec3 placeOf(const motion::MotionPlayer& player, std::uint32_t leaf) {
  return player.poseOf(leaf)->localToWorld.topRightCorner<3, 1>();
}

TEST(SceneMotion, ASwitchHidesWhatIsOff) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  osg::ref_ptr<osg::Switch> choice = new osg::Switch;
  osg::ref_ptr<osg::Group> two = new osg::Group;
  two->addChild(triangleAt(2));
  two->addChild(triangleAt(3));
  root->addChild(triangleAt(0));
  root->addChild(choice);
  choice->addChild(triangleAt(1), true);
  choice->addChild(two, false);
  root->addChild(triangleAt(4));
  const auto scene = sceneOf(*root);
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->leaves.size(), 5U);
  // Drawables of a node come first: 0, 4, then the switch's 1, then 2 and 3.
  EXPECT_EQ(scene->hierarchy.absentLeaves(), (VisibleList{{3, 5}}));
  // Camera paths see the scene as large as what it shows.
  osg::ref_ptr<osg::Group> without = new osg::Group;
  for (const float x : {0.0F, 1.0F, 4.0F})
    without->addChild(triangleAt(x));
  const auto small = sceneOf(*without);
  EXPECT_NEAR((scene->sphere().center - small->sphere().center).norm(), 0, 1e-6);
  EXPECT_NEAR(scene->sphere().radius, small->sphere().radius, 1e-6);
  const auto player = playerOf(*scene, false);
  ASSERT_TRUE(player);
  player->advance(0, Vec3::Zero());
  EXPECT_FALSE(player->absentChanged());
  EXPECT_EQ(player->absent(), (VisibleList{{3, 5}}));
  EXPECT_TRUE(player->moved().empty());
}

osg::ref_ptr<osg::LOD> threeLevels(float x) {
  osg::ref_ptr<osg::LOD> lod = new osg::LOD;
  const float ranges[] = {0, 10, 50, 200};
  for (unsigned int level = 0; level < 3; ++level) {
    osg::ref_ptr<osg::Group> child = new osg::Group;
    for (unsigned int i = 0; i <= level; ++i)
      child->addChild(triangleAt(x));
    lod->addChild(child, ranges[level], ranges[level + 1]);
  }
  lod->setCenterMode(osg::LOD::USER_DEFINED_CENTER);
  lod->setCenter(osg::Vec3(x, 0, 0));
  return lod;
}

TEST(SceneMotion, ALevelOfDetailChoosesByTheEyeAlsoWhereNothingIsAnimated) {
  osg::ref_ptr<osg::MatrixTransform> root = new osg::MatrixTransform(osg::Matrixd::translate(0, 1000, 0));
  root->addChild(threeLevels(0));
  root->addChild(threeLevels(100));
  for (const HierarchyKind kind : {HierarchyKind::Graph, HierarchyKind::Bvh}) {
    const auto scene = sceneOf(*root, {.up = UpAxis::Y, .hierarchy = kind, .maxTrianglesPerLeaf = 50});
    ASSERT_TRUE(scene);
    ASSERT_EQ(scene->leaves.size(), 12U);
    const auto levelsShown = [&](const VisibleList& absent) {
      // Of each of both which levels are there; a level is there as a whole or not at all.
      std::array<std::set<int>, 2> shown;
      constexpr int kLevels[] = {0, 1, 1, 2, 2, 2};
      std::array<std::array<int, 3>, 2> counts{};
      for (std::uint32_t leaf = 0; leaf < 12; ++leaf) {
        if (containsLeaf(absent, leaf)) continue;
        const std::uint32_t graphLeaf = scene->leaves[leaf].graphLeaf;
        ++counts[graphLeaf / 6][static_cast<std::size_t>(kLevels[graphLeaf % 6])];
      }
      for (std::size_t lod = 0; lod < 2; ++lod) {
        for (int level = 0; level < 3; ++level) {
          const int count = counts[lod][static_cast<std::size_t>(level)];
          EXPECT_TRUE(count == 0 || count == level + 1);
          if (count > 0) shown[lod].insert(level);
        }
      }
      return shown;
    };
    using Shown = std::array<std::set<int>, 2>;
    EXPECT_EQ(levelsShown(scene->hierarchy.absentLeaves()), (Shown{{{0}, {0}}})) << "the finest, as loaded";
    const auto player = playerOf(*scene, false);
    ASSERT_TRUE(player);
    const auto at = [&](const Vec3& eye) {
      player->advance(0, eye);
      return levelsShown(player->absent());
    };
    EXPECT_EQ(at({0, 1000, 5}), (Shown{{{0}, {2}}}));
    EXPECT_TRUE(player->absentChanged());
    EXPECT_EQ(at({0, 1001, 5}), (Shown{{{0}, {2}}}));
    EXPECT_FALSE(player->absentChanged());
    EXPECT_EQ(at({50, 1000, 9.99}), (Shown{{{2}, {2}}}));
    EXPECT_EQ(at({60, 1000, 0}), (Shown{{{2}, {1}}}));
    EXPECT_EQ(at({100, 1000, 9.99}), (Shown{{{2}, {0}}}));
    EXPECT_EQ(at({100, 1000, 10.01}), (Shown{{{2}, {1}}}));
    EXPECT_EQ(at({100, 1000, 500}), (Shown{}));
  }
}

TEST(SceneMotion, ASequenceRunsOnlyWhereTheSceneIsPlayed) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  osg::ref_ptr<osg::Sequence> sequence = new osg::Sequence;
  for (int i = 0; i < 3; ++i)
    sequence->addChild(triangleAt(static_cast<float>(i)), 0.5);
  sequence->setInterval(osg::Sequence::LOOP, 0, 2);
  sequence->setDuration(1, -1);
  sequence->setMode(osg::Sequence::START);
  root->addChild(sequence);
  const auto scene = sceneOf(*root);
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->leaves.size(), 3U);
  EXPECT_EQ(leafCount(scene->hierarchy.absentLeaves()), 2U);
  const auto still = playerOf(*scene, false), playing = playerOf(*scene, true);
  std::set<std::uint32_t> seen;
  for (int frame = 0; frame < 120; ++frame) {
    still->advance(frame / 60.0, Vec3::Zero());
    EXPECT_EQ(still->absent(), scene->hierarchy.absentLeaves());
    playing->advance(frame / 60.0, Vec3::Zero());
    EXPECT_EQ(leafCount(playing->absent()), 2U);
    for (std::uint32_t leaf = 0; leaf < 3; ++leaf) {
      if (!containsLeaf(playing->absent(), leaf)) seen.insert(leaf);
    }
  }
  EXPECT_EQ(seen.size(), 3U);
}

TEST(SceneMotion, AnimationPathsMoveWhatHangsBelow) {
  osg::ref_ptr<osg::AnimationPath> path = new osg::AnimationPath;
  path->setLoopMode(osg::AnimationPath::LOOP);
  for (int i = 0; i <= 4; ++i) {
    const double turn = i * std::numbers::pi / 2;
    path->insert(i, osg::AnimationPath::ControlPoint(osg::Vec3d(3 * i, i * i, 0),
                                                     osg::Quat(turn, osg::Vec3d(0, 0, 1))));
  }
  osg::ref_ptr<osg::MatrixTransform> mover = new osg::MatrixTransform, below = new osg::MatrixTransform;
  mover->setUpdateCallback(new osg::AnimationPathCallback(path));
  below->setMatrix(osg::Matrixd::scale(2, 2, 2) * osg::Matrixd::translate(0, 0, 7));
  osg::ref_ptr<osg::Group> root = new osg::Group;
  root->addChild(mover);
  mover->addChild(below);
  below->addChild(triangleAt(1));
  root->addChild(triangleAt(9));
  const auto scene = sceneOf(*root);
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->leaves.size(), 2U);
  EXPECT_FALSE(playerOf(*scene, false)) << "nothing to do where it stands";
  const auto player = playerOf(*scene, true);
  ASSERT_TRUE(player);
  int moves = 0;
  for (int frame = 0; frame < 300; ++frame) {
    const double time = frame / 60.0;
    player->advance(time, Vec3::Zero());
    osg::Matrixd expected;
    ASSERT_TRUE(path->getMatrix(time, expected));
    expected = below->getMatrix() * expected;
    ASSERT_LE(player->moved().size(), 1U) << "the other one stands";
    if (player->moved().empty()) continue;
    ++moves;
    ASSERT_EQ(player->moved()[0], 1U);
    const motion::LeafPose& pose = *player->poseOf(1);
    for (const osg::Vec3d p : {osg::Vec3d(1, 0, 0), osg::Vec3d(2, 0, 0), osg::Vec3d(1, 1, 0)}) {
      const osg::Vec3d q = p * expected;
      const Vec3 mine = (pose.localToWorld * Eigen::Vector4d(p.x(), p.y(), p.z(), 1)).head<3>();
      ASSERT_NEAR((mine - Vec3(q.x(), q.y(), q.z())).norm(), 0, 1e-9) << time;
      ASSERT_TRUE((pose.bounds.aabb.min.array() <= mine.array()).all() &&
                  (mine.array() <= pose.bounds.aabb.max.array()).all());
      ASSERT_LE((mine - pose.bounds.sphere.center).norm(), pose.bounds.sphere.radius);
    }
  }
  EXPECT_GT(moves, 200);
}

TEST(SceneMotion, WhatHidesInsideWhatIsHiddenStaysHidden) {
  osg::ref_ptr<osg::Switch> outer = new osg::Switch, inner = new osg::Switch;
  inner->addChild(triangleAt(0), true);
  inner->addChild(triangleAt(1), false);
  outer->addChild(inner, false);
  outer->addChild(triangleAt(2), true);
  outer->addChild(triangleAt(3), false);
  const auto scene = sceneOf(*outer);
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->leaves.size(), 4U);
  std::set<std::uint32_t> shown;
  for (std::uint32_t leaf = 0; leaf < 4; ++leaf) {
    if (!containsLeaf(scene->hierarchy.absentLeaves(), leaf)) shown.insert(leaf);
  }
  ASSERT_EQ(shown.size(), 1U);
  EXPECT_NEAR(scene->hierarchy.aabb(scene->hierarchy.nodeOfLeaf(*shown.begin())).min.x(), 2, 1e-6);
  const auto player = playerOf(*scene, true);
  player->advance(0, Vec3::Zero());
  EXPECT_EQ(player->absent(), scene->hierarchy.absentLeaves());
}

struct UnknownCallback : osg::NodeCallback {
  void operator()(osg::Node* node, osg::NodeVisitor* visitor) override { traverse(node, visitor); }
};

TEST(SceneMotion, StillScenesStoreNothing) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  root->addChild(triangleAt(0));
  const auto scene = sceneOf(*root);
  ASSERT_TRUE(scene);
  EXPECT_TRUE(scene->motion.empty());
  EXPECT_FALSE(playerOf(*scene, true));
}

// A box on a slider: one node with a translation of three keys and a child of its own.
TEST(SceneMotion, GltfAnimationsMoveTheirLeaves) {
  GltfBuilder file = triangleFile();
  const int child = file.add("nodes", {{"mesh", 0}, {"translation", {5, 0, 0}}});
  file.json["nodes"][0]["children"] = {child};
  file.add("nodes", {{"mesh", 0}, {"translation", {0, 0, -9}}});
  file.json["scenes"][0]["nodes"].push_back(2);
  const int times = file.accessor(std::vector<float>{0, 1, 3}, "SCALAR", kFloat);
  const int values = file.accessor(std::vector<float>{0, 0, 0, 0, 2, 0, 0, 2, 8}, "VEC3", kFloat);
  nlohmann::json animation;
  animation["samplers"] = {{{"input", times}, {"output", values}, {"interpolation", "LINEAR"}}};
  animation["channels"] = {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}};
  file.add("animations", animation);
  const TempFolder folder;
  const auto scene = loadScene(folder.write("scene.glb", file.glb()));
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_TRUE(scene->warnings.empty());
  const auto player = playerOf(*scene, true);
  ASSERT_TRUE(player);
  player->advance(0.5, Vec3::Zero());
  EXPECT_EQ(std::vector<std::uint32_t>(player->moved().begin(), player->moved().end()),
            (std::vector<std::uint32_t>{0, 1}));
  EXPECT_NEAR((placeOf(*player, 0) - Vec3(0, 1, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((placeOf(*player, 1) - Vec3(5, 1, 0)).norm(), 0, 1e-12);
  EXPECT_EQ(player->poseOf(2), nullptr);
  player->advance(2, Vec3::Zero());
  EXPECT_NEAR((placeOf(*player, 1) - Vec3(5, 2, 4)).norm(), 0, 1e-12);
  player->advance(3.5, Vec3::Zero());
  EXPECT_NEAR((placeOf(*player, 1) - Vec3(5, 1, 0)).norm(), 0, 1e-12) << "round and round";
  player->advance(3.5, Vec3::Zero());
  EXPECT_TRUE(player->moved().empty()) << "only what changed";
}

TEST(SceneMotion, BrokenAnimationsAreLeftOutWithAWarning) {
  const auto spoiled = [](const std::function<void(nlohmann::json&)>& spoil) {
    GltfBuilder file = triangleFile();
    const int times = file.accessor(std::vector<float>{0, 1}, "SCALAR", kFloat);
    const int values = file.accessor(std::vector<float>{0, 0, 0, 0, 2, 0}, "VEC3", kFloat);
    file.accessor(std::vector<float>{1, 0}, "SCALAR", kFloat);
    nlohmann::json animation;
    animation["samplers"] = {{{"input", times}, {"output", values}}};
    animation["channels"] = {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}};
    spoil(animation);
    file.add("animations", animation);
    const TempFolder folder;
    const auto scene = loadScene(folder.write("scene.glb", file.glb()));
    EXPECT_TRUE(scene) << (scene ? "" : scene.error().text());
    return scene ? std::pair(scene->warnings.size(), scene->motion.empty())
                 : std::pair(std::size_t{99}, true);
  };
  using Outcome = std::pair<std::size_t, bool>;
  EXPECT_EQ(spoiled([](nlohmann::json&) {}), (Outcome{0, false}));
  const Outcome leftOut = {1, true};
  EXPECT_EQ(spoiled([](auto& a) { a["channels"][0]["sampler"] = 1; }), leftOut);
  EXPECT_EQ(spoiled([](auto& a) { a["channels"][0]["target"]["node"] = 7; }), leftOut);
  EXPECT_EQ(spoiled([](auto& a) { a["channels"][0]["target"]["path"] = "weights"; }), leftOut);
  EXPECT_EQ(spoiled([](auto& a) { a["channels"][0]["target"]["path"] = "rotation"; }), leftOut);
  EXPECT_EQ(spoiled([](auto& a) { a["samplers"][0]["input"] = 2; }), leftOut) << "VEC3 for times";
  EXPECT_EQ(spoiled([](auto& a) { a["samplers"][0]["input"] = 3; }), leftOut) << "times descend";
  EXPECT_EQ(spoiled([](auto& a) { a["samplers"][0]["input"] = 99; }), leftOut);
  EXPECT_EQ(spoiled([](auto& a) { a["samplers"][0]["interpolation"] = "CUBICSPLINE"; }), leftOut)
      << "no tangents";
}

std::filesystem::path sharedScene(const char* name) {
  return std::filesystem::path(TESSERA_SOURCE_DIR) / "../shared/scenes" / name;
}

TEST(SceneMotion, TheClockMoves) {
  const auto file = sharedScene("osg/clock.osgt");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
  const auto scene = loadScene(file);
  ASSERT_TRUE(scene) << scene.error().text();
  const auto player = playerOf(*scene, true);
  ASSERT_TRUE(player);
  std::size_t moves = 0;
  for (int frame = 0; frame < 60; ++frame) {
    player->advance(frame, Vec3::Zero());
    moves += player->moved().size();
    for (const std::uint32_t leaf : player->moved())
      EXPECT_TRUE(player->poseOf(leaf)->localToWorld.allFinite());
  }
  EXPECT_GT(moves, 60U);
}

}  // namespace
}  // namespace tessera::test
