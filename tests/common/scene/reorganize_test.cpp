#include "common/scene/reorganize.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <osg/MatrixTransform>

#include "common/scene/extract.h"
#include "tests/common/scene/grid_mesh.h"

namespace tessera {
namespace {

constexpr std::uint32_t kSheets = 40;

/// Sheets of 1 to 7 squares aside in nested groups, all with names and places of their own. Equal input gives
/// equal scenes.
Scene makeScene(std::uint64_t maxTrianglesPerLeaf = 0) {
  osg::ref_ptr<osg::Group> root = new osg::Group, group;
  for (std::uint32_t i = 0; i < kSheets; ++i) {
    if (i % 8 == 0) root->addChild(group = new osg::Group);
    osg::ref_ptr<osg::MatrixTransform> place = new osg::MatrixTransform(
        osg::Matrixd::rotate(0.1 * i, osg::Vec3d(1, 2, 3)) *
        osg::Matrixd::translate(10.0 * (i * 7 % kSheets), 5.0 * (i % 3), 8.0 * (i % 5)));
    place->setName("sheet " + std::to_string(i));
    place->addChild(gridMesh(1 + i % 7));
    group->addChild(place);
  }
  ImportedGraph graph;
  graph.root = root;
  auto scene = extractScene(std::move(graph), {.source = "test", .maxTrianglesPerLeaf = maxTrianglesPerLeaf});
  if (!scene) {
    ADD_FAILURE() << scene.error().text();
    return {};
  }
  return std::move(*scene);
}

Bounds boundsOfLeaf(const Scene& scene, std::uint32_t leaf) {
  const std::uint32_t node = scene.hierarchy.nodeOfLeaf(leaf);
  return {scene.hierarchy.aabb(node), scene.hierarchy.obb(node), scene.hierarchy.sphere(node)};
}

std::vector<std::uint32_t> graphLeaves(const Scene& scene) {
  std::vector<std::uint32_t> all;
  for (const SceneLeaf& leaf : scene.leaves)
    all.push_back(leaf.graphLeaf);
  return all;
}

bool equal(const Bounds& a, const Bounds& b) {
  return a.aabb.min == b.aabb.min && a.aabb.max == b.aabb.max && a.obb.center == b.obb.center &&
         a.obb.halfAxes == b.obb.halfAxes && a.sphere.center == b.sphere.center &&
         a.sphere.radius == b.sphere.radius;
}

class Reorganize : public ::testing::TestWithParam<HierarchyKind> {};

TEST_P(Reorganize, KeepsEveryLeafWithAllThatItHas) {
  const Scene before = makeScene();
  ASSERT_EQ(before.leaves.size(), kSheets);
  Scene after = makeScene();
  reorganize(after, GetParam(), 0);
  ASSERT_EQ(after.leaves.size(), kSheets);
  EXPECT_EQ(after.hierarchy.leafCount(), kSheets);
  EXPECT_EQ(after.graphLeafCount, kSheets);
  EXPECT_EQ(after.triangleCount(), before.triangleCount());

  std::vector<std::uint32_t> sorted = graphLeaves(after), all(kSheets);
  std::ranges::sort(sorted);
  std::iota(all.begin(), all.end(), 0U);
  EXPECT_EQ(sorted, all) << "a permutation";

  for (std::uint32_t leaf = 0; leaf < kSheets; ++leaf) {
    const std::uint32_t from = after.leaves[leaf].graphLeaf;
    EXPECT_EQ(after.leaves[leaf].drawable, before.leaves[from].drawable) << leaf;
    EXPECT_EQ(after.leaves[leaf].state, before.leaves[from].state) << leaf;
    EXPECT_EQ(after.leaves[leaf].localToWorld, before.leaves[from].localToWorld) << leaf;
    EXPECT_EQ(after.leaves[leaf].triangles, before.leaves[from].triangles) << leaf;
    EXPECT_EQ(after.nodePathOf(leaf), before.nodePathOf(from)) << leaf;
    EXPECT_EQ(after.pathOf(leaf), before.pathOf(from)) << leaf;
  }
}

TEST_P(Reorganize, TakesTheBoundsAlong) {
  const Scene before = makeScene();
  Scene after = makeScene();
  reorganize(after, GetParam(), 0);
  for (std::uint32_t leaf = 0; leaf < kSheets; ++leaf) {
    EXPECT_TRUE(equal(boundsOfLeaf(after, leaf), boundsOfLeaf(before, after.leaves[leaf].graphLeaf))) << leaf;
    EXPECT_EQ(after.hierarchy.leaves(after.hierarchy.nodeOfLeaf(leaf)), (LeafRange{leaf, leaf + 1}));
  }
  EXPECT_TRUE(after.hierarchy.aabb(0).contains(before.hierarchy.aabb(0)));
}

TEST_P(Reorganize, GroupsSmallLeavesUpToTheLimit) {
  constexpr std::uint64_t kMost = 60;
  const Scene before = makeScene();
  Scene after = makeScene();
  reorganize(after, GetParam(), kMost);
  ASSERT_EQ(after.leaves.size(), kSheets);
  std::uint32_t terminals = 0, groups = 0;
  for (std::uint32_t node = 0; node < after.hierarchy.nodeCount(); ++node) {
    if (!after.hierarchy.isTerminal(node)) continue;
    const LeafRange range = after.hierarchy.leaves(node);
    ++terminals;
    std::uint64_t triangles = 0;
    for (std::uint32_t leaf = range.first; leaf < range.last; ++leaf) {
      triangles += after.leaves[leaf].triangles;
      EXPECT_EQ(after.hierarchy.nodeOfLeaf(leaf), node);
      EXPECT_TRUE(
          after.hierarchy.aabb(node).contains(boundsOfLeaf(before, after.leaves[leaf].graphLeaf).aabb));
    }
    if (range.last - range.first == 1) continue;
    ++groups;
    EXPECT_LE(triangles, kMost) << "node " << node;
  }
  EXPECT_LT(terminals, kSheets);
  EXPECT_GT(groups, 0U);
}

TEST_P(Reorganize, KeepsThePartsOfCutDrawables) {
  constexpr std::uint64_t kMost = 20;
  const Scene before = makeScene(kMost);
  ASSERT_GT(before.leaves.size(), kSheets);
  ASSERT_EQ(before.graphLeafCount, kSheets);
  Scene after = makeScene(kMost);
  reorganize(after, GetParam(), kMost);
  const auto parts = [](const Scene& scene) {
    std::vector<std::tuple<std::uint32_t, std::uint32_t, std::string, std::uint64_t>> all;
    for (const SceneLeaf& leaf : scene.leaves)
      all.emplace_back(leaf.graphLeaf, leaf.part, scene.assets.row(leaf.drawable).id.hex(), leaf.triangles);
    std::ranges::sort(all);
    return all;
  };
  EXPECT_EQ(parts(after), parts(before));
}

TEST_P(Reorganize, GivesTheSameEveryTime) {
  Scene a = makeScene(), b = makeScene();
  reorganize(a, GetParam(), 60);
  reorganize(b, GetParam(), 60);
  EXPECT_EQ(graphLeaves(a), graphLeaves(b));
  ASSERT_EQ(a.hierarchy.nodeCount(), b.hierarchy.nodeCount());
  for (std::uint32_t node = 0; node < a.hierarchy.nodeCount(); ++node)
    EXPECT_EQ(a.hierarchy.subtreeEnd(node), b.hierarchy.subtreeEnd(node));
}

INSTANTIATE_TEST_SUITE_P(Kinds, Reorganize,
                         ::testing::Values(HierarchyKind::Bvh, HierarchyKind::Octree,
                                           HierarchyKind::LooseOctree, HierarchyKind::Kd),
                         [](const auto& test) {
                           std::string name(nameOf(test.param));
                           std::erase(name, '-');
                           return name;
                         });

TEST(ReorganizeGraph, LeavesTheScenesOwnHierarchy) {
  const Scene before = makeScene();
  Scene after = makeScene();
  reorganize(after, HierarchyKind::Graph, 60);
  ASSERT_EQ(after.hierarchy.nodeCount(), before.hierarchy.nodeCount());
  for (std::uint32_t node = 0; node < before.hierarchy.nodeCount(); ++node)
    EXPECT_EQ(after.hierarchy.subtreeEnd(node), before.hierarchy.subtreeEnd(node));
  EXPECT_EQ(graphLeaves(after), graphLeaves(before));
}

TEST(ReorganizeOne, ASceneOfOneLeaf) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  root->addChild(gridMesh(2));
  for (const HierarchyKind kind :
       {HierarchyKind::Bvh, HierarchyKind::Octree, HierarchyKind::LooseOctree, HierarchyKind::Kd}) {
    ImportedGraph graph;
    graph.root = root;
    auto scene = extractScene(std::move(graph), {.source = "test"});
    ASSERT_TRUE(scene) << scene.error().text();
    reorganize(*scene, kind, 0);
    EXPECT_EQ(scene->hierarchy.nodeCount(), 1U) << nameOf(kind);
    EXPECT_EQ(scene->leaves.size(), 1U) << nameOf(kind);
  }
}

}  // namespace
}  // namespace tessera
