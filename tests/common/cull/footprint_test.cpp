// Footprints on grids: the same lists by every way, what changes, reuse, outlines, limits.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "common/cull/culler.h"
#include "common/cull/footprint/box_blocks.h"
#include "common/cull/footprint/kernels.h"
#include "common/hierarchy/bounds_refit.h"
#include "common/hierarchy/grid_coordinates.h"
#include "common/hierarchy/grid_frusta.h"
#include "common/hierarchy/placed_frusta.h"
#include "tests/support/cull_scene.h"

namespace tessera::test {
namespace {

using cull::Algorithm;
using cull::Reuse;

/// Boxes of all sizes in clusters, in the order of a scene graph.
ObjectHierarchy clusters(int count, std::uint64_t seed) {
  Geometry geometry(seed);
  ObjectHierarchyBuilder builder;
  Vec3 at = Vec3::Zero();
  for (int i = 0; i < count; ++i) {
    if (i % 40 == 0) at = geometry.vector(5);
    const Vec3 middle = at + geometry.vector(0.5);
    const double size = std::pow(10.0, -2.5 * geometry.unit01());
    const auto corner = [&] { return Vec3(middle + geometry.vector(size)); };
    builder.addLeaf(boundsOf(std::array{corner(), corner(), corner(), corner()}, Vec3::Zero()));
  }
  return builder.finish();
}

/// A camera inside the clusters: frame after frame by a small step, at times by a jump.
class Flight {
 public:
  explicit Flight(std::uint64_t seed) : geometry_(seed) {}
  WallView next(int columns, int rows, double stepDeg, bool jumps) {
    if (jumps) {
      pose_.eye = geometry_.vector(4);
      forward_ = geometry_.vector(1).normalized();
    }
    const double step = stepDeg * 0.01745;
    pose_.eye += step * geometry_.vector(1);
    forward_ = (forward_ + step * geometry_.vector(1)).normalized();
    pose_.target = pose_.eye + forward_;
    return viewOf(gridWall(columns, rows, 60), pose_, Vec3::Zero(), 6);
  }

