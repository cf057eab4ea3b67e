#include "common/hierarchy/object_hierarchy.h"

#include <vector>

#include <gtest/gtest.h>

namespace tessera {
namespace {

Bounds boxAt(double x) {
  const std::vector<Vec3> points = {{x, 0, 0}, {x + 1, 1, 1}, {x, 1, 0.5}};
  return boundsOf(points, Vec3::Zero());
}

/// ((0 1) 2 (3 (4 5)))
ObjectHierarchy sample() {
  ObjectHierarchyBuilder builder;
  builder.openNode();
  builder.addLeaf(boxAt(0));
  builder.addLeaf(boxAt(2));
  builder.closeNode();
  builder.addLeaf(boxAt(4));
  builder.openNode();
  builder.addLeaf(boxAt(6));
  builder.openNode();
  builder.addLeaf(boxAt(8));
  builder.addLeaf(boxAt(10));
  builder.closeNode();
  builder.closeNode();
  return builder.finish();
}

TEST(ObjectHierarchy, IsInPreOrderWithContiguousLeaves) {
  const ObjectHierarchy oh = sample();
  ASSERT_EQ(oh.nodeCount(), 10U);
  ASSERT_EQ(oh.leafCount(), 6U);
  EXPECT_EQ(oh.leaves(0), (LeafRange{0, 6}));
  EXPECT_EQ(oh.leaves(1), (LeafRange{0, 2}));
  EXPECT_EQ(oh.subtreeEnd(1), 4U);
  EXPECT_TRUE(oh.isTerminal(4));
  EXPECT_EQ(oh.leaves(5), (LeafRange{3, 6}));
  EXPECT_EQ(oh.leaves(7), (LeafRange{4, 6}));
  EXPECT_EQ(oh.parent(0), ObjectHierarchy::kNoParent);
  EXPECT_EQ(oh.parent(7), 5U);
  EXPECT_EQ(oh.parent(9), 7U);
  EXPECT_EQ(oh.depth(), 3U);
  EXPECT_DOUBLE_EQ(oh.meanBranching(), 9.0 / 4);
  for (std::uint32_t leaf = 0; leaf < 6; ++leaf)
    EXPECT_EQ(oh.leaves(oh.nodeOfLeaf(leaf)), (LeafRange{leaf, leaf + 1}));
}

TEST(ObjectHierarchy, EveryBoundHoldsItsChildren) {
  const ObjectHierarchy oh = sample();
  for (std::uint32_t node = 1; node < oh.nodeCount(); ++node) {
    EXPECT_TRUE(oh.aabb(oh.parent(node)).contains(oh.aabb(node)));
    const Sphere& outer = oh.sphere(oh.parent(node));
    const Sphere& inner = oh.sphere(node);
    // The parent's sphere holds the child's geometry: its sphere or its box.
    const Vec3 reach = (oh.aabb(node).max - outer.center).cwiseMax(outer.center - oh.aabb(node).min);
    EXPECT_LE(std::min((inner.center - outer.center).norm() + inner.radius, reach.norm()),
              outer.radius * (1 + 1e-12));
  }
}

TEST(ObjectHierarchyBuilder, DropsEmptyNodesAndNodesWithASingleChild) {
  ObjectHierarchyBuilder builder;
  builder.openNode();  // keeps one child: vanishes
  builder.openNode();  // empty: vanishes
  builder.closeNode();
  builder.openNode();
  builder.openNode();  // a chain down to one leaf: vanishes
  builder.addLeaf(boxAt(0));
  builder.closeNode();
  builder.addLeaf(boxAt(2));
  builder.closeNode();
  builder.closeNode();
  const ObjectHierarchy oh = builder.finish();
  ASSERT_EQ(oh.nodeCount(), 3U);
  EXPECT_EQ(oh.leafCount(), 2U);
  EXPECT_EQ(oh.subtreeEnd(0), 3U);
  EXPECT_EQ(oh.parent(1), 0U);
  EXPECT_EQ(oh.parent(2), 0U);
  EXPECT_EQ(oh.parent(0), ObjectHierarchy::kNoParent);
}

TEST(ObjectHierarchyBuilder, OfNothingIsEmptyAndOfOneLeafIsThatLeaf) {
  ObjectHierarchyBuilder builder;
  builder.openNode();
  builder.closeNode();
  EXPECT_TRUE(builder.finish().empty());
  builder.openNode();
  builder.addLeaf(boxAt(0));
  builder.closeNode();
  const ObjectHierarchy oh = builder.finish();
  EXPECT_EQ(oh.nodeCount(), 1U);
  EXPECT_TRUE(oh.isTerminal(0));
}

TEST(ObjectHierarchyBuilder, TakesAChainOf100000Levels) {
  ObjectHierarchyBuilder builder;
  for (int i = 0; i < 100'000; ++i) {
    builder.openNode();
    builder.addLeaf(boxAt(i));
  }
  builder.addLeaf(boxAt(-5));
  for (int i = 0; i < 100'000; ++i)
    builder.closeNode();
  const ObjectHierarchy oh = builder.finish();
  EXPECT_EQ(oh.nodeCount(), 200'001U);
  EXPECT_EQ(oh.depth(), 100'000U);
}

}  // namespace
}  // namespace tessera
