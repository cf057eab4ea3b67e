// Moving leaves: refitted bounds keep the contract; static and moving parts apart.
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "common/cull/parted_culler.h"
#include "common/hierarchy/bounds_refit.h"
#include "common/hierarchy/grid_frusta.h"
#include "common/hierarchy/placed_frusta.h"
#include "common/hierarchy/spatial_hierarchy.h"
#include "tests/support/cull_scene.h"

namespace tessera::test {
namespace {

constexpr int kFrames = 4;

Mat4 anyMotion(Geometry& geometry, const Vec3& about, double reach) {
  Mat4 map = Mat4::Identity();
  const Mat3 turn =
      Eigen::AngleAxisd(6 * geometry.unit01(), geometry.vector(1).normalized()).toRotationMatrix();
  map.topLeftCorner<3, 3>() = turn;
  map.topRightCorner<3, 1>() = about - turn * about + geometry.vector(reach);
  return map;
}

/// Where a leaf's triangle is after a motion, rounded; and the same shrunk a little, so that what meets a
/// tile for certain can be told from what only its rounding makes meet.
std::vector<std::vector<bool>> certainVisibility(std::span<const Frustum> tiles,
                                                 const std::vector<Triangle>& leaves,
                                                 const std::vector<Mat4>& motions) {
  const auto at = [&](double shrink) {
    std::vector<Triangle> moved;
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
      Triangle t = leaves[leaf];
      const Vec3 middle = (t[0] + t[1] + t[2]) / 3;
      for (Vec3& p : t)
        p = (motions[leaf] * Vec3(middle + (1 - shrink) * (p - middle)).homogeneous()).head<3>();
      moved.push_back(t);
    }
    return exactVisibility(tiles, moved);
  };
  auto certain = at(0);
  const auto shrunk = at(1e-4);
  for (std::size_t tile = 0; tile < certain.size(); ++tile) {
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf)
      certain[tile][leaf] = certain[tile][leaf] && shrunk[tile][leaf];
  }
  return certain;
}

TEST(MovingLeaves, RefittedBoundsHoldTheContractForEveryAlgorithmAndBound) {
  for (const double offset : {0.0, 1e7}) {
    for (const BoxFit fit : {BoxFit::Pca, BoxFit::AxisAligned}) {
      Geometry geometry(41);
      const Vec3 center(offset, 0, -offset);
      TriangleScene scene;
      for (int i = 0; i < 200; ++i)
        scene.leaves.push_back(geometry.any(center, 10));
      scene.build(geometry.engine());
      BoundsRefit refit(scene.hierarchy, fit);
      std::vector<Mat4> motions(scene.leaves.size(), Mat4::Identity());
      std::vector<std::pair<std::string, cull::Culler>> cullers;
      for (const Candidate& candidate : allCandidates())
        cullers.emplace_back(candidate.name, cull::Culler(scene.hierarchy, candidate.options));
      for (int frame = 0; frame < kFrames; ++frame) {
        for (std::uint32_t leaf = 0; leaf < motions.size(); ++leaf) {
          if (geometry.below(3) != 0) continue;
          motions[leaf] = anyMotion(geometry, scene.leaves[leaf][0], 3);
          ASSERT_EQ(refit.move(leaf, motions[leaf]), BoundsRefit::Moved::Done);
        }
        refit.refit();
        WallView view =
            viewOf(gridWall(4, 3, 50),
                   {.eye = center + geometry.vector(8), .target = center, .up = Vec3(0, 1, 0), .fovYRad = {}},
                   center, 20);
        view.screens[0].near = view.screens[0].far = std::nullopt;
        for (Frustum& tile : view.tiles)
          tile.near = tile.far = std::nullopt;
        GridFrusta frusta(4, 3);
        frusta.update(view.screens[0], view.tiles);
        const auto meets = certainVisibility(view.tiles, scene.leaves, motions);
        for (auto& [name, culler] : cullers)
          ASSERT_EQ(firstDrop(culler.cull(frusta), meets), "") << name << ", frame " << frame;
      }
    }
  }
}

TEST(MovingLeaves, HybridBoundsAreTighterThanBoxesOfTheWorldWhereThingsStandStill) {
  Geometry geometry(43);
  TriangleScene scene;
  for (int i = 0; i < 3000; ++i)
    scene.leaves.push_back(geometry.any(Vec3::Zero(), 10));
  scene.build(geometry.engine());
  BoundsRefit refit(scene.hierarchy, BoxFit::AxisAligned);
  for (std::uint32_t leaf = 0; leaf < 3000; leaf += 10)
    static_cast<void>(refit.move(leaf, anyMotion(geometry, scene.leaves[leaf][0], 0.5)));
  refit.refit();
  const WallView view = viewOf(
      gridWall(8, 8, 50), {.eye = Vec3(1, 2, 9), .target = Vec3::Zero(), .up = Vec3(0, 1, 0), .fovYRad = {}},
      Vec3::Zero(), 20);
  GridFrusta frusta(8, 8);
  frusta.update(view.screens[0], view.tiles);
  const auto pairs = [&](cull::BoundsKind bounds) {
    cull::Culler culler(scene.hierarchy, {.bounds = bounds});
    return culler.cull(frusta).pairs;
  };
  EXPECT_LT(pairs(cull::BoundsKind::Hybrid), pairs(cull::BoundsKind::Aabb));
}

