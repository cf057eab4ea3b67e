// What the benchmark judges and computes with: the audit, exponents, entropies, ids, names.
#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "common/hierarchy/grid_frusta.h"
#include "common/scene/load_scene.h"
#include "common/scene/synthetic/synthetic.h"
#include "server/bench/audit.h"
#include "server/bench/candidates.h"
#include "server/bench/exponents.h"
#include "server/bench/linear_kernels.h"
#include "server/bench/list_checks.h"
#include "server/bench/list_entropy.h"
#include "tests/support/process.h"

namespace tessera::test {
namespace {

using namespace bench;

class SmallCity : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto bytes = makeCityGlb({.leaves = 400});
    ASSERT_TRUE(bytes);
    const auto scene = loadScene(folder_.write("city.glb", *bytes));
    ASSERT_TRUE(scene) << scene.error().text();
    scene_ = *scene;
    view_ = Walk(wall_, flyPath(), scene_.sphere(), 1).view(0);
    frusta_.update(view_.screens[0], view_.tiles);
  }
  TemporaryFolder folder_;
  Scene scene_;
  Wall wall_ = gridWall(2, 2);
  WallView view_;
  GridFrusta frusta_{2, 2};
};

TEST_F(SmallCity, AuditJudgesEveryCandidateByItself) {
  cull::Culler culler(scene_.hierarchy, {});
  const std::vector<VisibleList> good = culler.cull(frusta_).lists;
  const std::vector<VisibleList> everything(4, VisibleList{{0, 400}}), nothing(4);
  Audit audit(scene_, 3);
  const std::vector<const std::vector<VisibleList>*> lists = {&good, &everything, &nothing};
  ASSERT_TRUE(audit.add(7, view_, lists));
  const auto& [first, second, third] =
      std::tie(audit.verdicts()[0], audit.verdicts()[1], audit.verdicts()[2]);
  EXPECT_EQ(first.drops, 0U);
  EXPECT_GT(first.exactPairs, 20U);
  EXPECT_EQ(second.drops, 0U);
  EXPECT_EQ(second.pairs, 1600U);
  EXPECT_EQ(second.exactPairs, first.exactPairs);
  EXPECT_GT(second.excessPercent(), first.excessPercent());
  EXPECT_EQ(third.drops, first.exactPairs);
  EXPECT_EQ(third.firstDrop.find("frame 7, tile "), 0U);
}

TEST_F(SmallCity, AuditFindsTheOneLeafThatIsMissing) {
  std::vector<VisibleList> lists(4, VisibleList{{0, 400}});
  std::uint32_t drops = 0;
  for (std::uint32_t leaf = 0; leaf < 400; ++leaf) {
    lists[2] = differenceOf({{0, 400}}, {{leaf, leaf + 1}});
    Audit audit(scene_);
    const std::vector<VisibleList>* const one = &lists;
    ASSERT_TRUE(audit.add(0, view_, {&one, 1}));
    if (audit.verdicts()[0].drops == 0) continue;
    ++drops;
    EXPECT_EQ(audit.verdicts()[0].firstDrop, "frame 0, tile 2, leaf " + std::to_string(leaf));
  }
  EXPECT_GT(drops, 5U);
  EXPECT_LT(drops, 395U);
}

// Two "footprints" whose lists differ, as the command must find them: one of them culls another scene.
TEST_F(SmallCity, ListsThatDifferAreFound) {
  const auto bytes = makeCityGlb({.seed = 2, .leaves = 400});
  const auto other = loadScene(folder_.write("other.glb", *bytes));
  ASSERT_TRUE(other);
  const auto specs = selectCandidates({"footprint obb ranges", "table obb diff"}, false);
  ASSERT_TRUE(specs);
  const auto set = CandidateSet::make(scene_, UpAxis::Auto, *specs);
  ASSERT_TRUE(set);
  const auto check = [&](const Scene& last) {
    std::vector<InterleavedCull::Candidate> candidates = (*set)->candidates();
    candidates.back().hierarchy = &last.hierarchy;
    InterleavedCull interleaved(candidates);
    interleaved.frame(frusta_);
    return ListChecks(scene_, **set, interleaved).compare(3);
  };
  EXPECT_TRUE(check(scene_));
  const Status status = check(*other);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().text().find("in frame 3 the lists of \"table obb diff\" are not those of"),
            std::string::npos)
      << status.error().text();
}

TEST_F(SmallCity, ListsOfOtherHierarchiesAreReadInTheScenesIds) {
  const auto specs = selectCandidates({"adaptive obb bvh"}, true);
  ASSERT_TRUE(specs);
  const auto set = CandidateSet::make(scene_, UpAxis::Auto, *specs);
  ASSERT_TRUE(set);
  InterleavedCull interleaved((*set)->candidates());
  interleaved.frame(frusta_);
  std::vector<VisibleList> graph, bvh;
  interleaved.listsOf(0, graph);
  interleaved.listsOf(1, bvh);
  EXPECT_NE(graph, bvh);
  (*set)->toGraphIds(1, bvh);
  for (std::size_t tile = 0; tile < 4; ++tile) {
    EXPECT_TRUE(isCanonical(bvh[tile], 400));
    VisibleList differing;
    symmetricDifferenceInto(graph[tile], bvh[tile], differing);
    EXPECT_LE(leafCount(differing), leafCount(graph[tile]) / 20);
  }
}

TEST(LeafIds, AreAllTilesListsInOrder) {
  const std::vector<VisibleList> lists = {{{3, 4}, {6, 25}}, {}, {{0, 2}}};
  LeafIds ids;
  ids.reserve(22);
  ids.write(lists);
  std::vector<std::uint32_t> expected;
  for (const VisibleList& list : lists)
    forEachLeaf(list, [&](std::uint32_t leaf) { expected.push_back(leaf); });
  ASSERT_EQ(ids.count(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ(ids[i], expected[i]) << i;
}

TEST(Exponents, AreTheSlopeInLogarithms) {
  EXPECT_NEAR(exponentOf({1, 10, 100}, {5, 50, 500}), 1, 1e-12);
  EXPECT_NEAR(exponentOf({4, 16, 64}, {3, 6, 12}), 0.5, 1e-12);
  EXPECT_NEAR(exponentOf({4, 16, 64}, {7, 7, 7}), 0, 1e-12);
  EXPECT_EQ(exponentOf({4}, {7}), 0);
}

TEST(ListEntropy, IsThatOfGapsAndLengths) {
  ListEntropy entropy;
  EXPECT_EQ(entropy.bytes(), 0);
  entropy.add({{5, 6}, {11, 12}});  // gaps 5 and 5, lengths 1 and 1: nothing to say
  EXPECT_EQ(entropy.bytes(), 0);
  entropy.add({{5, 7}, {9, 11}});  // gaps 5, 5, 5, 2 and lengths 1, 1, 2, 2
  const double gapBits = 3 * std::log2(4.0 / 3) + std::log2(4.0), lengthBits = 4;
  EXPECT_NEAR(entropy.bytes(), (gapBits + lengthBits) / 8, 1e-12);
}

}  // namespace
}  // namespace tessera::test
