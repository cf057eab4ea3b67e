#include "common/hierarchy/visible_list.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tessera {
namespace {

VisibleList fromBits(const std::vector<bool>& bits) {
  VisibleList list;
  for (std::uint32_t i = 0; i < bits.size(); ++i) {
    if (bits[i]) appendRange(list, {i, i + 1});
  }
  return list;
}

TEST(VisibleList, SetOperationsAgreeWithBitsets) {
  std::mt19937 random(3);
  for (int round = 0; round < 2000; ++round) {
    std::vector<bool> a(40), b(40), sum(40), difference(40);
    const std::size_t density = random() % 7 + 1;
    for (std::size_t i = 0; i < a.size(); ++i) {
      a[i] = random() % 8 < density;
      b[i] = random() % 8 < density;
      sum[i] = a[i] || b[i];
      difference[i] = a[i] && !b[i];
    }
    const VisibleList listA = fromBits(a), listB = fromBits(b);
    EXPECT_TRUE(isCanonical(listA, 40));
    EXPECT_EQ(unionOf(listA, listB), fromBits(sum));
    EXPECT_EQ(differenceOf(listA, listB), fromBits(difference));
    VisibleList left = {{3, 7}};
    differenceInto(listA, listB, left);
    EXPECT_EQ(left, fromBits(difference));
    EXPECT_EQ(leafCount(listA), static_cast<std::uint64_t>(std::count(a.begin(), a.end(), true)));
    for (std::uint32_t i = 0; i < 40; ++i)
      EXPECT_EQ(containsLeaf(listA, i), a[i]);
  }
}

TEST(VisibleList, KnowsItsCanonicalForm) {
  EXPECT_TRUE(isCanonical({}, 0));
  EXPECT_TRUE(isCanonical({{0, 2}, {3, 4}}, 4));
  EXPECT_FALSE(isCanonical({{0, 2}, {2, 4}}, 4)) << "adjacent";
  EXPECT_FALSE(isCanonical({{2, 2}}, 4)) << "empty";
  EXPECT_FALSE(isCanonical({{0, 5}}, 4)) << "beyond the end";
  EXPECT_FALSE(isCanonical({{3, 4}, {0, 1}}, 4)) << "unsorted";
}

}  // namespace
}  // namespace tessera
