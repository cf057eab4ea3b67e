// Culler: names, repeatability, depth planes, and scenes of extreme shape.
#include "common/cull/culler.h"

#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "common/hierarchy/bounds_refit.h"
#include "common/hierarchy/grid_frusta.h"
#include "tests/support/cull_scene.h"

namespace tessera::test {
namespace {

using cull::Algorithm;

constexpr std::array kAlgorithms = {Algorithm::None,      Algorithm::Naive,    Algorithm::Oh,
                                    Algorithm::Fh,        Algorithm::Adaptive, Algorithm::AdaptiveListing,
                                    Algorithm::Footprint, Algorithm::Table,    Algorithm::Auto};

Bounds pointBounds(const Vec3& p) {
  return boundsOf(std::array{p, Vec3(p + Vec3(0.01, 0, 0)), Vec3(p + Vec3(0, 0.01, 0))}, Vec3::Zero());
}

/// Looks along -z from the origin.
GridFrusta frustaLookingAhead(std::uint16_t columns, std::uint16_t rows, std::optional<double> near = {},
                              std::optional<double> far = {}) {
  WallView view = viewOf(gridWall(columns, rows, 50),
                         {.eye = Vec3(0, 0, 0), .target = Vec3(0, 0, -1), .up = Vec3(0, 1, 0), .fovYRad = {}},
                         Vec3::Zero(), 60);
  view.screens[0].near = near;
  view.screens[0].far = far;
  GridFrusta frusta(columns, rows);
  frusta.update(view.screens[0], view.tiles);
  return frusta;
}

TEST(Culler, SameInputGivesSameLists) {
  Geometry geometry(5);
  TriangleScene scene;
  for (int i = 0; i < 500; ++i)
    scene.leaves.push_back(geometry.any(Vec3(0, 0, -5), 3));
  scene.build(geometry.engine());
  const GridFrusta frusta = frustaLookingAhead(4, 4);
  for (const Candidate& candidate : allCandidates()) {
    cull::Culler first(scene.hierarchy, candidate.options), second(scene.hierarchy, candidate.options);
    const auto lists = first.cull(frusta).lists;
    EXPECT_EQ(second.cull(frusta).lists, lists) << candidate.name;
  }
}

TEST(Culler, DropsWhatIsBeyondNearAndFar) {
  ObjectHierarchyBuilder builder;
  for (const double z : {-0.5, -5.0, -50.0})
    builder.addLeaf(pointBounds({0, 0, z}));
  const ObjectHierarchy oh = builder.finish();
  const GridFrusta frusta = frustaLookingAhead(1, 1, 1, 10);
  for (const Candidate& candidate : allCandidates()) {
    cull::Culler culler(oh, candidate.options);
    const VisibleList all = {{0, 3}}, middle = {{1, 2}};
    EXPECT_EQ(culler.cull(frusta).lists[0], candidate.options.algorithm == Algorithm::None ? all : middle)
        << candidate.name;
  }
}

TEST(Culler, CountsItsTests) {
  Geometry geometry(6);
  TriangleScene scene;
  for (int i = 0; i < 300; ++i)
    scene.leaves.push_back(geometry.any(Vec3(0, 0, -5), 3));
  scene.build(geometry.engine());
  const GridFrusta frusta = frustaLookingAhead(4, 4);
  for (const Candidate& candidate : allCandidates()) {
    cull::Culler culler(scene.hierarchy, candidate.options);
    const cull::Result& result = culler.cull(frusta);
    if (candidate.options.algorithm == Algorithm::None) {
      EXPECT_EQ(result.tests.classifications(), 0U);
      EXPECT_EQ(result.pairs, 16U * 300);
      continue;
    }
    if (result.tests.classifications() == 0) {  // by footprints: blocks of boxes, not planes
      EXPECT_GE(candidate.options.algorithm, Algorithm::Footprint) << candidate.name;
      EXPECT_GT(result.tests.nodes, 0U) << candidate.name;
      continue;
    }
    // A bound against a plane is one classification, or two where a finer bound had to decide.
    const auto& tests = result.tests;
    const std::uint64_t asked = tests.primary + tests.bisection + tests.tile;
    EXPECT_GT(asked, 0U) << candidate.name;
    EXPECT_GE(tests.classifications(), asked) << candidate.name;
    EXPECT_LE(tests.classifications(), 2 * asked) << candidate.name;
    EXPECT_EQ(tests.octantSpared > 0, candidate.options.switches.octantTest && tests.primary + tests.tile > 0)
        << candidate.name;
  }
}

TEST(Culler, TakesAHierarchy100000LevelsDeep) {
  ObjectHierarchyBuilder builder;
  for (int i = 0; i < 100'000; ++i) {
    builder.openNode();
    builder.addLeaf(pointBounds({0, 0, -1 - 0.001 * i}));
  }
  builder.addLeaf(pointBounds({0, 0, 5}));
  for (int i = 0; i < 100'000; ++i)
    builder.closeNode();
  const ObjectHierarchy oh = builder.finish();
  const GridFrusta frusta = frustaLookingAhead(2, 2, 0.5, 1000);
  for (const Algorithm algorithm : kAlgorithms) {
    cull::Culler culler(oh, {.algorithm = algorithm});
    const cull::Result& result = culler.cull(frusta);
    for (const VisibleList& list : result.lists) {  // all lie about the middle, where the four tiles meet
      EXPECT_TRUE(containsLeaf(list, 0) && containsLeaf(list, 99'999)) << cull::nameOf(algorithm);
      EXPECT_EQ(containsLeaf(list, 100'000), algorithm == Algorithm::None) << cull::nameOf(algorithm);
    }
  }
}

TEST(Culler, TakesANodeWithAMillionChildren) {
  ObjectHierarchyBuilder builder;
  Geometry geometry(7);
  const std::uint32_t count = 1'000'000;
  for (std::uint32_t i = 0; i < count; ++i)
    builder.addLeaf(pointBounds(Vec3(0, 0, -50) + geometry.vector(40)));
  const ObjectHierarchy oh = builder.finish();
  const GridFrusta frusta = frustaLookingAhead(4, 4);
  cull::Culler naive(oh, {.algorithm = Algorithm::Naive, .bounds = cull::BoundsKind::Aabb});
  const auto expected = naive.cull(frusta).lists;
  for (const cull::Switches& switches : {cull::Switches{}, cull::Switches{.regroup = true}}) {
    cull::Culler adaptive(
        oh, {.algorithm = Algorithm::Adaptive, .bounds = cull::BoundsKind::Aabb, .switches = switches});
    const cull::Result& result = adaptive.cull(frusta);
    for (std::size_t tile = 0; tile < expected.size(); ++tile) {
      EXPECT_LE(leafCount(differenceOf(expected[tile], result.lists[tile])), 10U);
      EXPECT_LE(leafCount(differenceOf(result.lists[tile], expected[tile])), 10U);
    }
  }
}

TEST(Culler, OfNothingListsNothingAndOfOneLeafThatLeaf) {
  ObjectHierarchyBuilder builder;
  const ObjectHierarchy nothing = builder.finish();
  builder.addLeaf(pointBounds({0, 0, -2}));
  const ObjectHierarchy one = builder.finish();
  const GridFrusta frusta = frustaLookingAhead(2, 2);
  for (const Candidate& candidate : allCandidates()) {
    cull::Culler ofNothing(nothing, candidate.options), ofOne(one, candidate.options);
    for (const VisibleList& list : ofNothing.cull(frusta).lists)
      EXPECT_TRUE(list.empty());
    for (const VisibleList& list : ofOne.cull(frusta).lists)
      EXPECT_EQ(list, (VisibleList{{0, 1}})) << candidate.name;
  }
}

TEST(Culler, BoundsThatAreNotFiniteAreListedNotLost) {
  // Import refuses them and refitting keeps the last good place; should one ever arrive, it is drawn.
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  const GridFrusta frusta = frustaLookingAhead(2, 2);
  for (const double bad : {nan, inf, -inf}) {
    Bounds bounds = pointBounds({0, 0, 5});
    bounds.aabb.max.x() = bad;
    bounds.obb.center.y() = bad;
    bounds.sphere.center.z() = bad;
    ObjectHierarchyBuilder builder;
    builder.addLeaf(bounds);
    const ObjectHierarchy oh = builder.finish();
    for (const Candidate& candidate : allCandidates()) {
      if (std::isinf(bad) && candidate.options.switches.signTable) continue;  // a box without end has a side
      cull::Culler culler(oh, candidate.options);
      std::uint64_t pairs = culler.cull(frusta).pairs;
      if (std::isnan(bad)) {
        EXPECT_EQ(pairs, 4U) << candidate.name << " with " << bad;
      }
    }
  }
}

TEST(Culler, SeesRefittedBounds) {
  ObjectHierarchyBuilder builder;
  for (int i = 0; i < 50; ++i)
    builder.addLeaf(pointBounds({0, 0, 5.0 + i}));  // behind the eye
  ObjectHierarchy oh = builder.finish();
  const GridFrusta frusta = frustaLookingAhead(1, 1);
  for (const Candidate& candidate : allCandidates()) {
    if (candidate.options.algorithm == Algorithm::None) continue;
    BoundsRefit refit(oh, BoxFit::AxisAligned);
    cull::Culler culler(oh, candidate.options);
    ASSERT_EQ(culler.cull(frusta).pairs, 0U) << candidate.name;
    Mat4 turn = Mat4::Identity();
    turn(2, 3) = -60;
    ASSERT_EQ(refit.move(7, turn), BoundsRefit::Moved::Done);
    refit.refit();
    EXPECT_EQ(culler.cull(frusta).lists[0], (VisibleList{{7, 8}})) << candidate.name;
    turn(2, 3) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(refit.move(7, turn), BoundsRefit::Moved::KeptLastPlace);
    refit.refit();
    EXPECT_EQ(culler.cull(frusta).lists[0], (VisibleList{{7, 8}})) << candidate.name;
    ASSERT_EQ(refit.move(7, Mat4::Identity()), BoundsRefit::Moved::Done);
    refit.refit();
    EXPECT_EQ(culler.cull(frusta).pairs, 0U) << candidate.name;
  }
}

TEST(CullerOptions, NamesRoundTrip) {
  for (const Algorithm a : kAlgorithms)
    EXPECT_EQ(cull::algorithmFromName(cull::nameOf(a)), a);
  EXPECT_FALSE(cull::algorithmFromName("fastest"));
  for (const cull::BoundsKind b : {cull::BoundsKind::Sphere, cull::BoundsKind::Aabb, cull::BoundsKind::Obb,
                                   cull::BoundsKind::Hybrid, cull::BoundsKind::AabbThenObb})
    EXPECT_EQ(cull::boundsFromName(cull::nameOf(b)), b);
  EXPECT_FALSE(cull::boundsFromName("convex"));
}

TEST(CullerOptions, RefusesSwitchesThatDoNotGoTogether) {
  using cull::BoundsKind;
  EXPECT_FALSE(check(cull::Options{.bounds = BoundsKind::Obb, .switches = {.signTable = true}}));
  EXPECT_FALSE(check(cull::Options{.bounds = BoundsKind::Sphere, .switches = {.sphereFirst = true}}));
  EXPECT_FALSE(
      check(cull::Options{.bounds = BoundsKind::Aabb, .switches = {.signTable = true, .sphereFirst = true}}));
  EXPECT_FALSE(check(cull::Options{.algorithm = Algorithm::Oh, .switches = {.regroup = true}}));
  EXPECT_FALSE(check(cull::Options{.algorithm = Algorithm::Table, .bounds = BoundsKind::Sphere}));
  EXPECT_FALSE(check(cull::Options{.algorithm = Algorithm::Footprint, .switches = {.octantTest = true}}));
  EXPECT_TRUE(check(cull::Options{.algorithm = Algorithm::Auto, .bounds = BoundsKind::Sphere}));
  EXPECT_TRUE(check(cull::Options{}));
}

}  // namespace
}  // namespace tessera::test