 private:
  Geometry geometry_;
  CameraPose pose_{.eye = Vec3(0, 0, 3), .target = {}, .up = Vec3(0, 1, 0), .fovYRad = {}};
  Vec3 forward_{0, 0, -1};
};

GridFrusta frustaOf(const WallView& view, int columns, int rows) {
  GridFrusta frusta(static_cast<std::uint16_t>(columns), static_cast<std::uint16_t>(rows));
  frusta.update(view.screens[0], view.tiles);
  return frusta;
}

cull::Options optionsOf(Algorithm algorithm, Reuse reuse, unsigned threads = 1) {
  return {.algorithm = algorithm, .switches = {.coherent = reuse}, .threads = threads};
}

/// Cullers by every way on the same flight; the share of leaves that reuse looked at while it was slow.
double lookedAlongAFlight(const ObjectHierarchy& oh, int columns, int rows, bool cutsDepth = false) {
  Flight flight(4);
  std::vector<cull::Culler> cullers;
  for (const cull::Options& options :
       {optionsOf(Algorithm::Table, Reuse::Never), optionsOf(Algorithm::Table, Reuse::Always),
        optionsOf(Algorithm::Table, Reuse::Measured), optionsOf(Algorithm::Footprint, Reuse::Never),
        optionsOf(Algorithm::Auto, Reuse::Measured)})
    cullers.emplace_back(oh, options);
  std::uint64_t looked = 0, all = 0;
  for (int frame = 0; frame < 180; ++frame) {
    // Very slow, slow, and too fast for anything to be kept.
    const double stepDeg = frame < 60 ? 0.003 : frame < 120 ? 0.1 : 4;
    WallView view = flight.next(columns, rows, stepDeg, frame % 60 == 0);
    if (cutsDepth) {
      view.screens[0].near = 1.5;
      view.screens[0].far = 4;
    }
    const GridFrusta frusta = frustaOf(view, columns, rows);
    const std::vector<VisibleList> expected = cullers[0].cull(frusta).lists;
    for (std::size_t i = 1; i < cullers.size(); ++i) {
      const cull::Result& result = cullers[i].cull(frusta);
      if (result.lists != expected) {
        ADD_FAILURE() << "culler " << i << " in frame " << frame;
        return 1;
      }
      if (i == 1 && frame < 60) {
        looked += result.tests.nodes;
        all += oh.leafCount();
      }
    }
  }
  return static_cast<double>(looked) / static_cast<double>(all);
}

TEST(Footprints, TreeTableAndReuseGiveTheSameListsAlongAFlight) {
  const ObjectHierarchy oh = clusters(6000, 3);
  EXPECT_LT(lookedAlongAFlight(oh, 7, 5), 0.25);  // reuse did take place
  EXPECT_LT(lookedAlongAFlight(oh, 24, 24), 0.5);
  EXPECT_LT(lookedAlongAFlight(oh, 5, 4, true), 0.25);  // leaves come and go at near and far, too
}

// Where a node is no larger than its leaves, and all of them touch a tile's border within rounding, the node
// must still hold them: its error has to be the larger one.
TEST(Footprints, NodesHoldLeavesThatTouchABorder) {
  Flight flight(20);
  Geometry geometry(21);
  for (int round = 0; round < 6; ++round) {
    const WallView view = flight.next(12, 9, 1, true);
    const GridFrusta frusta = frustaOf(view, 12, 9);
    ObjectHierarchyBuilder builder;
    for (int group = 0; group < 1500; ++group) {
      const Triangle triangle = geometry.hard(view.tiles);
      // Off the border by about the error of a float.
      const Vec3 shift = geometry.vector(2e-7 * (triangle[0] - view.screens[0].eye).norm());
      const std::array points = {Vec3(triangle[0] + shift)};
      for (std::size_t i = 0; i < cull::kLanes; ++i)
        builder.addLeaf(boundsOf(points, Vec3::Zero()));
    }
    const ObjectHierarchy oh = builder.finish();
    const auto optionsWith = [](Algorithm algorithm, Reuse reuse) {
      cull::Options options = optionsOf(algorithm, reuse);
      options.bounds = cull::BoundsKind::Aabb;
      return options;
    };
    // Certified frames look at the leaves themselves.
    cull::Culler leaves(oh, optionsWith(Algorithm::Table, Reuse::Always));
    cull::Culler nodes(oh, optionsWith(Algorithm::Table, Reuse::Never));
    cull::Culler tree(oh, optionsWith(Algorithm::Footprint, Reuse::Never));
    const std::vector<VisibleList> expected = leaves.cull(frusta).lists;
    ASSERT_EQ(nodes.cull(frusta).lists, expected);
    ASSERT_EQ(tree.cull(frusta).lists, expected);
  }
}

TEST(Footprints, MeasuredReuseStopsWhereItDoesNotPay) {
  const ObjectHierarchy oh = clusters(6000, 3);
  Flight flight(5);
  cull::Culler always(oh, optionsOf(Algorithm::Table, Reuse::Always));
  cull::Culler measured(oh, optionsOf(Algorithm::Table, Reuse::Measured));
  std::uint64_t alwaysLooked = 0, measuredLooked = 0;
  for (int frame = 0; frame < 80; ++frame) {
    const GridFrusta frusta = frustaOf(flight.next(8, 8, 10, false), 8, 8);
    alwaysLooked += always.cullChanges(frusta).tests.nodes;
    measuredLooked += measured.cullChanges(frusta).tests.nodes;
  }
  EXPECT_LT(measuredLooked, alwaysLooked);

  // And takes place where it does.
  Flight slow(5);
  cull::Culler never(oh, optionsOf(Algorithm::Table, Reuse::Never)),
      spares(oh, optionsOf(Algorithm::Table, Reuse::Measured));
  std::uint64_t neverLooked = 0, sparesLooked = 0;
  for (int frame = 0; frame < 80; ++frame) {
    const GridFrusta frusta = frustaOf(slow.next(4, 4, 0.003, false), 4, 4);
    neverLooked += never.cullChanges(frusta).tests.nodes;
    sparesLooked += spares.cullChanges(frusta).tests.nodes;
  }
  EXPECT_LT(sparesLooked, neverLooked / 2);
}

TEST(Footprints, AnyNumberOfThreadsGivesTheSameLists) {
  const ObjectHierarchy oh = clusters(70'000, 6);
  Flight flight(7);
  for (const Algorithm algorithm : {Algorithm::Table, Algorithm::Footprint}) {
    std::vector<cull::Culler> cullers;
    for (const unsigned threads : {1U, 2U, 3U, 8U})
      cullers.emplace_back(oh, optionsOf(algorithm, Reuse::Always, threads));
    for (int frame = 0; frame < 6; ++frame) {
      const GridFrusta frusta = frustaOf(flight.next(6, 4, 0.2, frame % 3 == 0), 6, 4);
      const std::vector<VisibleList> expected = cullers[0].cull(frusta).lists;
      ASSERT_GT(leafCount(expected[8]) + leafCount(expected[15]), 0U);
      for (cull::Culler& culler : cullers)
        ASSERT_EQ(culler.cull(frusta).lists, expected) << cull::nameOf(algorithm) << ", frame " << frame;
      std::vector<VisibleList> toggled = cullers[0].cullChanges(frusta).toggled;
      for (const VisibleList& list : toggled)
        EXPECT_TRUE(list.empty());  // the same frame again
    }
  }
}

TEST(Footprints, ChangesAddUpToTheLists) {
  const ObjectHierarchy oh = clusters(3000, 8);
  for (const Algorithm algorithm :
       {Algorithm::Table, Algorithm::Footprint, Algorithm::Auto, Algorithm::Adaptive, Algorithm::Oh}) {
    Flight flight(9);
    cull::Culler changing(oh, optionsOf(algorithm, Reuse::Always)),
        whole(oh, optionsOf(algorithm, Reuse::Never));
    std::vector<VisibleList> lists;
    Geometry chance(10);
    int columns = 4, rows = 6;
    for (int frame = 0; frame < 60; ++frame) {
      // The same number of tiles in another grid, another number, and back.
      if (frame == 20) std::swap(columns, rows);
      if (frame == 30) columns = 3;
      if (frame == 40) columns = 6, rows = 4;
      const GridFrusta frusta = frustaOf(flight.next(columns, rows, 0.5, frame % 15 == 0), columns, rows);
      const std::vector<VisibleList> expected = whole.cull(frusta).lists;
      if (chance.below(4) == 0) {  // any call counts as the one before
        lists = changing.cull(frusta).lists;
        ASSERT_EQ(lists, expected);
        continue;
      }
      const cull::Changes& changes = changing.cullChanges(frusta);
      if (lists.size() != expected.size()) lists.assign(expected.size(), {});
      ASSERT_EQ(changes.toggled.size(), expected.size());
      std::uint64_t pairs = 0;
      for (std::size_t tile = 0; tile < expected.size(); ++tile) {
        ASSERT_TRUE(isCanonical(changes.toggled[tile], oh.leafCount()));
        VisibleList now;
        symmetricDifferenceInto(lists[tile], changes.toggled[tile], now);
        lists[tile] = now;
        ASSERT_EQ(now, expected[tile]) << cull::nameOf(algorithm) << ", frame " << frame << ", tile " << tile;
        ASSERT_EQ(changes.leafCounts[tile], leafCount(now));
        changing.listOf(static_cast<std::uint32_t>(tile), now);
        ASSERT_EQ(now, expected[tile]);
        pairs += leafCount(now);
      }
      ASSERT_EQ(changes.pairs, pairs);
    }
  }
}

TEST(Footprints, OutlinesListLessThanRectanglesAndNoMoreThanPlanes) {
  const ObjectHierarchy oh = clusters(4000, 12);
  Flight flight(13);
  cull::Culler naive(oh, {.algorithm = Algorithm::Naive});
  cull::Culler rectangles(oh, {.algorithm = Algorithm::Table, .switches = {.refine = false}});
  cull::Culler outlines(oh, {.algorithm = Algorithm::Table});
  std::uint64_t planePairs = 0, rectanglePairs = 0, outlinePairs = 0;
  for (int frame = 0; frame < 10; ++frame) {
    const GridFrusta frusta = frustaOf(flight.next(16, 16, 1, true), 16, 16);
    const std::vector<VisibleList> wide = rectangles.cull(frusta).lists;
    const cull::Result& narrow = outlines.cull(frusta);
    for (std::size_t tile = 0; tile < wide.size(); ++tile)
      ASSERT_TRUE(differenceOf(narrow.lists[tile], wide[tile]).empty());
    outlinePairs += narrow.pairs;
    rectanglePairs += rectangles.cull(frusta).pairs;
    planePairs += naive.cull(frusta).pairs;
  }
  EXPECT_LT(outlinePairs, 0.97 * static_cast<double>(rectanglePairs));
  // Rectangles are what the tiles' side planes tell, and a little less for boxes that reach behind the eye.
  EXPECT_LE(rectanglePairs, planePairs);
  EXPECT_GT(static_cast<double>(rectanglePairs), 0.95 * static_cast<double>(planePairs));
}

TEST(Footprints, SeeRefittedBounds) {
  ObjectHierarchy oh = clusters(5000, 14);
  BoundsRefit refit(oh, BoxFit::AxisAligned);
  Flight flight(15);
  Geometry geometry(16);
  std::vector<cull::Culler> kept;
  kept.emplace_back(oh, optionsOf(Algorithm::Table, Reuse::Always));
  kept.emplace_back(oh, optionsOf(Algorithm::Footprint, Reuse::Never));
  for (int frame = 0; frame < 20; ++frame) {
    Mat4 shift = Mat4::Identity();
    shift.topRightCorner<3, 1>() = geometry.vector(2);
    for (int i = 0; i < 1 + frame * 20; ++i)
      ASSERT_EQ(refit.move(static_cast<std::uint32_t>(geometry.below(5000)), shift),
                BoundsRefit::Moved::Done);
    refit.refit();
    const GridFrusta frusta = frustaOf(flight.next(5, 5, 0.05, false), 5, 5);
    cull::Culler fresh(oh, optionsOf(Algorithm::Table, Reuse::Never));
    const std::vector<VisibleList> expected = fresh.cull(frusta).lists;
    for (cull::Culler& culler : kept)
      ASSERT_EQ(culler.cull(frusta).lists, expected) << "frame " << frame;
  }
}

TEST(Footprints, GiveWayToPlanesWhereTheyCannotTell) {
  const ObjectHierarchy oh = clusters(300, 17);
  Flight flight(18);
  const auto pickedOn = [&](const FrustumHierarchy& frusta, Algorithm algorithm,
                            cull::BoundsKind bounds = cull::BoundsKind::Obb) {
    cull::Culler culler(oh, {.algorithm = algorithm, .bounds = bounds});
    culler.cull(frusta);
    return culler.picked();
  };
  const WallView view = flight.next(4, 4, 0, true);
  const GridFrusta grid = frustaOf(view, 4, 4);
  EXPECT_EQ(pickedOn(grid, Algorithm::Table), Algorithm::Table);
  EXPECT_EQ(pickedOn(grid, Algorithm::Footprint), Algorithm::Footprint);
  EXPECT_EQ(pickedOn(grid, Algorithm::Auto), Algorithm::Footprint);
  cull::Culler changing(oh, {.algorithm = Algorithm::Auto});
  changing.cullChanges(grid);
  EXPECT_EQ(changing.picked(), Algorithm::Table);
  EXPECT_FALSE(changing.readsPlanes(grid));
  EXPECT_EQ(pickedOn(grid, Algorithm::Auto, cull::BoundsKind::Sphere), Algorithm::Adaptive);
  EXPECT_EQ(pickedOn(frustaOf(flight.next(130, 1, 0, false), 130, 1), Algorithm::Auto), Algorithm::Adaptive);
  PlacedFrusta placed;
  placed.update(grid, Mat4::Identity());
  EXPECT_EQ(pickedOn(placed, Algorithm::Table), Algorithm::Adaptive);
  // A telescope: floats do not tell its tiles apart.
  const WallView narrow = viewOf(
      gridWall(4, 4, 0.002),
      {.eye = Vec3(0, 0, 9), .target = Vec3::Zero(), .up = Vec3(0, 1, 0), .fovYRad = {}}, Vec3::Zero(), 6);
  EXPECT_EQ(pickedOn(frustaOf(narrow, 4, 4), Algorithm::Auto), Algorithm::Adaptive);
  // A wall with one tile moved is no uniform grid.
  WallView broken = view;
  broken.tiles[5].corners[0] += 0.1 * (broken.tiles[5].corners[1] - broken.tiles[5].corners[0]);
  EXPECT_EQ(pickedOn(frustaOf(broken, 4, 4), Algorithm::Auto), Algorithm::Adaptive);
}

// Where a point is seen is in the tile that exact arithmetic says, within the borders that were measured.
TEST(GridCoordinates, PlacePointsInTheTilesThatSeeThem) {
  Geometry geometry(19);
  std::uint64_t seen = 0;
  for (const double offset : {0.0, 1e5, 1e9, 1e12}) {
    const Vec3 center(offset, -offset / 3, offset / 7);
    const WallView view =
        viewOf(gridWall(9, 6, 40),
               {.eye = center, .target = center + geometry.vector(10), .up = Vec3(0, 1, 0), .fovYRad = {}},
               center, 20);
    const auto grid = GridCoordinates::of(view.screens[0], view.tiles, 9, 6);
    ASSERT_TRUE(grid) << offset;
    EXPECT_LT(grid->columnHigh - grid->columnLow, 1.01);
    for (std::size_t t = 0; t < view.tiles.size(); ++t) {
      const ExactFrustum tile(view.tiles[t]);
      for (int i = 0; i < 60; ++i) {
        const Vec3 p = geometry.hard({&view.tiles[t], 1})[0];
        if (!tile.meets({p, p, p})) continue;
        ++seen;
        const auto along = [&](const std::array<float, 3>& f) {
          const Vec3 d = p - grid->eye;
          return static_cast<long double>(f[0]) * d.x() + static_cast<long double>(f[1]) * d.y() +
                 static_cast<long double>(f[2]) * d.z();
        };
        const long double column = along(grid->column) / along(grid->depth) - static_cast<long double>(t % 9);
        const long double row = along(grid->row) / along(grid->depth) - static_cast<long double>(t / 9);
        const double slack = 1e-9;
        EXPECT_GE(column, grid->columnLow - slack);
        EXPECT_LE(column, grid->columnHigh + slack);
        EXPECT_GE(row, grid->rowLow - slack);
        EXPECT_LE(row, grid->rowHigh + slack);
      }
    }
  }
  EXPECT_GT(seen, 500U);
}

TEST(GridCoordinates, RefuseWhatIsNoGridSeenTheRightWayRound) {
  WallView view = viewOf(gridWall(3, 2, 40),
                         {.eye = Vec3(0, 0, 5), .target = Vec3::Zero(), .up = Vec3(0, 1, 0), .fovYRad = {}},
                         Vec3::Zero(), 2);
  EXPECT_TRUE(GridCoordinates::of(view.screens[0], view.tiles, 3, 2));
  WallView mirrored = view;
  for (Frustum* f : {&mirrored.screens[0], &mirrored.tiles[0], &mirrored.tiles[1], &mirrored.tiles[2],
                     &mirrored.tiles[3], &mirrored.tiles[4], &mirrored.tiles[5]})
    std::swap(f->corners[0], f->corners[1]), std::swap(f->corners[2], f->corners[3]);
  EXPECT_FALSE(GridCoordinates::of(mirrored.screens[0], mirrored.tiles, 3, 2));
  WallView swapped = view;
  std::swap(swapped.tiles[0], swapped.tiles[4]);
  EXPECT_FALSE(GridCoordinates::of(swapped.screens[0], swapped.tiles, 3, 2));
  WallView flat = view;
  flat.screens[0].corners.fill(Vec3(0, 0, 1));
  EXPECT_FALSE(GridCoordinates::of(flat.screens[0], flat.tiles, 3, 2));
  WallView nan = view;
  nan.tiles[3].corners[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(GridCoordinates::of(nan.screens[0], nan.tiles, 3, 2));
}

TEST(InstructionSets, CanBeForcedAndAreAllHere) {
  const auto names = cull::instructionSets();
  ASSERT_FALSE(names.empty());
  EXPECT_EQ(names.back(), "scalar");
  for (const std::string_view name : names) {
    ASSERT_TRUE(cull::chooseInstructionSet(name));
    EXPECT_EQ(cull::instructionSet(), name);
  }
  EXPECT_FALSE(cull::chooseInstructionSet("mmx"));
  EXPECT_EQ(cull::instructionSet(), "scalar");  // as it was
  ASSERT_TRUE(cull::chooseInstructionSet(""));
  EXPECT_EQ(cull::instructionSet(), names.front());
}

// Different instruction sets are different code: their kernels are at other addresses.
TEST(InstructionSets, TakeEffect) {
  std::vector<decltype(cull::Kernels::leaves)> seen;
  for (const std::string_view name : cull::instructionSets()) {
    ASSERT_TRUE(cull::chooseInstructionSet(name));
    EXPECT_EQ(std::find(seen.begin(), seen.end(), cull::kernels().leaves), seen.end()) << name;
    seen.push_back(cull::kernels().leaves);
  }
  ASSERT_TRUE(cull::chooseInstructionSet(""));
}

}  // namespace
}  // namespace tessera::test
