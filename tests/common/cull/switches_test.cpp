// The switches do what they are for, and no more.
#include <vector>

#include <gtest/gtest.h>

#include "common/hierarchy/grid_frusta.h"
#include "common/hierarchy/spatial_hierarchy.h"
#include "tests/support/cull_scene.h"

namespace tessera::test {
namespace {

using cull::Algorithm;
using cull::BoundsKind;

class Switches : public ::testing::Test {
 protected:
  Switches() {
    Geometry geometry(3);
    TriangleScene scene;
    for (int i = 0; i < 4000; ++i)
      scene.leaves.push_back(geometry.any(Vec3::Zero(), 10));
    bounds = scene.bounds();
    const std::vector<std::uint64_t> triangles(bounds.size(), 1);
    oh = buildSpatialHierarchy(HierarchyKind::Bvh, bounds, triangles, 0).hierarchy;
  }
  [[nodiscard]] static WallView viewFrom(const Vec3& eye, const Vec3& target, int columns = 4, int rows = 4) {
    return viewOf(gridWall(columns, rows, 50),
                  {.eye = eye, .target = target, .up = Vec3(0, 1, 0), .fovYRad = {}}, Vec3::Zero(), 20);
  }
  static GridFrusta frustaOf(const WallView& view, std::uint16_t columns = 4, std::uint16_t rows = 4) {
    GridFrusta frusta(columns, rows);
    frusta.update(view.screens[0], view.tiles);
    return frusta;
  }
  cull::Result cullWith(const GridFrusta& frusta, const cull::Options& options) const {
    cull::Culler culler(oh, options);
    return culler.cull(frusta);
  }

