// The contract: no algorithm, bound, switch, hierarchy or arrangement of frusta drops a leaf with a triangle
// that meets a tile's closed frustum, judged in exact arithmetic.
#include <array>
#include <cmath>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/cull/footprint/kernels.h"
#include "common/hierarchy/grid_frusta.h"
#include "common/hierarchy/spatial_hierarchy.h"
#include "tests/support/cull_scene.h"

namespace tessera::test {
namespace {

struct Setting {
  const char* name;
  int columns, rows;
  double fovYDeg, offset, size;
  int leaves = 60, rounds = 2;
  double nearOverFar = 0;  ///< 0: neither; negative: near alone, far is infinite

  friend void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.name; }
};

class CullerContract : public ::testing::TestWithParam<Setting> {
 protected:
  const Setting& s = GetParam();
  Wall wall = gridWall(s.columns, s.rows, s.fovYDeg);
  Vec3 center{s.offset, s.offset / 3, -s.offset / 7};
  Geometry geometry{11};

  WallView randomView() {
    const Vec3 eye = center + geometry.vector(s.size);
    const Vec3 target = eye + geometry.vector(s.size).cwiseProduct(Vec3(1, 0.3, 1));
    if (s.nearOverFar != 0) {
      wall.near = std::abs(s.nearOverFar) * 4 * s.size;
      wall.far = 4 * s.size;
    }
    WallView view =
        viewOf(wall, {.eye = eye, .target = target, .up = Vec3(0, 1, 0), .fovYRad = {}}, center, 2 * s.size);
    const auto cut = [this](Frustum& frustum) {
      if (s.nearOverFar == 0) frustum.near = std::nullopt;
      if (s.nearOverFar <= 0) frustum.far = std::nullopt;
    };
    cut(view.screens[0]);
    for (Frustum& tile : view.tiles)
      cut(tile);
    return view;
  }
  TriangleScene sceneFor(const WallView& view) {
    TriangleScene scene;
    for (int i = 0; i < s.leaves; ++i)
      scene.leaves.push_back(geometry.any(center, s.size));
    for (int i = 0; i < s.leaves; ++i)
      scene.leaves.push_back(geometry.hard(view.tiles));
    for (int i = 0; i < s.leaves / 4; ++i)
      scene.leaves.push_back(geometry.aboutTheEye(view.screens[0].eye, s.size));
    scene.build(geometry.engine());
    return scene;
  }
  GridFrusta frustaOf(const WallView& view, PlaneSource source = PlaneSource::Corners) const {
    GridFrusta frusta(static_cast<std::uint16_t>(s.columns), static_cast<std::uint16_t>(s.rows), source);
    frusta.update(view.screens[0], view.tiles);
    return frusta;
  }
};

TEST_P(CullerContract, HoldsForEveryAlgorithmBoundAndSwitch) {
  for (int round = 0; round < s.rounds; ++round) {
    const WallView view = randomView();
    const TriangleScene scene = sceneFor(view);
    const auto meets = exactVisibility(view.tiles, scene.leaves);
    const GridFrusta frusta = frustaOf(view);
    for (const Candidate& candidate : allCandidates()) {
      cull::Culler culler(scene.hierarchy, candidate.options);
      ASSERT_EQ(firstDrop(culler.cull(frusta), meets), "") << candidate.name << " in round " << round;
      // Once more: what is remembered must not hide anything either.
      ASSERT_EQ(firstDrop(culler.cull(frusta), meets), "") << candidate.name << ", again, round " << round;
    }
  }
}

TEST_P(CullerContract, FootprintsAreTheSameAndHoldOnEveryInstructionSet) {
  using cull::Algorithm, cull::Reuse;
  const WallView view = randomView();
  const TriangleScene scene = sceneFor(view);
  const auto meets = exactVisibility(view.tiles, scene.leaves);
  const GridFrusta frusta = frustaOf(view);
  for (const bool refine : {false, true}) {
    std::vector<VisibleList> expected;
    for (const std::string_view name : cull::instructionSets()) {
      ASSERT_TRUE(cull::chooseInstructionSet(name));
      for (const Algorithm algorithm : {Algorithm::Table, Algorithm::Footprint}) {
        cull::Culler culler(scene.hierarchy, {.algorithm = algorithm, .switches = {.refine = refine}});
        const cull::Result& result = culler.cull(frusta);
        ASSERT_EQ(firstDrop(result, meets), "") << name;
        if (expected.empty()) expected = result.lists;
        ASSERT_EQ(result.lists, expected) << name << ", " << cull::nameOf(culler.picked());
      }
    }
  }
  ASSERT_TRUE(cull::chooseInstructionSet(""));
}

TEST_P(CullerContract, HoldsWithPlanesFromTheMatrix) {
  const WallView view = randomView();
  const TriangleScene scene = sceneFor(view);
  const auto meets = exactVisibility(view.tiles, scene.leaves);
  const GridFrusta frusta = frustaOf(view, PlaneSource::Matrix);
  for (const cull::Algorithm algorithm :
       {cull::Algorithm::Naive, cull::Algorithm::Oh, cull::Algorithm::Adaptive}) {
    cull::Culler culler(scene.hierarchy, {.algorithm = algorithm});
    ASSERT_EQ(firstDrop(culler.cull(frusta), meets), "") << cull::nameOf(algorithm);
  }
}

TEST_P(CullerContract, HoldsOnEveryHierarchy) {
  const WallView view = randomView();
  const TriangleScene scene = sceneFor(view);
  const auto meets = exactVisibility(view.tiles, scene.leaves);
  const GridFrusta frusta = frustaOf(view);
  const std::vector<std::uint64_t> triangles(scene.leaves.size(), 1);
  for (const HierarchyKind kind :
       {HierarchyKind::Bvh, HierarchyKind::Octree, HierarchyKind::LooseOctree, HierarchyKind::Kd}) {
    for (const std::uint64_t most : {0, 5}) {
      const SpatialHierarchy built = buildSpatialHierarchy(kind, scene.bounds(), triangles, most);
      for (const Candidate& candidate : allCandidates()) {
        cull::Culler culler(built.hierarchy, candidate.options);
        ASSERT_EQ(firstDrop(culler.cull(frusta), meets, built.order), "")
            << candidate.name << " on " << nameOf(kind) << " with MTPL " << most;
      }
    }
  }
}

TEST_P(CullerContract, HoldsAlongAFlightWithWhatIsRemembered) {
  const WallView first = randomView();
  const TriangleScene scene = sceneFor(first);
  const std::array flags = {cull::Switches{.motionCoherence = true},
                            cull::Switches{.planeCoherency = true, .motionCoherence = true}};
  std::vector<cull::Culler> cullers;
  for (const cull::Switches& switches : flags) {
    for (const cull::Algorithm algorithm :
         {cull::Algorithm::Naive, cull::Algorithm::Oh, cull::Algorithm::Fh, cull::Algorithm::Adaptive}) {
      cullers.emplace_back(scene.hierarchy, cull::Options{.algorithm = algorithm, .switches = switches});
    }
  }
  cullers.emplace_back(scene.hierarchy, cull::Options{.algorithm = cull::Algorithm::Table,
                                                      .switches = {.coherent = cull::Reuse::Always}});
  cull::Culler table(scene.hierarchy,
                     {.algorithm = cull::Algorithm::Table, .switches = {.coherent = cull::Reuse::Never}});
  std::uint64_t remembered = 0;
  CameraPose pose{.eye = first.screens[0].eye, .target = {}, .up = Vec3(0, 1, 0), .fovYRad = {}};
  Vec3 forward = geometry.vector(1).normalized();
  for (int frame = 0; frame < 12; ++frame) {
    // First it only moves, then it only turns, then it does both, and at last it jumps.
    const double step = frame < 4 || frame >= 8 ? 0.01 * s.size : 0, turn = frame >= 4 ? 0.02 : 0;
    if (frame == 11) pose.eye += geometry.vector(s.size);
    pose.eye += step * Vec3(1, 0.2, -0.5);
    forward = (forward + turn * Vec3(0.3, 0, 1)).normalized();
    pose.target = pose.eye + s.size * forward;
    WallView view = viewOf(wall, pose, center, 2 * s.size);
    for (Frustum* frustum : {&view.screens[0]})
      frustum->near = frustum->far = std::nullopt;
    for (Frustum& tile : view.tiles)
      tile.near = tile.far = std::nullopt;
    const auto meets = exactVisibility(view.tiles, scene.leaves);
    const GridFrusta frusta = frustaOf(view);
    for (cull::Culler& culler : cullers) {
      const cull::Result& result = culler.cull(frusta);
      ASSERT_EQ(firstDrop(result, meets), "") << "frame " << frame;
      remembered += result.tests.remembered;
    }
    // Certified reuse gives not only conservative lists, but the same.
    ASSERT_EQ(table.cull(frusta).lists, cullers.back().cull(frusta).lists) << "frame " << frame;
  }
  if (s.offset < 1e7 && s.size > 1e-300) {  // else rounding is as large as the scene
    EXPECT_GT(remembered, 0U);
  }
}

TEST_P(CullerContract, HierarchiesAddHardlyAnyLeafToNaiveCulling) {
  const WallView view = viewOf(
      wall,
      {.eye = center + s.size * Vec3(0.1, 0.2, 1.5), .target = center, .up = Vec3(0, 1, 0), .fovYRad = {}},
      center, 2 * s.size);
  TriangleScene scene;
  for (int i = 0; i < 2000; ++i)
    scene.leaves.push_back(geometry.any(center, s.size));
  scene.build(geometry.engine());
  const GridFrusta frusta = frustaOf(view);
  const auto pairs = [&](cull::Algorithm algorithm, const cull::Switches& switches) {
    cull::Culler culler(scene.hierarchy, {.algorithm = algorithm, .switches = switches});
    return static_cast<double>(culler.cull(frusta).pairs);
  };
  const double naive = pairs(cull::Algorithm::Naive, {});
  EXPECT_GT(naive, 0);
  // Parents that are fully inside, and the margins of shared planes, may add a little; bisection planes
  // further up, and boxes of parents, are more planes to be outside of, so hierarchies may also list less.
  for (const double other :
       {pairs(cull::Algorithm::Oh, {}), pairs(cull::Algorithm::Fh, {}), pairs(cull::Algorithm::Adaptive, {}),
        pairs(cull::Algorithm::Oh, {.octantTest = true}), pairs(cull::Algorithm::Oh, {.planeMasking = false}),
        pairs(cull::Algorithm::Adaptive, {.regroup = true, .regroupFrom = 2}),
        pairs(cull::Algorithm::Oh, {.planeCoherency = true, .motionCoherence = true})}) {
    EXPECT_LE(other, 1.002 * naive + 2);
    EXPECT_GE(other, 0.97 * naive - 2);
  }
}

TEST_P(CullerContract, UnionOverTilesIsTheWallsOwnList) {
  const CameraPose pose{
      .eye = center + s.size * Vec3(0.3, 0.1, 0.4), .target = center, .up = Vec3(0, 1, 0), .fovYRad = {}};
  TriangleScene scene;
  for (int i = 0; i < 2000; ++i)
    scene.leaves.push_back(geometry.any(center, s.size));
  scene.build(geometry.engine());
  const auto listsOf = [&](const Wall& w) {
    const WallView view = viewOf(w, pose, center, 2 * s.size);
    GridFrusta frusta(static_cast<std::uint16_t>(w.screens[0].columns),
                      static_cast<std::uint16_t>(w.screens[0].rows));
    frusta.update(view.screens[0], view.tiles);
    cull::Culler culler(scene.hierarchy, {});
    return culler.cull(frusta).lists;
  };
  VisibleList sum;
  for (const VisibleList& list : listsOf(wall))
    sum = unionOf(sum, list);
  const VisibleList whole = listsOf(wall.untiled())[0];
  const std::uint64_t differing = leafCount(differenceOf(sum, whole)) + leafCount(differenceOf(whole, sum));
  EXPECT_LE(differing, leafCount(whole) / 200 + 2)
      << leafCount(whole) << " on the wall, " << leafCount(sum) << " on its tiles";
}

// Around 250 leaves make the cases of one setting; fewer where there are thousands of tiles.
INSTANTIATE_TEST_SUITE_P(
    Settings, CullerContract,
    ::testing::Values(Setting{"one", 1, 1, 50, 0, 10}, Setting{"plain3x2", 3, 2, 50, 0, 10},
                      Setting{"far1e4", 4, 4, 60, 1e4, 100}, Setting{"wide16x1", 16, 1, 120, 0, 10},
                      Setting{"tall1x16", 1, 16, 170, 0, 10}, Setting{"row64x1", 64, 1, 50, 0, 10},
                      Setting{"column1x64", 1, 64, 50, 0, 10}, Setting{"narrow0p01", 4, 4, 0.01, 0, 10},
                      Setting{"narrowest", 3, 3, 0.001, 0, 10}, Setting{"widest", 3, 3, 179.9, 0, 10},
                      Setting{"far1e6", 4, 4, 50, 1e6, 0.05}, Setting{"far1e7", 4, 4, 50, 1e7, 1},
                      Setting{"far1e8", 4, 4, 50, 1e8, 1}, Setting{"far1e12", 3, 3, 50, 1e12, 100},
                      Setting{"tiny", 3, 3, 50, 0, 1e-9}, Setting{"huge", 3, 3, 50, 0, 1e9},
                      Setting{"hugeFar", 3, 3, 50, 1e12, 1e9}, Setting{"denormal", 2, 2, 50, 0, 1e-306},
                      Setting{"depths1e12", 3, 3, 50, 0, 10, 60, 2, 1e-12},
                      Setting{"depthsEven", 3, 3, 50, 1e4, 10, 60, 2, 0.3},
                      Setting{"farInfinite", 3, 3, 50, 0, 10, 60, 2, -1e-3},
                      Setting{"grid8x8", 8, 8, 50, 0, 10}, Setting{"grid16x16", 16, 16, 50, 0, 10, 30, 1},
                      Setting{"grid64x64", 64, 64, 50, 0, 10, 6, 1}),
    [](const auto& setting) { return setting.param.name; });

}  // namespace
}  // namespace tessera::test
