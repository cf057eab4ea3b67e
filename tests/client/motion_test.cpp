// What a tile makes of poses: it stays in the bounds that the master culls by, and goes where it should.
#include <cmath>
#include <filesystem>

#include <Eigen/LU>
#include <gtest/gtest.h>
#include <osg/Geometry>

#include "client/leaf_deformer.h"
#include "client/tile_cache.h"
#include "common/scene/load_scene.h"
#include "common/scene/scene_motion.h"
#include "proto/pose_codec.h"
#include "tests/common/scene/gltf_builder.h"

namespace tessera::test {
namespace {

/// A tile that has all of a scene.
struct WholeTile {
  explicit WholeTile(const Scene& scene) {
    proto::Leaves records;
    for (std::uint32_t id = 0; id < scene.leaves.size(); ++id) {
      const SceneLeaf& leaf = scene.leaves[id];
      addAsset(scene, leaf.drawable);
      addAsset(scene, leaf.state);
      records.leaves.push_back({.id = id,
                                .drawable = scene.assets.row(leaf.drawable).id.bytes,
                                .state = scene.assets.row(leaf.state).id.bytes,
                                .localToWorld = leaf.localToWorld,
                                .center = scene.hierarchy.sphere(scene.hierarchy.nodeOfLeaf(id)).center,
                                .radius = 1});
    }
    const Status status = cache.add(records, static_cast<std::uint32_t>(scene.leaves.size()));
    EXPECT_TRUE(status) << (status ? "" : status.error().text());
  }

  void addAsset(const Scene& scene, std::uint32_t number) {
    for (const std::uint32_t needed : scene.assets.needsOf(number))
      addAsset(scene, needed);
    const auto bytes = scene.assets.read(number);
    ASSERT_TRUE(bytes) << bytes.error().text();
    const AssetRow& row = scene.assets.row(number);
    const Status status = cache.add(proto::Assets{{{.id = row.id.bytes,
                                                    .kind = static_cast<proto::AssetKind>(row.kind),
                                                    .bytes = std::as_bytes(std::span(**bytes))}}});
    EXPECT_TRUE(status) << (status ? "" : status.error().text());
  }

  void follow(const motion::MotionPlayer& player) {
    proto::Poses poses;
    for (const std::uint32_t leaf : player.moved()) {
      const motion::LeafPose& pose = *player.poseOf(leaf);
      poses.poses.push_back({.id = leaf,
                             .form = proto::PoseForm::Matrix,
                             .localToWorld = pose.localToWorld,
                             .joints = pose.joints,
                             .weights = pose.weights});
    }
    const Status status = cache.add(poses);
    EXPECT_TRUE(status) << (status ? "" : status.error().text());
  }

  /// World coordinates of a leaf's vertices as they are drawn.
  std::vector<Vec3> verticesOf(std::uint32_t id) {
    const CachedLeaf& leaf = *cache.find(id);
    if (leaf.deformer) leaf.deformer->apply();
    std::vector<Vec3> points;
    for (const osg::Vec3& v :
         dynamic_cast<const osg::Vec3Array&>(*leaf.drawable->asGeometry()->getVertexArray()))
      points.emplace_back((leaf.localToWorld * Eigen::Vector4d(v.x(), v.y(), v.z(), 1)).head<3>());
    return points;
  }

