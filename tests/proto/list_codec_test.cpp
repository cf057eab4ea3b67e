#include "proto/list_codec.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "proto/protocol_error.h"
#include "tests/proto/test_messages.h"

namespace tessera::proto {
namespace {

using test::ExactBytes;
using Bits = std::vector<bool>;

Bits bitsOf(const VisibleList& list, std::uint32_t leafCount) {
  Bits bits(leafCount);
  forEachLeaf(list, [&](std::uint32_t leaf) { bits[leaf] = true; });
  return bits;
}

VisibleList listOf(const Bits& bits) {
  VisibleList list;
  for (std::uint32_t i = 0; i < bits.size(); ++i) {
    if (bits[i]) appendRange(list, {i, i + 1});
  }
  return list;
}

/// Runs of ones and zeros, on average `meanRun` long.
VisibleList randomList(std::uint32_t leafCount, double meanRun, std::mt19937& random) {
  Bits bits(leafCount);
  bool isSet = (random() & 1U) != 0;
  std::bernoulli_distribution turns(1 / meanRun);
  for (std::uint32_t i = 0; i < leafCount; ++i) {
    if (turns(random)) isSet = !isSet;
    bits[i] = isSet;
  }
  return listOf(bits);
}

std::vector<std::byte> deltaOf(const VisibleList& before, const VisibleList& now) {
  std::vector<std::byte> delta;
  encodeListDelta(before, now, delta);
  return delta;
}

std::vector<std::byte> bytes(std::initializer_list<unsigned> numbers) {
  std::vector<std::byte> made;
  for (const unsigned number : numbers)
    made.push_back(static_cast<std::byte>(number));
  return made;
}

std::optional<ProtocolError> refusal(const VisibleList& before, std::span<const std::byte> delta,
                                     std::uint32_t leafCount) {
  const ExactBytes exact(delta);
  const auto now = applyListDelta(before, exact.view(), leafCount);
  if (!now) return protocolErrorOf(now.error());
  EXPECT_TRUE(isCanonical(*now, leafCount));
  EXPECT_EQ(deltaOf(before, *now), std::vector<std::byte>(delta.begin(), delta.end()));
  return std::nullopt;
}

void expectRoundTrip(const VisibleList& before, const VisibleList& now, std::uint32_t leafCount) {
  const auto decoded = applyListDelta(before, ExactBytes(deltaOf(before, now)).view(), leafCount);
  ASSERT_TRUE(decoded.ok()) << decoded.error().text();
  EXPECT_EQ(*decoded, now);
}

TEST(ListCodec, aKnownDeltaHasTheBytesOfTheTwoLists) {
  std::mt19937 random(5);
  std::vector<std::byte> toggles;
  for (int round = 0; round < 200; ++round) {
    const VisibleList before = randomList(700, 1 + round % 40, random);
    const VisibleList now = randomList(700, 1 + round % 30, random);
    VisibleList toggled;
    symmetricDifferenceInto(before, now, toggled);
    encodeToggles(toggled, toggles);
    EXPECT_EQ(toggles, deltaOf(before, now));
  }
  encodeToggles({}, toggles);
  EXPECT_EQ(toggles, bytes({0}));
}

TEST(ListCodec, BytesAreAsDocumented) {
  EXPECT_EQ(deltaOf({}, {}), bytes({0}));
  EXPECT_EQ(deltaOf({{1, 5}}, {{1, 5}}), bytes({0}));
  EXPECT_EQ(deltaOf({}, {{0, 1}}), bytes({1, 0, 0}));
  EXPECT_EQ(deltaOf({}, {{3, 5}, {6, 10}}), bytes({2, 3, 1, 0, 3}));
  EXPECT_EQ(deltaOf({{3, 5}}, {{3, 6}}), bytes({1, 5, 0}));
  EXPECT_EQ(deltaOf({}, {{300, 600}}), bytes({1, 0xAC, 0x02, 0xAB, 0x02}));
  EXPECT_EQ(deltaOf({{0, 4}}, {{4, 8}}), bytes({1, 0, 7}));
  EXPECT_EQ(deltaOf({{3, 5}}, {{3, 6}, {10, 12}}), bytes({2, 5, 0, 3, 1}));  // the example of PROTOCOL.md
}

TEST(ListCodec, AllPairsOfSmallListsAgreeWithBits) {
  constexpr std::uint32_t kLeaves = 6;
  std::vector<VisibleList> lists;
  for (unsigned mask = 0; mask < 1U << kLeaves; ++mask) {
    Bits bits(kLeaves);
    for (unsigned i = 0; i < kLeaves; ++i)
      bits[i] = ((mask >> i) & 1U) != 0;
    lists.push_back(listOf(bits));
  }
  for (const VisibleList& before : lists) {
    for (const VisibleList& now : lists)
      expectRoundTrip(before, now, kLeaves);
  }
}

// Every byte string up to three bytes: it is refused, or it is the encoding of what it decodes to.
TEST(ListCodec, EveryShortDeltaIsRefusedOrTheOnlyEncoding) {
  const VisibleList before = {{1, 3}, {4, 6}};
  std::vector<std::byte> delta;
  for (unsigned number = 0; number < 1U << 24U; number += number < 1U << 16U ? 1 : 61) {
    for (const std::size_t size : {1U, 2U, 3U}) {
      delta = bytes({number & 0xFFU, (number >> 8U) & 0xFFU, number >> 16U});
      delta.resize(size);
      const auto now = applyListDelta(before, delta, 7);
      if (now) {
        ASSERT_TRUE(isCanonical(*now, 7));
        ASSERT_EQ(deltaOf(before, *now), delta);
      }
    }
  }
}

TEST(ListCodec, RandomListsAgreeWithBits) {
  std::mt19937 random(40);
  for (int i = 0; i < 2000; ++i) {
    const std::uint32_t leafCount = 1 + static_cast<std::uint32_t>(random() % 500);
    const double meanRun = 1.5 + static_cast<double>(random() % 40);
    const VisibleList before = randomList(leafCount, meanRun, random);
    const VisibleList now = randomList(leafCount, meanRun, random);
    const auto decoded = applyListDelta(before, deltaOf(before, now), leafCount);
    ASSERT_TRUE(decoded.ok());
    EXPECT_EQ(bitsOf(*decoded, leafCount), bitsOf(now, leafCount));
    EXPECT_EQ(*decoded, now);
  }
}

TEST(ListCodec, EmptyFullAndTheWholeIdSpace) {
  for (const std::uint32_t leafCount : {0U, 1U, 127U, 128U, 1000000U, UINT32_MAX}) {
    const VisibleList full = leafCount == 0 ? VisibleList{} : VisibleList{{0, leafCount}};
    expectRoundTrip({}, full, leafCount);
    expectRoundTrip(full, {}, leafCount);
    expectRoundTrip(full, full, leafCount);
  }
  expectRoundTrip({{0, 1}}, {{UINT32_MAX - 1, UINT32_MAX}}, UINT32_MAX);
}

TEST(ListCodec, AMillionLeaves) {
  std::mt19937 random(41);
  constexpr std::uint32_t kLeaves = 1000000;
  std::vector<std::byte> delta;
  VisibleList decoded;
  VisibleList before;
  for (const double meanRun : {2.0, 10.0, 1000.0}) {
    const VisibleList now = randomList(kLeaves, meanRun, random);
    encodeListDelta(before, now, delta);
    ASSERT_TRUE(applyListDeltaInto(before, delta, kLeaves, decoded).ok());
    ASSERT_EQ(decoded, now);
    before.swap(decoded);
  }
}

TEST(ListCodec, BuffersAreReused) {
  std::mt19937 random(42);
  const VisibleList before = randomList(1000, 5, random), now = randomList(1000, 5, random);
  std::vector<std::byte> delta;
  VisibleList decoded;
  encodeListDelta(before, now, delta);
  ASSERT_TRUE(applyListDeltaInto(before, delta, 1000, decoded).ok());
  const auto* deltaData = delta.data();
  const auto* listData = decoded.data();
  encodeListDelta(before, now, delta);
  ASSERT_TRUE(applyListDeltaInto(before, delta, 1000, decoded).ok());
  EXPECT_EQ(delta.data(), deltaData);
  EXPECT_EQ(decoded.data(), listData);
}

TEST(ListCodec, EveryPrefixIsRefused) {
  std::mt19937 random(43);
  const VisibleList before = randomList(3000, 8, random), now = randomList(3000, 8, random);
  const std::vector<std::byte> delta = deltaOf(before, now);
  for (std::size_t size = 0; size < delta.size(); ++size) {
    ASSERT_EQ(refusal(before, std::span(delta).first(size), 3000), ProtocolError::Truncated) << size;
  }
}

TEST(ListCodec, EveryFlippedBitIsRefusedOrStillCanonical) {
  std::mt19937 random(44);
  const VisibleList before = randomList(2000, 8, random), now = randomList(2000, 8, random);
  const std::vector<std::byte> delta = deltaOf(before, now);
  for (std::size_t bit = 0; bit < 8 * delta.size(); ++bit) {
    std::vector<std::byte> flipped = delta;
    flipped[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    const auto decoded = applyListDelta(before, ExactBytes(flipped).view(), 2000);
    if (!decoded) continue;
    ASSERT_TRUE(isCanonical(*decoded, 2000));
    ASSERT_NE(*decoded, now);
  }
}

TEST(ListCodec, RandomGarbageIsRefusedOrTheOnlyEncoding) {
  std::mt19937 random(45);
  const VisibleList before = {{2, 9}, {50, 80}, {90, 91}};
  for (int i = 0; i < 100000; ++i) {
    std::vector<std::byte> garbage(random() % 12);
    const unsigned top = (random() & 1U) != 0 ? 256 : 16;  // small numbers get further
    for (std::byte& byte : garbage)
      byte = static_cast<std::byte>(random() % top);
    refusal(before, garbage, 100);
  }
}

TEST(ListCodec, DefectsAreNamed) {
  EXPECT_EQ(refusal({}, {}, 10), ProtocolError::Truncated);
  EXPECT_EQ(refusal({}, bytes({0, 0}), 10), ProtocolError::TrailingBytes);
  EXPECT_EQ(refusal({}, bytes({1, 0, 0, 0}), 10), ProtocolError::TrailingBytes);
  EXPECT_EQ(refusal({}, bytes({0x80, 0x00}), 10), ProtocolError::BadList) << "padded";
  EXPECT_EQ(refusal({}, bytes({1, 0x83, 0x00, 0}), 10), ProtocolError::BadList) << "padded";
  EXPECT_EQ(refusal({}, bytes({1, 9, 1}), 10), ProtocolError::BadList) << "past the last leaf";
  EXPECT_EQ(refusal({}, bytes({1, 9, 0}), 10), std::nullopt);
  EXPECT_EQ(refusal({}, bytes({1, 0, 0}), 0), ProtocolError::BadList) << "no leaves at all";
  EXPECT_EQ(refusal({}, bytes({1, 0xFF, 0xFF, 0xFF, 0xFF, 0x1F, 0}), UINT32_MAX), ProtocolError::BadList)
      << "over 32 bits";
  EXPECT_EQ(refusal({}, bytes({1, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x01, 0}), UINT32_MAX),
            ProtocolError::BadList)
      << "six bytes";
  EXPECT_EQ(refusal({}, bytes({1, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F}), UINT32_MAX),
            ProtocolError::BadList)
      << "a sum over 32 bits";
  EXPECT_EQ(refusal({}, bytes({0xFF, 0xFF, 0xFF, 0xFF, 0x0F, 0, 0}), UINT32_MAX), ProtocolError::Truncated)
      << "more ranges than bytes";
  EXPECT_EQ(refusal({{0, 11}}, bytes({0}), 10), ProtocolError::BadList) << "base of another scene";
}

TEST(ListCodec, OutIsEmptyAfterAFailure) {
  VisibleList out = {{1, 2}};
  EXPECT_FALSE(applyListDeltaInto({{5, 6}}, bytes({2, 0, 0, 0}), 10, out).ok());
  EXPECT_TRUE(out.empty());
}

}  // namespace
}  // namespace tessera::proto
