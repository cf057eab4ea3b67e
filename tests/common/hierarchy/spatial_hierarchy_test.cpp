#include "common/hierarchy/spatial_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <ostream>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

namespace tessera {
namespace {

Bounds boundsOfBox(const Vec3& low, const Vec3& high) {
  Bounds bounds;
  bounds.aabb = {low, high};
  bounds.obb = Obb::fromAabb(bounds.aabb);
  bounds.sphere = {bounds.aabb.center(), 0.5 * (high - low).norm() * (1 + 1e-12)};
  return bounds;
}

struct Placing {
  const char* name;
  double offset;             ///< of the scene from the origin
  double spread;             ///< of the items
  double lowSize, highSize;  ///< of an item; the sizes are spread evenly over the exponents

  friend void PrintTo(const Placing& placing, std::ostream* out) { *out << placing.name; }
};

std::vector<Bounds> scene(const Placing& placing, std::size_t count) {
  std::mt19937_64 random(11);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::vector<Bounds> items;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 at = placing.spread * Vec3(unit(), unit(), 0.1 * unit()) + Vec3::Constant(placing.offset);
    const double size =
        placing.lowSize *
        std::pow(std::max(placing.highSize, 1e-300) / std::max(placing.lowSize, 1e-300), unit());
    items.push_back(boundsOfBox(at, at + size * Vec3(unit(), unit(), unit())));
  }
  return items;
}

std::vector<std::uint64_t> triangleCounts(std::size_t count) {
  std::mt19937_64 random(5);
  std::vector<std::uint64_t> out(count);
  for (std::uint64_t& n : out)
    n = random() % 50 == 0 ? 5000 : random() % 40;
  return out;
}

void expectWellFormed(const SpatialHierarchy& built, std::span<const Bounds> items,
                      std::span<const std::uint64_t> triangles, std::uint64_t limit) {
  const ObjectHierarchy& oh = built.hierarchy;
  ASSERT_EQ(oh.leafCount(), items.size());
  std::vector<std::uint32_t> sorted = built.order;
  std::ranges::sort(sorted);
  std::vector<std::uint32_t> all(items.size());
  std::iota(all.begin(), all.end(), 0U);
  ASSERT_EQ(sorted, all);
  ASSERT_EQ(oh.leaves(0), (LeafRange{0, oh.leafCount()}));
  for (std::uint32_t node = 0; node < oh.nodeCount(); ++node) {
    const LeafRange range = oh.leaves(node);
    if (node > 0) {
      ASSERT_TRUE(oh.aabb(oh.parent(node)).contains(oh.aabb(node))) << node;
    }
    if (oh.isTerminal(node)) {
      std::uint64_t sum = 0;
      for (std::uint32_t leaf = range.first; leaf < range.last; ++leaf) {
        ASSERT_EQ(oh.nodeOfLeaf(leaf), node);
        ASSERT_TRUE(oh.aabb(node).contains(items[built.order[leaf]].aabb));
        sum += triangles[built.order[leaf]];
      }
      ASSERT_TRUE(range.last - range.first == 1 || (range.last > range.first && sum <= limit));
      continue;
    }
    std::uint32_t next = range.first, children = 0;
    for (std::uint32_t child = node + 1; child != oh.subtreeEnd(node); child = oh.subtreeEnd(child)) {
      ASSERT_EQ(oh.parent(child), node);
      ASSERT_EQ(oh.leaves(child).first, next);
      next = oh.leaves(child).last;
      ++children;
    }
    ASSERT_EQ(next, range.last);
    ASSERT_GE(children, 2U);
    ASSERT_LE(children, 16U);
  }
}

constexpr HierarchyKind kSpatialKinds[] = {HierarchyKind::Bvh, HierarchyKind::Octree,
                                           HierarchyKind::LooseOctree, HierarchyKind::Kd};

std::string nameForTest(HierarchyKind kind) {
  std::string name(nameOf(kind));
  std::erase(name, '-');
  return name;
}

class SpatialScenes : public ::testing::TestWithParam<std::tuple<HierarchyKind, Placing>> {};

TEST_P(SpatialScenes, AreOrderedIntoAWellFormedHierarchyWithinTheLimit) {
  const auto& [kind, placing] = GetParam();
  const std::vector<Bounds> items = scene(placing, 3000);
  const std::vector<std::uint64_t> triangles = triangleCounts(items.size());
  for (const std::uint64_t limit : {0, 1, 100, 1'000'000'000}) {
    SCOPED_TRACE(limit);
    expectWellFormed(buildSpatialHierarchy(kind, items, triangles, limit), items, triangles, limit);
  }
}

TEST_P(SpatialScenes, AreOrderedTheSameEachTime) {
  const auto& [kind, placing] = GetParam();
  const std::vector<Bounds> items = scene(placing, 2000);
  const std::vector<std::uint64_t> triangles = triangleCounts(items.size());
  const SpatialHierarchy a = buildSpatialHierarchy(kind, items, triangles, 60);
  const SpatialHierarchy b = buildSpatialHierarchy(kind, items, triangles, 60);
  ASSERT_EQ(a.order, b.order);
  ASSERT_EQ(a.hierarchy.nodeCount(), b.hierarchy.nodeCount());
  for (std::uint32_t node = 0; node < a.hierarchy.nodeCount(); ++node)
    ASSERT_EQ(a.hierarchy.subtreeEnd(node), b.hierarchy.subtreeEnd(node));
}

INSTANTIATE_TEST_SUITE_P(
    All, SpatialScenes,
    ::testing::Combine(::testing::ValuesIn(kSpatialKinds),
                       ::testing::Values(
                           Placing{"plain", 0, 100, 0.1, 3}, Placing{"tiny", 0, 1e-9, 1e-12, 1e-10},
                           Placing{"huge", -1e9, 3e9, 1, 1e9}, Placing{"far", 1e12, 1, 1e-3, 0.1},
                           Placing{"farPoints", 1e12, 1e-3, 0, 0}, Placing{"points", 0, 1, 0, 0},
                           Placing{"allEqual", 7, 0, 0, 0}, Placing{"manySizes", 0, 1e9, 1e-9, 1e9},
                           Placing{"overlapping", 0, 1, 10, 20},
                           Placing{"nearOverflow", -8e307, 1.7e308, 1, 1e300})),
    [](const auto& c) { return nameForTest(std::get<0>(c.param)) + "_" + std::get<1>(c.param).name; });

class SpatialKinds : public ::testing::TestWithParam<HierarchyKind> {};

TEST_P(SpatialKinds, OfNothingAndOfOneItem) {
  EXPECT_TRUE(buildSpatialHierarchy(GetParam(), {}, {}, 0).hierarchy.empty());
  const std::vector<Bounds> one = {boundsOfBox({1, 2, 3}, {4, 5, 6})};
  const SpatialHierarchy built = buildSpatialHierarchy(GetParam(), one, std::vector<std::uint64_t>{7}, 3);
  EXPECT_EQ(built.hierarchy.nodeCount(), 1U);
  EXPECT_EQ(built.order, std::vector<std::uint32_t>{0});
}

TEST_P(SpatialKinds, TakesCoincidentItems) {
  const std::vector<Bounds> boxes(100'000, boundsOfBox({1, 1, 1}, {2, 2, 2}));
  const std::vector<Bounds> points(100'000, boundsOfBox({1e12, 1, 1}, {1e12, 1, 1}));
  const std::vector<std::uint64_t> triangles(boxes.size(), 10);
  for (const std::vector<Bounds>& items : {boxes, points}) {
    const SpatialHierarchy built = buildSpatialHierarchy(GetParam(), items, triangles, 100);
    expectWellFormed(built, items, triangles, 100);
    EXPECT_LE(built.hierarchy.depth(), 17U);
  }
}

/// Each split in the middle takes but a few items away, through all exponents.
TEST_P(SpatialKinds, KeepsToALimitedDepthForClustersWithinClusters) {
  std::vector<Bounds> items;
  for (int exponent = -1060; exponent < 0; ++exponent) {
    for (int i = 0; i < 20; ++i)
      items.push_back(
          boundsOfBox(Vec3::Constant(std::ldexp(1, exponent)), Vec3::Constant(std::ldexp(1, exponent))));
  }
  const std::vector<std::uint64_t> triangles(items.size(), 1);
  const SpatialHierarchy built = buildSpatialHierarchy(GetParam(), items, triangles, 0);
  expectWellFormed(built, items, triangles, 0);
  EXPECT_LE(built.hierarchy.depth(), 240U);
}

TEST_P(SpatialKinds, LeavesAnItemOfTheGreatestCountAlone) {
  const std::vector<Bounds> items = scene({"", 0, 10, 0.1, 1}, 200);
  std::vector<std::uint64_t> triangles(items.size(), 1);
  triangles[17] = triangles[99] = UINT64_MAX;
  const SpatialHierarchy built = buildSpatialHierarchy(GetParam(), items, triangles, 1000);
  for (const std::uint32_t item : {17U, 99U}) {
    const auto leaf = static_cast<std::uint32_t>(std::ranges::find(built.order, item) - built.order.begin());
    EXPECT_EQ(built.hierarchy.leaves(built.hierarchy.nodeOfLeaf(leaf)), (LeafRange{leaf, leaf + 1}));
  }
}

TEST_P(SpatialKinds, GathersNeighbours) {
  const std::vector<Bounds> items = scene({"", 0, 100, 0.1, 0.2}, 4000);
  const std::vector<std::uint64_t> triangles(items.size(), 1);
  const ObjectHierarchy oh = buildSpatialHierarchy(GetParam(), items, triangles, 0).hierarchy;
  // Three levels down the boxes are a fraction of the scene; straddlers are few.
  double volume = 0;
  std::uint32_t small = 0;
  for (std::uint32_t node = 1; node < oh.nodeCount(); ++node) {
    if (oh.parent(node) != 0 && oh.parent(oh.parent(node)) == 0) {
      volume += (oh.aabb(node).max - oh.aabb(node).min).head<2>().prod();
      ++small;
    }
  }
  ASSERT_GT(small, 3U);
  EXPECT_LT(volume / small, 0.3 * 100 * 100);
}

INSTANTIATE_TEST_SUITE_P(All, SpatialKinds, ::testing::ValuesIn(kSpatialKinds),
                         [](const auto& c) { return nameForTest(c.param); });

TEST(HierarchyKinds, HaveNamesThatAreReadBack) {
  for (const char* name : {"graph", "bvh", "octree", "loose-octree", "kd"}) {
    const auto kind = hierarchyFromName(name);
    ASSERT_TRUE(kind) << name;
    EXPECT_EQ(nameOf(*kind), name);
  }
  EXPECT_FALSE(hierarchyFromName("BVH"));
  EXPECT_FALSE(hierarchyFromName(""));
}

}  // namespace
}  // namespace tessera