  TileCache cache{TileCache::Options{}};
};

double outside(const Bounds& bounds, const Vec3& p) {
  double most = (bounds.aabb.min - p).cwiseMax(p - bounds.aabb.max).maxCoeff();
  most = std::max(most, (p - bounds.sphere.center).norm() - bounds.sphere.radius * (1 + 1e-12));
  Mat3 axes;
  for (int k = 0; k < 3; ++k)
    axes.col(k) = bounds.obb.halfAxes[static_cast<std::size_t>(k)];
  const Vec3 t = axes.inverse() * (p - bounds.obb.center);
  return std::max(most, t.cwiseAbs().maxCoeff() - 1 - 1e-9);
}

class RealMotion : public ::testing::TestWithParam<const char*> {};

TEST_P(RealMotion, EveryVertexLiesInItsLeafsBoundsAtAllTimes) {
  const auto file = std::filesystem::path(TESSERA_SOURCE_DIR) / "../shared/scenes" / GetParam();
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
  for (const std::uint64_t most : {0, 500}) {
    const auto scene = loadScene(file, {.maxTrianglesPerLeaf = most});
    ASSERT_TRUE(scene) << scene.error().text();
    const auto player = motionPlayerOf(*scene, true);
    ASSERT_TRUE(player) << player.error().text();
    ASSERT_TRUE(*player);
    WholeTile tile(*scene);
    std::size_t moves = 0;
    Aabb everywhere;
    for (int frame = 0; frame < 200; ++frame) {
      (*player)->advance(frame / 24.0, Vec3::Zero());
      tile.follow(**player);
      for (const std::uint32_t leaf : (*player)->moved()) {
        ++moves;
        const Bounds& bounds = (*player)->poseOf(leaf)->bounds;
        Aabb tight;
        for (const Vec3& p : tile.verticesOf(leaf)) {
          ASSERT_LE(outside(bounds, p), 0) << "leaf " << leaf << ", frame " << frame;
          tight.extend(p);
        }
        everywhere.extend(tight);
        EXPECT_LE((bounds.aabb.max - bounds.aabb.min).norm(), 4 * (tight.max - tight.min).norm() + 1e-6);
      }
    }
    EXPECT_GT(moves, 100U);
    EXPECT_LT((everywhere.max - everywhere.min).norm(), 20 * scene->sphere().radius) << "nothing flies off";
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, RealMotion,
    ::testing::Values("models/CesiumMan.glb", "models/AnimatedMorphCube/AnimatedMorphCube.gltf",
                      "models/parent_inverse_anim/06_parent-inverse-anim.gltf", "osg/clock.osgt"),
    [](const auto& test) {
      std::string name = std::filesystem::path(test.param).stem();
      std::replace_if(
          name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
      return name;
    });

/// A strip of two joints along x, the second of which turns by a quarter about z at x = 1.
GltfBuilder bentStrip() {
  GltfBuilder file;
  file.accessor(std::vector<float>{0, 0, 0, 2, 0, 0, 2, 0.5F, 0}, "VEC3", kFloat);
  file.accessor(std::vector<std::uint8_t>{0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4", kUByte);
  file.accessor(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 0.5F, 0.5F, 0, 0}, "VEC4", kFloat);
  const nlohmann::json attributes = {{"POSITION", 0}, {"JOINTS_0", 1}, {"WEIGHTS_0", 2}};
  file.addPrimitive({{"attributes", attributes}});
  file.json["nodes"][0]["translation"] = {100, 0, 0};  // of no effect on a skinned mesh
  file.json["nodes"][0]["skin"] = 0;
  file.add("nodes", {{"children", {2}}, {"translation", {0, 10, 0}}});
  file.add("nodes", {{"translation", {1, 0, 0}}});
  file.json["scenes"][0]["nodes"].push_back(1);
  std::vector<float> bind(32, 0);
  for (std::size_t joint = 0; joint < 2; ++joint) {
    for (std::size_t i = 0; i < 4; ++i)
      bind[16 * joint + 5 * i] = 1;
  }
  bind[16 + 12] = -1;  // the second joint is bound at x = 1
  nlohmann::json matrices = {
      {"bufferView", file.view(bind)}, {"componentType", kFloat}, {"count", 2}, {"type", "MAT4"}};
  file.add("skins", {{"joints", {1, 2}}, {"inverseBindMatrices", file.add("accessors", matrices)}});
  const auto h = static_cast<float>(std::sqrt(0.5));
  const int times = file.accessor(std::vector<float>{0, 1}, "SCALAR", kFloat);
  const int turns = file.accessor(std::vector<float>{0, 0, 0, 1, 0, 0, h, h}, "VEC4", kFloat);
  nlohmann::json animation;
  animation["samplers"] = {{{"input", times}, {"output", turns}, {"interpolation", "STEP"}}};
  animation["channels"] = {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}}};
  file.add("animations", animation);
  // The animation lasts longer than its turn.
  const int late = file.accessor(std::vector<float>{0, 4}, "SCALAR", kFloat);
  const int still = file.accessor(std::vector<float>{0, 10, 0, 0, 10, 0}, "VEC3", kFloat);
  file.json["animations"][0]["samplers"].push_back({{"input", late}, {"output", still}});
  file.json["animations"][0]["channels"].push_back(
      {{"sampler", 1}, {"target", {{"node", 1}, {"path", "translation"}}}});
  return file;
}

TEST(Skin, GoesWhereItsJointsTakeIt) {
  const TempFolder folder;
  const auto scene = loadScene(folder.write("strip.glb", bentStrip().glb()));
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_TRUE(scene->warnings.empty());
  const auto player = motionPlayerOf(*scene, true);
  ASSERT_TRUE(player) << player.error().text();
  ASSERT_TRUE(*player);
  WholeTile tile(*scene);
  const auto at = [&](double time) {
    (*player)->advance(time, Vec3::Zero());
    tile.follow(**player);
    return tile.verticesOf(0);
  };
  // By hand. At rest the joints are where they were bound, 10 higher.
  std::vector<Vec3> p = at(0.5);
  EXPECT_NEAR((p[0] - Vec3(0, 10, 0)).norm(), 0, 1e-5);
  EXPECT_NEAR((p[1] - Vec3(2, 10, 0)).norm(), 0, 1e-5);
  EXPECT_NEAR((p[2] - Vec3(2, 10.5, 0)).norm(), 0, 1e-5);
  // Turned: (2, 0) goes to (1, 1); (2, 0.5), half of it, to the mean of (2, 0.5) and (0.5, 1).
  p = at(2);
  EXPECT_NEAR((p[0] - Vec3(0, 10, 0)).norm(), 0, 1e-5);
  EXPECT_NEAR((p[1] - Vec3(1, 11, 0)).norm(), 0, 1e-5);
  EXPECT_NEAR((p[2] - Vec3(1.25, 10.75, 0)).norm(), 0, 1e-5);
}

TEST(Morph, AddsItsTargets) {
  GltfBuilder file = triangleFile();
  file.accessor(std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", kFloat);
  file.accessor(std::vector<float>{4, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC3", kFloat);
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 1}}, {{"POSITION", 2}}};
  const int times = file.accessor(std::vector<float>{0, 2}, "SCALAR", kFloat);
  const int weights = file.accessor(std::vector<float>{0, 1, 1, 3}, "SCALAR", kFloat);
  nlohmann::json animation;
  animation["samplers"] = {{{"input", times}, {"output", weights}}};
  animation["channels"] = {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}};
  file.add("animations", animation);
  const TempFolder folder;
  const auto scene = loadScene(folder.write("morph.glb", file.glb()));
  ASSERT_TRUE(scene) << scene.error().text();
  const auto player = motionPlayerOf(*scene, true);
  ASSERT_TRUE(player && *player);
  WholeTile tile(*scene);
  (*player)->advance(0.5, Vec3::Zero());  // weights 0.25 and 1.5
  tile.follow(**player);
  const std::vector<Vec3> p = tile.verticesOf(0);
  EXPECT_NEAR((p[0] - Vec3(6, 0, 0.25)).norm(), 0, 1e-6);
  EXPECT_NEAR((p[1] - Vec3(1, 0, 0.25)).norm(), 0, 1e-6);
  EXPECT_NEAR((p[2] - Vec3(0, 1, 0.25)).norm(), 0, 1e-6);
}

TEST(Poses, ThatDoNotFitAreRefused) {
  const TempFolder folder;
  const auto scene = loadScene(folder.write("strip.glb", bentStrip().glb()));
  ASSERT_TRUE(scene) << scene.error().text();
  WholeTile tile(*scene);
  const auto refused = [&](const proto::Pose& pose) { return !tile.cache.add(proto::Poses{{pose}}).ok(); };
  EXPECT_TRUE(refused({.id = 1, .form = proto::PoseForm::Matrix})) << "no such leaf";
  EXPECT_TRUE(refused({.id = 0, .joints = std::vector<float>(12)})) << "two joints are needed";
  EXPECT_TRUE(refused({.id = 0, .weights = {1}})) << "it has no morph targets";
  EXPECT_FALSE(refused({.id = 0, .joints = std::vector<float>(24)}));
  proto::Pose far = {.id = 0, .form = proto::PoseForm::Steps};
  far.steps.exponents = {127, 127, 127, 127};
  far.steps.counts.fill(proto::kMaxPoseSteps);
  EXPECT_FALSE(refused(far)) << "far, but a number";
  EXPECT_FALSE(refused({.id = 0, .form = proto::PoseForm::Matrix}));
}

}  // namespace
}  // namespace tessera::test
