#include "common/cull/culler.h"

#include <array>
#include <cmath>
#include <numbers>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/geometry/exact_frustum.h"
#include "common/wall/wall.h"

namespace tessera::cull {
namespace {

using Triangle = std::array<Vec3, 3>;

Wall gridWall(int columns, int rows, double fovYDeg) {
  Wall wall;
  wall.columns = columns;
  wall.rows = rows;
  wall.tileWidthPx = 64;
  wall.tileHeightPx = 48;
  wall.fovYRad = fovYDeg * std::numbers::pi / 180;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      wall.tiles.push_back(
          {.name = "r" + std::to_string(r) + "c" + std::to_string(c), .column = c, .row = r});
    }
  }
  return wall;
}

/// A scene of single triangles, in a tree of random shape.
struct TestScene {
  std::vector<Triangle> leaves;
  ObjectHierarchy hierarchy;

  void build(std::mt19937_64& random) {
    ObjectHierarchyBuilder builder;
    int open = 0;
    for (const Triangle& t : leaves) {
      while (open > 0 && random() % 3 == 0)
        builder.closeNode(), --open;
      while (random() % 3 == 0)
        builder.openNode(), ++open;
      builder.addLeaf(boundsOf(t, Vec3::Zero()));
    }
    while (open-- > 0)
      builder.closeNode();
    hierarchy = builder.finish();
  }
};

struct Setting {
  const char* name;
  int columns, rows;
  double fovYDeg, offset, size;

  friend void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.name; }
};

class CullerContract : public ::testing::TestWithParam<Setting> {
 protected:
  /// Triangles that are hard to judge: corners on the tiles' edges, rays and planes, others by an ulp.
  Triangle hardTriangle(const WallView& view) {
    const Frustum& tile = view.tiles[random_() % view.tiles.size()];
    const std::size_t i = random_() % 4;
    const Vec3& a = tile.corners[i];
    const Vec3& b = tile.corners[(i + 1) % 4];
    const double depth = std::pow(10.0, -3 * unit01_(random_));
    const Vec3 onPlane = tile.eye + depth * (a + unit01_(random_) * (b - a) - tile.eye);
    Triangle triangle = {onPlane, onPlane, onPlane};
    const double spread = std::pow(10.0, -8 * unit01_(random_)) * (onPlane - tile.eye).norm();
    for (std::size_t k = 1; k < 3; ++k)
      triangle[k] += spread * Vec3(unit_(random_), unit_(random_), unit_(random_));
    for (Vec3& v : triangle) {
      for (double& x : v) {
        if (random_() % 4 == 0) x = std::nextafter(x, random_() % 2 ? 1e300 : -1e300);
      }
    }
    return triangle;
  }
  Triangle anyTriangle(const Vec3& center, double size) {
    const auto point = [&](double s) {
      return Vec3(s * unit_(random_), s * unit_(random_), s * unit_(random_));
    };
    const Vec3 middle = center + point(size);
    const double small = size * std::pow(10.0, -3 * unit01_(random_));
    return {middle + point(small), middle + point(small), middle + point(small)};
  }

  std::mt19937_64 random_{11};
  std::uniform_real_distribution<double> unit_{-1, 1}, unit01_{0, 1};
};