  std::vector<Bounds> bounds;
  ObjectHierarchy oh;
};

TEST_F(Switches, PlaneMaskingSparesTestsAndChangesNoList) {
  const GridFrusta frusta = frustaOf(viewFrom({1, 2, 8}, {0, 0, 0}));
  for (const Algorithm algorithm : {Algorithm::Oh, Algorithm::Adaptive}) {
    const cull::Result with = cullWith(frusta, {.algorithm = algorithm, .bounds = BoundsKind::Aabb});
    const cull::Result without = cullWith(
        frusta, {.algorithm = algorithm, .bounds = BoundsKind::Aabb, .switches = {.planeMasking = false}});
    EXPECT_EQ(with.lists, without.lists);
    EXPECT_LT(with.tests.classifications(), without.tests.classifications());
  }
}

TEST_F(Switches, PlaneCoherencySparesTestsFromTheSecondFrameOn) {
  const GridFrusta frusta = frustaOf(viewFrom({1, 2, 8}, {0, 0, 0}));
  cull::Culler culler(oh, {.algorithm = Algorithm::Oh, .switches = {.planeCoherency = true}});
  const cull::Result first = culler.cull(frusta);
  const cull::Result& second = culler.cull(frusta);
  EXPECT_EQ(first.lists, second.lists);
  EXPECT_LT(second.tests.classifications(), first.tests.classifications());
}

TEST_F(Switches, OctantTestSparesTestsAndChangesNoList) {
  const GridFrusta frusta = frustaOf(viewFrom({1, 2, 8}, {0, 0, 0}));
  const cull::Result without = cullWith(frusta, {.algorithm = Algorithm::Oh});
  const cull::Result with = cullWith(frusta, {.algorithm = Algorithm::Oh, .switches = {.octantTest = true}});
  EXPECT_EQ(with.lists, without.lists);
  EXPECT_LT(with.tests.classifications(), without.tests.classifications());
  EXPECT_GT(with.tests.octantSpared, 0U);
}

// The mistake that the term project confesses: a plane that the octant test left out may cut the node, so a
// child may lie outside of it, and must still be tested.
TEST_F(Switches, MaskingThePlanesThatTheOctantTestLeftOutListsWhatNoTileSees) {
  const GridFrusta frusta = frustaOf(viewFrom({1, 2, 8}, {0, 0, 0}));
  const cull::Result right = cullWith(frusta, {.algorithm = Algorithm::Oh, .switches = {.octantTest = true}});
  const cull::Result wrong =
      cullWith(frusta, {.algorithm = Algorithm::Oh, .switches = {.octantTest = true, .octantPitfall = true}});
  std::uint64_t added = 0;
  for (std::size_t tile = 0; tile < right.lists.size(); ++tile) {
    EXPECT_TRUE(differenceOf(right.lists[tile], wrong.lists[tile]).empty());  // excess, never a drop
    added += leafCount(differenceOf(wrong.lists[tile], right.lists[tile]));
  }
  EXPECT_GT(static_cast<double>(added), 0.05 * static_cast<double>(right.pairs));
}

TEST_F(Switches, SignTableAgreesWithCentreAndExtents) {
  const GridFrusta frusta = frustaOf(viewFrom({1, 2, 8}, {0, 0, 0}));
  for (const Algorithm algorithm : {Algorithm::Naive, Algorithm::Oh, Algorithm::Fh, Algorithm::Adaptive}) {
    EXPECT_EQ(cullWith(frusta,
                       {.algorithm = algorithm, .bounds = BoundsKind::Aabb, .switches = {.signTable = true}})
                  .lists,
              cullWith(frusta, {.algorithm = algorithm, .bounds = BoundsKind::Aabb}).lists);
  }
}

TEST_F(Switches, SphereFirstSparesBoxTestsAndTightens) {
  const GridFrusta frusta = frustaOf(viewFrom({1, 2, 8}, {0, 0, 0}));
  const cull::Result with = cullWith(frusta, {.algorithm = Algorithm::Oh, .switches = {.sphereFirst = true}});
  const cull::Result without = cullWith(frusta, {.algorithm = Algorithm::Oh});
  EXPECT_LT(with.tests.obb, without.tests.obb);
  EXPECT_LE(with.pairs, without.pairs);
}

TEST_F(Switches, AabbThenObbListsNoMoreThanEither) {
  const GridFrusta frusta = frustaOf(viewFrom({1, 2, 8}, {0, 0, 0}));
  const auto pairs = [&](BoundsKind kind) { return cullWith(frusta, {.bounds = kind}).pairs; };
  EXPECT_LE(pairs(BoundsKind::AabbThenObb), pairs(BoundsKind::Aabb));
  EXPECT_LE(pairs(BoundsKind::AabbThenObb), pairs(BoundsKind::Obb));
  EXPECT_EQ(pairs(BoundsKind::Hybrid), pairs(BoundsKind::Obb));  // nothing moves
}

TEST_F(Switches, MotionCoherenceSparesMostRejectionsOfAnEyeThatOnlyMovesOrOnlyTurns) {
  for (const bool moves : {true, false}) {
    cull::Culler plain(oh, {.algorithm = Algorithm::Oh});
    cull::Culler coherent(oh, {.algorithm = Algorithm::Oh, .switches = {.motionCoherence = true}});
    for (int frame = 0; frame < 20; ++frame) {
      const double step = 0.002 * frame;
      const Vec3 eye = Vec3(1, 2, 8) + (moves ? step : 0.0) * Vec3(1, 0, -1);
      const Vec3 forward = Vec3(-1, -2, -8) + (moves ? 0.0 : step) * Vec3(1, 0, 0);
      const GridFrusta frusta = frustaOf(viewFrom(eye, eye + forward));
      const cull::Result& result = coherent.cull(frusta);
      const cull::Result& expected = plain.cull(frusta);
      ASSERT_EQ(result.lists, expected.lists) << "frame " << frame;
      if (frame > 0) {
        EXPECT_LT(result.tests.classifications(), expected.tests.classifications());
        EXPECT_GT(result.tests.remembered, 1000U);
      }
    }
  }
}

TEST_F(Switches, RegroupingChangesNoListOfAFlatScene) {
  ObjectHierarchyBuilder builder;
  for (const Bounds& leaf : bounds)
    builder.addLeaf(leaf);
  const ObjectHierarchy flat = builder.finish();
  const GridFrusta frusta = frustaOf(viewFrom({1, 2, 8}, {0, 0, 0}));
  cull::Culler plain(flat, {}), regrouped(flat, {.switches = {.regroup = true}});
  EXPECT_EQ(regrouped.cull(frusta).lists, plain.cull(frusta).lists);
  EXPECT_GT(regrouped.cull(frusta).tests.groups, 10U);
}

TEST_F(Switches, FirstLevelSparesTheTilesWhatTheWallDoesNotSee) {
  const GridFrusta frusta = frustaOf(viewFrom({0, 0, 2}, {5, 0, 4}));
  for (const Algorithm algorithm : {Algorithm::Naive, Algorithm::Oh, Algorithm::Fh}) {
    const cull::Result with = cullWith(frusta, {.algorithm = algorithm});
    const cull::Result without =
        cullWith(frusta, {.algorithm = algorithm, .switches = {.firstLevel = false}});
    EXPECT_LT(with.tests.classifications(), without.tests.classifications()) << cull::nameOf(algorithm);
    EXPECT_LE(with.pairs, without.pairs) << cull::nameOf(algorithm);
  }
}

TEST_F(Switches, TheListingListsMuchMoreThanTheText) {
  const GridFrusta frusta = frustaOf(viewFrom({1, 2, 30}, {0, 0, 0}));
  const std::uint64_t text = cullWith(frusta, {.algorithm = Algorithm::Adaptive}).pairs;
  const std::uint64_t listing = cullWith(frusta, {.algorithm = Algorithm::AdaptiveListing}).pairs;
  EXPECT_GT(static_cast<double>(listing), 1.2 * static_cast<double>(text));
}

}  // namespace
}  // namespace tessera::test
