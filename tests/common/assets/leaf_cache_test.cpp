// The books of a tile's cache against a model that recomputes everything from what is there.

#include "common/assets/leaf_cache.h"

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/common/assets/leaf_cache_model.h"

namespace tessera::test {
namespace {

constexpr std::uint32_t kLeaves = 24, kDrawables = 16, kStates = 8, kImages = 8;
constexpr std::uint32_t kAssets = kDrawables + kStates + kImages;

/// Two caches that are fed alike and the model.
class Trio {
 public:
  explicit Trio(std::uint32_t seed, bool isHostile) : random_(seed), isHostile_(isHostile) { setBudget(); }

  void step() {
    switch (below(20)) {
      case 0:
        return setBudget();
      case 1:
        if (below(20) > 0) return;
        a_.clear(), b_.clear(), model_.clear();
        return;
      case 2:
      case 3:
      case 4:
        return trim();
      case 5:
      case 6:
      case 7:
        return show();
      case 8:
      case 9: {
        const std::uint32_t leaf = below(kLeaves);
        a_.keep(leaf), b_.keep(leaf), model_.keep(leaf);
        return;
      }
      case 10:
      case 11:
      case 12:
      case 13:
        return addLeaf();
      default:
        return addAsset();
    }
  }

  void check() const {
    for (const LeafCache* cache : {&a_, &b_}) {
      ASSERT_EQ(cache->bytes(), model_.bytes());
      ASSERT_EQ(cache->shownBytes(), model_.shownBytes());
      ASSERT_EQ(cache->leafCount(), model_.leaves.size());
      ASSERT_EQ(cache->assetCount(), model_.assets.size());
      for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf) {
        ASSERT_EQ(cache->hasLeaf(leaf), model_.leaves.contains(leaf)) << leaf;
        ASSERT_EQ(cache->isComplete(leaf), model_.isComplete(leaf)) << leaf;
      }
      for (std::uint32_t asset = 0; asset < kAssets; ++asset)
        ASSERT_EQ(cache->hasAsset(idOf(asset)), model_.assets.contains(idOf(asset))) << asset;
    }
  }

  [[nodiscard]] std::size_t droppedLeaves() const { return droppedLeaves_; }
  [[nodiscard]] std::size_t completeLeaves() const {
    std::size_t count = 0;
    for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf)
      count += model_.isComplete(leaf) ? 1 : 0;
    return count;
  }

 private:
  std::uint32_t below(std::uint32_t limit) {
    return std::uniform_int_distribution<std::uint32_t>(0, limit - 1)(random_);
  }
  AssetId anyAsset() { return idOf(below(kAssets)); }

  void setBudget() {
    const std::uint64_t budget = below(4) == 0 ? LeafCache::kNoBudget : below(40'000);
    a_.setBudget(budget), b_.setBudget(budget);
  }
  void addLeaf() {
    const std::uint32_t leaf = below(kLeaves);
    const AssetId drawable = isHostile_ ? anyAsset() : idOf(below(kDrawables));
    const AssetId state = isHostile_ ? anyAsset() : idOf(kDrawables + below(kStates));
    a_.addLeaf(leaf, drawable, state), b_.addLeaf(leaf, drawable, state);
    model_.addLeaf(leaf, drawable, state);
  }
  void addAsset() {
    const std::uint32_t number = below(kAssets);
    const std::uint32_t bytes = below(3000);
    std::vector<AssetId> needs;
    if (isHostile_) {
      for (std::uint32_t count = below(5); count > 0; --count)
        needs.push_back(below(8) == 0 ? idOf(number) : anyAsset());
    } else if (number >= kDrawables && number < kDrawables + kStates) {
      for (std::uint32_t count = below(4); count > 0; --count)
        needs.push_back(idOf(kDrawables + kStates + below(kImages)));
    }
    a_.addAsset(idOf(number), bytes, needs), b_.addAsset(idOf(number), bytes, needs);
    model_.addAsset(idOf(number), bytes, needs);
  }
  void show() {
    VisibleList toggled;
    for (std::uint32_t leaf = 0; leaf < kLeaves; ++leaf) {
      if (below(8) > 0) continue;
      appendRange(toggled, {leaf, leaf + 1});
      model_.toggle(leaf);
    }
    a_.show(toggled), b_.show(toggled);
  }
  void trim() {
    const LeafCache::Dropped &fromA = a_.trim(), &fromB = b_.trim();
    EXPECT_EQ(fromA.leaves, fromB.leaves);
    EXPECT_EQ(fromA.assets, fromB.assets);
    const auto steps = model_.trim(a_.budgetBytes());
    std::vector<std::uint32_t> leaves;
    auto asset = fromA.assets.begin();
    for (const LeafCacheModel::Step& step : steps) {
      leaves.insert(leaves.end(), step.leaf.begin(), step.leaf.end());
      ASSERT_GE(static_cast<std::size_t>(fromA.assets.end() - asset), step.assets.size());
      const auto end = asset + static_cast<std::ptrdiff_t>(step.assets.size());
      EXPECT_EQ(std::set<AssetId>(asset, end), step.assets);
      asset = end;
    }
    EXPECT_TRUE(asset == fromA.assets.end()) << "dropped too many";
    EXPECT_EQ(fromA.leaves, leaves);
    droppedLeaves_ += leaves.size();
    EXPECT_LE(a_.bytes(), std::max(a_.budgetBytes(), a_.shownBytes()));
  }

  std::mt19937 random_;
  const bool isHostile_;
  LeafCache a_, b_;
  LeafCacheModel model_;
  std::size_t droppedLeaves_ = 0;
};

void expectTheModel(bool isHostile) {
  std::size_t dropped = 0, complete = 0;
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Trio trio(seed, isHostile);
    for (int i = 0; i < 400; ++i) {
      trio.step();
      trio.check();
      if (::testing::Test::HasFailure()) return;
      complete += trio.completeLeaves();
    }
    dropped += trio.droppedLeaves();
  }
  // The sequences reach what they are for.
  EXPECT_GT(dropped, 1000U);
  EXPECT_GT(complete, 1000U);
}