TEST_P(CullerContract, NeverDropsALeafThatMeetsATile) {
  const Setting& s = GetParam();
  const Wall wall = gridWall(s.columns, s.rows, s.fovYDeg);
  const Vec3 center(s.offset, s.offset / 3, -s.offset / 7);
  for (int round = 0; round < 4; ++round) {
    const Vec3 eye = center + s.size * Vec3(unit_(random_), unit_(random_), unit_(random_));
    const Vec3 target = eye + s.size * Vec3(unit_(random_), 0.3 * unit_(random_), unit_(random_));
    WallView view =
        viewOf(wall, {.eye = eye, .target = target, .up = Vec3(0, 1, 0), .fovYRad = {}}, center, 2 * s.size);
    view.wall.near = view.wall.far = std::nullopt;
    TestScene scene;
    for (int i = 0; i < 60; ++i)
      scene.leaves.push_back(anyTriangle(center, s.size));
    for (int i = 0; i < 60; ++i)
      scene.leaves.push_back(hardTriangle(view));
    scene.build(random_);
    FrustumHierarchy frusta(static_cast<std::uint16_t>(s.columns), static_cast<std::uint16_t>(s.rows));
    frusta.update(view.wall, view.tiles);

    std::vector<std::vector<bool>> meets(view.tiles.size(), std::vector<bool>(scene.leaves.size()));
    for (std::size_t tile = 0; tile < view.tiles.size(); ++tile) {
      Frustum sides = view.tiles[tile];
      sides.near = sides.far = std::nullopt;
      const ExactFrustum exact(sides);
      for (std::size_t leaf = 0; leaf < scene.leaves.size(); ++leaf)
        meets[tile][leaf] = exact.meets(scene.leaves[leaf]);
    }
    for (const Algorithm algorithm :
         {Algorithm::None, Algorithm::Naive, Algorithm::Oh, Algorithm::Adaptive}) {
      for (const BoundsKind bounds : {BoundsKind::Sphere, BoundsKind::Aabb, BoundsKind::Obb}) {
        Culler culler(scene.hierarchy, {.algorithm = algorithm, .bounds = bounds});
        const Result& result = culler.cull(frusta);
        for (std::size_t tile = 0; tile < view.tiles.size(); ++tile) {
          ASSERT_TRUE(isCanonical(result.lists[tile], scene.hierarchy.leafCount()));
          for (std::uint32_t leaf = 0; leaf < scene.leaves.size(); ++leaf) {
            ASSERT_TRUE(!meets[tile][leaf] || containsLeaf(result.lists[tile], leaf))
                << s.name << ": " << nameOf(algorithm) << " with " << nameOf(bounds) << " drops leaf " << leaf
                << " from tile " << tile << " in round " << round;
          }
        }
      }
    }
  }
}

TEST_P(CullerContract, HierarchiesAddHardlyAnyLeafToNaiveCulling) {
  const Setting& s = GetParam();
  const Wall wall = gridWall(s.columns, s.rows, s.fovYDeg);
  const Vec3 center(s.offset, s.offset / 3, -s.offset / 7);
  const WallView view = viewOf(
      wall,
      {.eye = center + s.size * Vec3(0.1, 0.2, 1.5), .target = center, .up = Vec3(0, 1, 0), .fovYRad = {}},
      center, 2 * s.size);
  TestScene scene;
  for (int i = 0; i < 2000; ++i)
    scene.leaves.push_back(anyTriangle(center, s.size));
  scene.build(random_);
  FrustumHierarchy frusta(static_cast<std::uint16_t>(s.columns), static_cast<std::uint16_t>(s.rows));
  frusta.update(view.wall, view.tiles);
  std::array<std::uint64_t, 3> pairs{};
  std::size_t i = 0;
  for (const Algorithm algorithm : {Algorithm::Naive, Algorithm::Oh, Algorithm::Adaptive}) {
    Culler culler(scene.hierarchy, {.algorithm = algorithm, .bounds = BoundsKind::Obb});
    pairs[i++] = culler.cull(frusta).pairs;
  }
  const double naive = static_cast<double>(pairs[0]);
  EXPECT_GT(pairs[0], 0U);
  // Parents that are fully inside, and the margins of shared planes, may add a little; bisection planes
  // further up are more planes to be outside of, so the adaptive method may also list less.
  for (const std::uint64_t hierarchical : {pairs[1], pairs[2]}) {
    EXPECT_LE(static_cast<double>(hierarchical), 1.002 * naive + 2);
    EXPECT_GE(static_cast<double>(hierarchical), 0.98 * naive - 2);
  }
}

