// Leaves that are absent are in no list, and all others in those that they would be in.
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/cull/parted_culler.h"
#include "common/hierarchy/grid_frusta.h"
#include "tests/support/cull_scene.h"

namespace tessera::test {
namespace {

constexpr std::uint16_t kColumns = 4, kRows = 3;

TriangleScene sceneOf(Geometry& geometry, int leaves) {
  TriangleScene scene;
  for (int i = 0; i < leaves; ++i)
    scene.leaves.push_back(geometry.any(Vec3::Zero(), 10));
  scene.build(geometry.engine());
  return scene;
}

WallView viewFrom(Geometry& geometry) {
  WallView view =
      viewOf(gridWall(kColumns, kRows, 60),
             {.eye = geometry.vector(12), .target = Vec3::Zero(), .up = Vec3(0, 1, 0), .fovYRad = {}},
             Vec3::Zero(), 20);
  view.screens[0].near = view.screens[0].far = std::nullopt;
  for (Frustum& tile : view.tiles)
    tile.near = tile.far = std::nullopt;
  return view;
}

GridFrusta frustaOf(const WallView& view) {
  GridFrusta frusta(kColumns, kRows);
  frusta.update(view.screens[0], view.tiles);
  return frusta;
}

/// None, some leaves, some whole subtrees, or all.
VisibleList anyAbsent(Geometry& geometry, const ObjectHierarchy& oh) {
  VisibleList list;
  switch (geometry.below(5)) {
    case 0:
      return {};
    case 1:
      return {{0, oh.leafCount()}};
    case 2:
      for (std::uint32_t leaf = 0; leaf < oh.leafCount(); ++leaf) {
        if (geometry.below(3) == 0) appendRange(list, {leaf, leaf + 1});
      }
      return list;
    default:
      for (int i = 0; i < 5; ++i)
        list = unionOf(list, {oh.leaves(static_cast<std::uint32_t>(geometry.below(oh.nodeCount())))});
      return list;
  }
}

std::vector<VisibleList> without(std::vector<VisibleList> lists, const VisibleList& absent) {
  for (VisibleList& list : lists)
    list = differenceOf(list, absent);
  return lists;
}

TEST(AbsentLeaves, AreInNoListOfAnyAlgorithmAndLeaveTheOthersAsTheyAre) {
  Geometry geometry(71);
  TriangleScene scene = sceneOf(geometry, 400);
  const ObjectHierarchy whole = scene.hierarchy;
  std::vector<std::pair<std::string, cull::Culler>> cullers, wholeCullers;
  for (const Candidate& candidate : allCandidates()) {
    cullers.emplace_back(candidate.name, cull::Culler(scene.hierarchy, candidate.options));
    wholeCullers.emplace_back(candidate.name, cull::Culler(whole, candidate.options));
  }
  cull::Culler none(scene.hierarchy, {.algorithm = cull::Algorithm::None});
  std::uint64_t taken = 0;
  for (int frame = 0; frame < 12; ++frame) {
    const VisibleList absent = anyAbsent(geometry, whole);
    scene.hierarchy.setAbsentLeaves(absent);
    const GridFrusta frusta = frustaOf(viewFrom(geometry));
    for (std::size_t i = 0; i < cullers.size(); ++i) {
      const cull::Result& result = cullers[i].second.cull(frusta);
      const cull::Result& all = wholeCullers[i].second.cull(frusta);
      ASSERT_EQ(result.lists, without(all.lists, absent)) << cullers[i].first << ", frame " << frame;
      std::uint64_t pairs = 0;
      for (const VisibleList& list : result.lists)
        pairs += leafCount(list);
      ASSERT_EQ(result.pairs, pairs) << cullers[i].first;
      taken += all.pairs - result.pairs;
    }
    for (const VisibleList& list : none.cull(frusta).lists)
      ASSERT_EQ(list, differenceOf({{0, whole.leafCount()}}, absent));
  }
  EXPECT_GT(taken, 10'000U);
}

TEST(AbsentLeaves, ComeAndGoInTheChanges) {
  Geometry geometry(73);
  TriangleScene scene = sceneOf(geometry, 300);
  const ObjectHierarchy whole = scene.hierarchy;
  struct Follower {
    std::string name;
    cull::Culler culler, reference;
    std::vector<VisibleList> lists;
  };
  std::vector<Follower> followers;
  for (const Candidate& candidate : allCandidates()) {
    followers.push_back({candidate.name, cull::Culler(scene.hierarchy, candidate.options),
                         cull::Culler(whole, candidate.options), std::vector<VisibleList>(kColumns * kRows)});
  }
  for (int frame = 0; frame < 30; ++frame) {
    // A standing camera at times, so that tables are certified and reused.
    static GridFrusta frusta = frustaOf(viewFrom(geometry));
    if (geometry.below(2) == 0) frusta = frustaOf(viewFrom(geometry));
    const VisibleList absent = anyAbsent(geometry, whole);
    scene.hierarchy.setAbsentLeaves(absent);
    for (Follower& follower : followers) {
      const cull::Changes& changes = follower.culler.cullChanges(frusta);
      const std::vector<VisibleList> expected = without(follower.reference.cull(frusta).lists, absent);
      std::uint64_t pairs = 0;
      for (std::uint32_t tile = 0; tile < kColumns * kRows; ++tile) {
        VisibleList now, listed;
        symmetricDifferenceInto(follower.lists[tile], changes.toggled[tile], now);
        ASSERT_EQ(now, expected[tile]) << follower.name << ", frame " << frame << ", tile " << tile;
        ASSERT_EQ(changes.leafCounts[tile], leafCount(now)) << follower.name;
        follower.culler.listOf(tile, listed);
        ASSERT_EQ(listed, now) << follower.name;
        pairs += leafCount(now);
        follower.lists[tile] = now;
      }
      ASSERT_EQ(changes.pairs, pairs) << follower.name;
    }
  }
}

TEST(AbsentLeaves, ContractHoldsForThoseThatAreThere) {
  for (const double offset : {0.0, 1e7}) {
    Geometry geometry(79);
    const Vec3 center(offset, offset / 3, -offset);
    TriangleScene scene;
    for (int i = 0; i < 150; ++i)
      scene.leaves.push_back(geometry.any(center, 10));
    scene.build(geometry.engine());
    for (int round = 0; round < 3; ++round) {
      WallView view =
          viewOf(gridWall(kColumns, kRows, 60),
                 {.eye = center + geometry.vector(8), .target = center, .up = Vec3(0, 1, 0), .fovYRad = {}},
                 center, 20);
      view.screens[0].near = view.screens[0].far = std::nullopt;
      for (Frustum& tile : view.tiles)
        tile.near = tile.far = std::nullopt;
      auto meets = exactVisibility(view.tiles, scene.leaves);
      const VisibleList absent = anyAbsent(geometry, scene.hierarchy);
      scene.hierarchy.setAbsentLeaves(absent);
      for (std::vector<bool>& tile : meets)
        forEachLeaf(absent, [&](std::uint32_t leaf) { tile[leaf] = false; });
      for (const Candidate& candidate : allCandidates()) {
        cull::Culler culler(scene.hierarchy, candidate.options);
        ASSERT_EQ(firstDrop(culler.cull(frustaOf(view)), meets), "") << candidate.name;
      }
    }
  }
}

TEST(AbsentLeaves, OfBothPartsOfAPartedScene) {
  Geometry geometry(83);
  TriangleScene fixed = sceneOf(geometry, 100), moving = sceneOf(geometry, 60);
  const GridFrusta frusta = frustaOf(viewFrom(geometry));
  for (const Candidate& candidate : allCandidates()) {
    fixed.hierarchy.setAbsentLeaves({});
    moving.hierarchy.setAbsentLeaves({});
    cull::PartedCuller culler(fixed.hierarchy, moving.hierarchy, candidate.options);
    const std::vector<VisibleList> all = culler.cull(frusta).lists;
    fixed.hierarchy.setAbsentLeaves({{10, 50}});
    moving.hierarchy.setAbsentLeaves({{0, 1}, {20, 60}});
    ASSERT_EQ(culler.cull(frusta).lists, without(all, {{10, 50}, {100, 101}, {120, 160}})) << candidate.name;
  }
}

}  // namespace
}  // namespace tessera::test