TEST(LeafCache, IsAsItsModel) {
  expectTheModel(false);
}

TEST(LeafCache, IsAsItsModelWithNeedsFromStrangers) {
  expectTheModel(true);
}

TEST(LeafCache, WhatIsShownStays) {
  LeafCache cache(1);
  cache.addLeaf(7, idOf(1), idOf(2));
  cache.addAsset(idOf(2), 10, std::array{idOf(3)});
  cache.show({{7, 8}});
  cache.addAsset(idOf(1), 100, {});
  cache.addAsset(idOf(3), 1000, {});
  EXPECT_TRUE(cache.trim().leaves.empty());
  EXPECT_TRUE(cache.isComplete(7));
  EXPECT_EQ(cache.shownBytes(), LeafCache::kRecordBytes + 1110);
  cache.show({{7, 8}});
  EXPECT_EQ(cache.trim().leaves, std::vector<std::uint32_t>{7});
  EXPECT_EQ(cache.bytes(), 0U);
  EXPECT_EQ(cache.shownBytes(), 0U);
}

TEST(LeafCache, ARecordReplacedWhileShownTellsWhatItNoLongerNeeds) {
  LeafCache cache;
  cache.addLeaf(0, idOf(1), idOf(2));
  cache.addAsset(idOf(1), 10, {});
  cache.addAsset(idOf(2), 20, {});
  cache.show({{0, 1}});
  (void)cache.trim();
  cache.addLeaf(0, idOf(3), idOf(2));
  EXPECT_EQ(cache.shownBytes(), LeafCache::kRecordBytes + 20);
  EXPECT_EQ(cache.trim().assets, std::vector<AssetId>{idOf(1)});
  EXPECT_TRUE(cache.hasAsset(idOf(2)));
  // It came back into use before the trim: nothing is dropped.
  cache.addLeaf(0, idOf(3), idOf(4));
  cache.addLeaf(0, idOf(3), idOf(2));
  EXPECT_TRUE(cache.trim().assets.empty());
  EXPECT_TRUE(cache.hasAsset(idOf(2)));
}

TEST(LeafCache, AssetsThatNeedEachOtherGo) {
  LeafCache cache(0);
  cache.addAsset(idOf(1), 10, std::array{idOf(2), idOf(1)});
  cache.addAsset(idOf(2), 20, std::array{idOf(1)});
  (void)cache.trim();
  EXPECT_EQ(cache.bytes(), 0U);
  cache.addLeaf(0, idOf(1), idOf(2));
  cache.addAsset(idOf(2), 20, std::array{idOf(1)});
  cache.addAsset(idOf(1), 10, std::array{idOf(2)});
  cache.show({{0, 1}});
  cache.show({{0, 1}});
  EXPECT_EQ(cache.shownBytes(), 0U);
  (void)cache.trim();
  EXPECT_EQ(cache.bytes(), 0U);
  EXPECT_EQ(cache.assetCount(), 0U);
}

TEST(LeafCache, ALongChainOfNeedsIsNoDeepRecursion) {
  constexpr std::uint32_t kLength = 400'000;
  LeafCache cache(0);
  // Either way round: what is needed comes before, or after.
  for (std::uint32_t i = 0; i < kLength; ++i)
    cache.addAsset(idOf(i + 1), 1, std::array{idOf(i)});
  for (std::uint32_t i = 2 * kLength; i > kLength + 1; --i)
    cache.addAsset(idOf(i), 1, std::array{idOf(i - 1)});
  cache.addLeaf(0, idOf(kLength), idOf(2 * kLength));
  cache.show({{0, 1}});
  cache.show({{0, 1}});
  (void)cache.trim();
  EXPECT_EQ(cache.bytes(), 0U);
}

TEST(LeafCache, ClearLeavesTheBudgetAlone) {
  LeafCache cache(600);
  cache.addLeaf(0, idOf(1), idOf(2));
  cache.addLeaf(1, idOf(1), idOf(2));
  cache.addAsset(idOf(1), 10, {});
  cache.show({{0, 1}});
  cache.clear();
  EXPECT_EQ(cache.bytes() + cache.shownBytes() + cache.leafCount() + cache.assetCount(), 0U);
  EXPECT_TRUE(cache.trim().assets.empty());
  cache.addLeaf(4, idOf(1), idOf(2));
  cache.addLeaf(5, idOf(1), idOf(2));
  EXPECT_EQ(cache.trim().leaves, std::vector<std::uint32_t>{4});
}

}  // namespace
}  // namespace tessera::test