TEST_P(CullerContract, UnionOverTilesIsTheWallsOwnList) {
  const Setting& s = GetParam();
  const Wall wall = gridWall(s.columns, s.rows, s.fovYDeg);
  const Vec3 center(s.offset, s.offset / 3, -s.offset / 7);
  const CameraPose pose{
      .eye = center + s.size * Vec3(0.3, 0.1, 0.4), .target = center, .up = Vec3(0, 1, 0), .fovYRad = {}};
  TestScene scene;
  for (int i = 0; i < 2000; ++i)
    scene.leaves.push_back(anyTriangle(center, s.size));
  scene.build(random_);
  const auto listsOf = [&](const Wall& w) {
    const WallView view = viewOf(w, pose, center, 2 * s.size);
    FrustumHierarchy frusta(static_cast<std::uint16_t>(w.columns), static_cast<std::uint16_t>(w.rows));
    frusta.update(view.wall, view.tiles);
    Culler culler(scene.hierarchy, {});
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

INSTANTIATE_TEST_SUITE_P(
    Settings, CullerContract,
    ::testing::Values(Setting{"one", 1, 1, 50, 0, 10}, Setting{"plain3x2", 3, 2, 50, 0, 10},
                      Setting{"plain4x4", 4, 4, 60, 1e4, 100}, Setting{"wide", 16, 1, 120, 0, 10},
                      Setting{"tall", 1, 16, 170, 0, 10}, Setting{"narrow", 4, 4, 0.01, 0, 10},
                      Setting{"far1e6", 4, 4, 50, 1e6, 1}, Setting{"far1e8", 4, 4, 50, 1e8, 1},
                      Setting{"far1e12", 3, 3, 50, 1e12, 100}, Setting{"tiny", 3, 3, 50, 0, 1e-9},
                      Setting{"huge", 3, 3, 50, 0, 1e9}, Setting{"grid8x8", 8, 8, 50, 0, 10}),
    [](const auto& setting) { return setting.param.name; });

TEST(Culler, SameInputGivesSameLists) {
  const Wall wall = gridWall(4, 4, 50);
  std::mt19937_64 random(5);
  TestScene scene;
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 500; ++i) {
    const Vec3 p(unit(random), unit(random), unit(random));
    scene.leaves.push_back({p, p + Vec3(0.1, 0, 0), p + Vec3(0, 0.1, 0)});
  }
  scene.build(random);
  const WallView view =
      viewOf(wall, {.eye = Vec3(0, 0, 2), .target = Vec3(0, 0, 0), .up = Vec3(0, 1, 0), .fovYRad = {}},
             Vec3::Zero(), 2);
  FrustumHierarchy frusta(4, 4);
  frusta.update(view.wall, view.tiles);
  Culler first(scene.hierarchy, {}), second(scene.hierarchy, {});
  const auto lists = first.cull(frusta).lists;
  EXPECT_EQ(first.cull(frusta).lists, lists);
  EXPECT_EQ(second.cull(frusta).lists, lists);
}

TEST(Culler, DropsWhatIsBeyondNearAndFar) {
  const Wall wall = gridWall(1, 1, 50);
  TestScene scene;
  for (const double z : {-0.5, -5.0, -50.0}) {
    scene.leaves.push_back({Vec3(0, 0, z), Vec3(0.01, 0, z), Vec3(0, 0.01, z)});
  }
  std::mt19937_64 random(1);
  scene.build(random);
  WallView view =
      viewOf(wall, {.eye = Vec3(0, 0, 0), .target = Vec3(0, 0, -1), .up = Vec3(0, 1, 0), .fovYRad = {}},
             Vec3::Zero(), 60);
  view.wall.near = 1;
  view.wall.far = 10;
  FrustumHierarchy frusta(1, 1);
  frusta.update(view.wall, view.tiles);
  for (const Algorithm algorithm : {Algorithm::Naive, Algorithm::Oh, Algorithm::Adaptive}) {
    Culler culler(scene.hierarchy, {.algorithm = algorithm});
    EXPECT_EQ(culler.cull(frusta).lists[0], (VisibleList{{1, 2}})) << nameOf(algorithm);
  }
}

TEST(Culler, NamesRoundTrip) {
  for (const Algorithm a : {Algorithm::None, Algorithm::Naive, Algorithm::Oh, Algorithm::Adaptive}) {
    EXPECT_EQ(algorithmFromName(nameOf(a)), a);
  }
  EXPECT_FALSE(algorithmFromName("fastest"));
  EXPECT_EQ(boundsFromName("aabb"), BoundsKind::Aabb);
  EXPECT_FALSE(boundsFromName("convex"));
}

}  // namespace
}  // namespace tessera::cull