TEST(PartedCuller, ListsBothPartsInOneIdSpace) {
  Geometry geometry(47);
  TriangleScene fixed, moving;
  for (int i = 0; i < 150; ++i)
    fixed.leaves.push_back(geometry.any(Vec3::Zero(), 10));
  for (int i = 0; i < 50; ++i)
    moving.leaves.push_back(geometry.any(Vec3::Zero(), 10));
  fixed.build(geometry.engine());
  moving.build(geometry.engine());
  WallView view = viewOf(gridWall(3, 3, 50),
                         {.eye = Vec3(1, 2, 9), .target = Vec3::Zero(), .up = Vec3(0, 1, 0), .fovYRad = {}},
                         Vec3::Zero(), 20);
  view.screens[0].near = view.screens[0].far = std::nullopt;
  for (Frustum& tile : view.tiles)
    tile.near = tile.far = std::nullopt;
  GridFrusta frusta(3, 3);
  frusta.update(view.screens[0], view.tiles);
  // The moving part drives off as a whole: its hierarchy stays, the frusta come to it.
  Mat4 placement = Mat4::Identity();
  placement.topRightCorner<3, 1>() = Vec3(0.5, -1, 2);
  PlacedFrusta placed;
  placed.update(frusta, placement);
  std::vector<Triangle> all = fixed.leaves;
  std::vector<Mat4> motions(fixed.leaves.size(), Mat4::Identity());
  all.insert(all.end(), moving.leaves.begin(), moving.leaves.end());
  motions.resize(all.size(), placement);
  const auto meets = certainVisibility(view.tiles, all, motions);
  for (const Candidate& candidate : allCandidates()) {
    cull::PartedCuller culler(fixed.hierarchy, moving.hierarchy, candidate.options);
    ASSERT_EQ(firstDrop(culler.cull(frusta, placed), meets), "") << candidate.name;
  }
  cull::PartedCuller culler(fixed.hierarchy, moving.hierarchy, {});
  cull::Culler alone(fixed.hierarchy, {});
  EXPECT_GT(culler.cull(frusta).pairs, alone.cull(frusta).pairs);
}

TEST(PartedCuller, RemembersTheStaticPartWhileTheOtherMoves) {
  Geometry geometry(53);
  TriangleScene fixed, moving;
  for (int i = 0; i < 2000; ++i)
    fixed.leaves.push_back(geometry.any(Vec3::Zero(), 10));
  for (int i = 0; i < 20; ++i)
    moving.leaves.push_back(geometry.any(Vec3::Zero(), 10));
  fixed.build(geometry.engine());
  moving.build(geometry.engine());
  BoundsRefit refit(moving.hierarchy, BoxFit::AxisAligned);
  cull::PartedCuller culler(fixed.hierarchy, moving.hierarchy,
                            {.algorithm = cull::Algorithm::Oh, .switches = {.motionCoherence = true}});
  for (int frame = 0; frame < 3; ++frame) {
    static_cast<void>(refit.move(3, anyMotion(geometry, moving.leaves[3][0], 1)));
    refit.refit();
    const WallView view = viewOf(gridWall(3, 3, 50),
                                 {.eye = Vec3(1 + 0.01 * frame, 2, 9),
                                  .target = Vec3(0.01 * frame, 0, 0),
                                  .up = Vec3(0, 1, 0),
                                  .fovYRad = {}},
                                 Vec3::Zero(), 20);
    GridFrusta frusta(3, 3);
    frusta.update(view.screens[0], view.tiles);
    const cull::Result& result = culler.cull(frusta);
    if (frame > 0) {
      EXPECT_GT(result.tests.remembered, 500U);
    }
  }
}

// The same doubles give the same lists on every instruction set and build: these hashes hold for all of them.
TEST(Culler, ListsAreTheSameOnEveryInstructionSet) {
  std::mt19937_64 random(61);
  const auto number = [&](double size) {  // no library distribution: those may differ
    return size * (static_cast<double>(random() >> 11) * 0x1p-52 - 1);
  };
  ObjectHierarchyBuilder builder;
  std::vector<Bounds> leaves;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 at(number(10), number(10), number(10));
    const auto corner = [&] { return Vec3(at + Vec3(number(0.5), number(0.5), number(0.5))); };
    leaves.push_back(boundsOf(std::array{corner(), corner(), corner(), corner()}, Vec3::Zero()));
  }
  const std::vector<std::uint64_t> triangles(leaves.size(), 1);
  const SpatialHierarchy built = buildSpatialHierarchy(HierarchyKind::Bvh, leaves, triangles, 0);
  std::uint64_t hash = 0;
  for (const Candidate& candidate : allCandidates()) {
    cull::Culler culler(built.hierarchy, candidate.options);
    for (int frame = 0; frame < 3; ++frame) {
      // An image rectangle of exact doubles: sine and cosine may differ between libraries.
      Frustum wall;
      wall.eye = Vec3(1, 2, 14 - frame);
      std::vector<Frustum> tiles;
      const auto corner = [&](int column, int row) {
        return Vec3(wall.eye + Vec3(0.25 * column - 0.5, 0.5 - 0.25 * row, -1));
      };
      wall.corners = {corner(0, 4), corner(4, 4), corner(4, 0), corner(0, 0)};
      for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) {
          Frustum tile = wall;
          tile.corners = {corner(column, row + 1), corner(column + 1, row + 1), corner(column + 1, row),
                          corner(column, row)};
          tiles.push_back(tile);
        }
      }
      GridFrusta frusta(4, 4);
      frusta.update(wall, tiles);
      hash = cull::hashOf(culler.cull(frusta).lists, hash);
    }
  }
  EXPECT_EQ(hash, 2388435862944012107u);
}

}  // namespace
}  // namespace tessera::test
