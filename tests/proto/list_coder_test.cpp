#include "proto/list_coder.h"

#include <algorithm>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "proto/list_codec.h"
#include "proto/protocol_error.h"
#include "tests/proto/test_messages.h"

namespace tessera::proto {
namespace {

using test::ExactBytes;
using Delta = std::vector<std::byte>;

VisibleList listOf(const std::set<std::uint32_t>& leaves) {
  VisibleList list;
  for (const std::uint32_t leaf : leaves)
    appendRange(list, {leaf, leaf + 1});
  return list;
}

std::string hexOf(const Delta& delta) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string hex;
  for (const std::byte byte : delta) {
    hex += kDigits[std::to_integer<unsigned>(byte >> 4U)];
    hex += kDigits[std::to_integer<unsigned>(byte & std::byte{15})];
  }
  return hex;
}

/// Lists as a camera makes them: leaves come and go at the ends of what is in view, and anywhere at times.
class Views {
 public:
  Views(std::uint32_t leafCount, unsigned seed) : leafCount_(leafCount), random_(seed) {}

  VisibleList toggle(unsigned runs) {
    std::set<std::uint32_t> toggled;
    for (unsigned i = 0; i < runs; ++i) {
      std::uint32_t leaf = below(leafCount_);
      if (!in_.empty() && below(3) != 0) {
        const auto near = in_.lower_bound(leaf);
        leaf = near == in_.end() ? *in_.rbegin() : *near + (below(2) != 0 ? 1 : 0);
      }
      const std::uint32_t length = 1 + (below(4) == 0 ? below(20) : 0);
      for (std::uint32_t j = leaf; j < std::min(leaf + length, leafCount_); ++j)
        toggled.insert(j);
    }
    for (const std::uint32_t leaf : toggled) {
      if (!in_.insert(leaf).second) in_.erase(leaf);
    }
    return listOf(toggled);
  }
  [[nodiscard]] VisibleList list() const { return listOf(in_); }
  [[nodiscard]] const std::set<std::uint32_t>& leaves() const { return in_; }

 private:
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }
  std::uint32_t leafCount_;
  std::mt19937 random_;
  std::set<std::uint32_t> in_;
};

TEST(RangeCoder, GivesBackWhatWasWritten) {
  std::mt19937 random(3);
  for (int round = 0; round < 20'000; ++round) {
    Delta bytes;
    RangeEncoder encoder(bytes);
    std::array<AdaptiveBit, 3> write = {}, read = {};
    struct Step {
      std::size_t model;
      std::uint32_t number, choices;
    };
    std::vector<Step> steps(random() % 40);
    for (Step& step : steps) {
      step = {.model = random() % 4, .number = 0, .choices = 2};
      if (step.model == 3) step.choices = 1 + static_cast<std::uint32_t>(random() % kMostChoices);
      step.number = static_cast<std::uint32_t>(random() % (step.model == 3 ? step.choices : 2 + step.model));
      if (step.model == 3) {
        encoder.even(step.number, step.choices);
      } else {
        encoder.bit(write[step.model], step.number == 0);
      }
    }
    encoder.finish();
    ASSERT_TRUE(bytes.empty() || bytes.front() != std::byte{0xFF});
    const ExactBytes exact(bytes);
    RangeDecoder decoder(exact.view());
    for (const Step& step : steps) {
      if (step.model == 3) {
        ASSERT_EQ(decoder.even(0, step.choices), step.number);
      } else {
        ASSERT_EQ(decoder.bit(read[step.model]), step.number == 0);
      }
    }
    ASSERT_TRUE(decoder.isExact());
    ASSERT_FALSE(decoder.isPastEnd());
  }
}

TEST(RangeCoder, CarriesThroughManyBytes) {
  // Always the upper half: the number is just below the end of the interval and carries into long runs of FF.
  for (const unsigned count : {1U, 31U, 32U, 33U, 200U}) {
    for (unsigned last = 0; last < 8; ++last) {
      Delta bytes;
      RangeEncoder encoder(bytes);
      for (unsigned i = 0; i < count; ++i)
        encoder.even(1, 2);
      for (unsigned i = 0; i < 3; ++i)
        encoder.even((last >> i) & 1U, 2);
      encoder.finish();
      RangeDecoder decoder(bytes);
      for (unsigned i = 0; i < count; ++i)
        ASSERT_EQ(decoder.even(0, 2), 1U);
      for (unsigned i = 0; i < 3; ++i)
        ASSERT_EQ(decoder.even(0, 2), (last >> i) & 1U);
      ASSERT_TRUE(decoder.isExact());
    }
  }
}

TEST(ListCoder, BytesAreAsDocumented) {
  ListEncoder encoder(41);
  Delta delta;
  std::vector<std::string> bytes;
  for (const VisibleList& toggled :
       {VisibleList{{3, 5}}, VisibleList{{5, 6}, {10, 12}}, VisibleList{}, VisibleList{{3, 12}, {40, 41}}}) {
    encoder.encode(toggled, delta);
    bytes.push_back(hexOf(delta));
  }
  EXPECT_EQ(bytes, (std::vector<std::string>{"f2", "31e52e", "", "3a7f"}));
  EXPECT_EQ(encoder.list(), (VisibleList{{6, 10}, {40, 41}}));
}

TEST(ListCoder, ListsAreThoseOfSets) {
  for (const std::uint32_t leafCount : {1U, 2U, 3U, 10U, 300U, 100'000U}) {
    Views views(leafCount, leafCount);
    ListEncoder encoder(leafCount);
    ListDecoder decoder(leafCount);
    Delta delta;
    for (unsigned frame = 0; frame < 600; ++frame) {
      if (frame % 100 == 99) {
        encoder.reset();
        decoder.reset();
        encoder.encode(views.list(), delta);
        ASSERT_TRUE(decoder.decode(ExactBytes(delta).view()).ok());
        ASSERT_EQ(decoder.toggled(), views.list());
      }
      const VisibleList toggled = views.toggle(frame % 7 == 0 ? 60 : frame % 5);
      encoder.encode(toggled, delta);
      ASSERT_EQ(delta.empty(), toggled.empty());
      const Status status = decoder.decode(ExactBytes(delta).view());
      ASSERT_TRUE(status.ok()) << status.error().text() << " frame " << frame;
      ASSERT_EQ(decoder.toggled(), toggled);
      ASSERT_EQ(encoder.list(), views.list()) << frame;
      ASSERT_EQ(decoder.list(), views.list()) << frame;
    }
  }
}

TEST(ListCoder, AllPairsOfSmallLists) {
  constexpr std::uint32_t kLeaves = 6;
  const auto listOfMask = [](unsigned mask) {
    VisibleList list;
    for (std::uint32_t i = 0; i < kLeaves; ++i) {
      if (((mask >> i) & 1U) != 0) appendRange(list, {i, i + 1});
    }
    return list;
  };
  Delta delta;
  for (unsigned before = 0; before < 1U << kLeaves; ++before) {
    for (unsigned toggled = 0; toggled < 1U << kLeaves; ++toggled) {
      ListEncoder encoder(kLeaves);
      ListDecoder decoder(kLeaves);
      for (const unsigned mask : {before, toggled}) {
        encoder.encode(listOfMask(mask), delta);
        ASSERT_TRUE(decoder.decode(ExactBytes(delta).view()).ok()) << before << ' ' << toggled;
      }
      ASSERT_EQ(decoder.list(), listOfMask(before ^ toggled));
      ASSERT_EQ(encoder.list(), listOfMask(before ^ toggled));
    }
  }
}

TEST(ListCoder, TheWholeIdSpace) {
  Delta delta;
  for (const std::uint32_t leafCount : {1U, 255U, 65'537U, UINT32_MAX - 1, UINT32_MAX}) {
    ListEncoder encoder(leafCount);
    ListDecoder decoder(leafCount);
    for (const VisibleList& toggled :
         {VisibleList{{0, leafCount}}, VisibleList{{leafCount - 1, leafCount}},
          VisibleList{{leafCount / 2, leafCount}}, VisibleList{{0, 1}}, VisibleList{{0, leafCount}}}) {
      encoder.encode(toggled, delta);
      ASSERT_TRUE(decoder.decode(ExactBytes(delta).view()).ok()) << leafCount;
      ASSERT_EQ(decoder.toggled(), toggled);
      ASSERT_EQ(decoder.list(), encoder.list());
    }
  }
}

TEST(ListCoder, WhatIsSaidOftenBecomesCheap) {
  ListEncoder encoder(100'000);
  Delta delta;
  std::size_t early = 0, late = 0;
  for (std::uint32_t frame = 0; frame < 300; ++frame) {
    encoder.encode({{200 * frame, 200 * frame + 1}}, delta);  // far from all others
    encoder.encode({{200 * frame + 1, 200 * frame + 9}}, delta);
    (frame < 10 ? early : frame >= 290 ? late : early) += frame < 10 || frame >= 290 ? delta.size() : 0;
  }
  EXPECT_LT(late, early + 10);
}

TEST(ListCoder, ManyPiecesInFewBytesFallBackToThePlainForm) {
  // Every leaf of its own, told over and over: soon a piece is next to nothing.
  constexpr std::uint32_t kLeaves = 20'000;
  VisibleList odd;
  for (std::uint32_t leaf = 1; leaf < kLeaves; leaf += 2)
    odd.push_back({leaf, leaf + 1});
  ListEncoder encoder(kLeaves);
  ListDecoder decoder(kLeaves);
  Delta delta;
  unsigned plain = 0;
  for (int frame = 0; frame < 12; ++frame) {
    encoder.encode(frame == 0       ? odd
                   : frame % 3 == 0 ? VisibleList{{7, 8}}
                                    : VisibleList{{0, kLeaves}},
                   delta);
    plain += delta.front() == kPlainDelta ? 1 : 0;
    ASSERT_TRUE(decoder.decode(ExactBytes(delta).view()).ok()) << frame;
    ASSERT_EQ(decoder.list(), encoder.list());
  }
  EXPECT_GT(plain, 0U);
  EXPECT_LT(plain, 12U);
}

TEST(ListCoder, ThePlainFormIsReadAtAnyTime) {
  Views views(500, 9);
  ListEncoder encoder(500);
  ListDecoder decoder(500);
  Delta delta;
  encoder.encode(views.toggle(30), delta);
  ASSERT_TRUE(decoder.decode(delta).ok());
  const VisibleList toggled = views.toggle(30);
  encodeToggles(toggled, delta);
  delta.insert(delta.begin(), kPlainDelta);
  ASSERT_TRUE(decoder.decode(delta).ok());
  EXPECT_EQ(decoder.toggled(), toggled);
  EXPECT_EQ(decoder.list(), views.list());
  delta.pop_back();
  EXPECT_EQ(protocolErrorOf(decoder.decode(delta).error()), ProtocolError::Truncated);
}

/// A decoder that has followed some frames, and the delta that comes next.
struct Followed {
  ListDecoder decoder;
  Delta next;
  VisibleList list, toggled;
};
Followed follow(std::uint32_t leafCount, unsigned frames, unsigned nextRuns, unsigned seed) {
  Views views(leafCount, seed);
  ListEncoder encoder(leafCount);
  Followed followed = {ListDecoder(leafCount), {}, {}, {}};
  for (unsigned frame = 0; frame < frames; ++frame) {
    encoder.encode(views.toggle(5), followed.next);
    EXPECT_TRUE(followed.decoder.decode(followed.next).ok());
  }
  followed.toggled = views.toggle(nextRuns);
  encoder.encode(followed.toggled, followed.next);
  followed.list = views.list();
  return followed;
}

TEST(ListCoder, APrefixIsRefusedOrIsAnotherDelta) {
  unsigned accepted = 0, tried = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Followed followed = follow(3000, 20, 40, seed);
    for (std::size_t size = 1; size < followed.next.size(); ++size) {
      ListDecoder decoder = followed.decoder;
      ++tried;
      if (!decoder.decode(ExactBytes(std::span(followed.next).first(size)).view()).ok()) continue;
      ++accepted;
      ASSERT_TRUE(isCanonical(decoder.list(), 3000));
      ASSERT_NE(decoder.toggled(), followed.toggled);
    }
  }
  EXPECT_LT(accepted, tried / 20);
}

TEST(ListCoder, ALongerDeltaIsRefused) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Followed followed = follow(3000, 5, 3, seed);
    for (const unsigned byte : {0U, 1U, 0x80U, 0xFFU}) {
      Delta longer = followed.next;
      longer.push_back(static_cast<std::byte>(byte));
      ListDecoder decoder = followed.decoder;
      if (!decoder.decode(ExactBytes(longer).view()).ok()) continue;
      ASSERT_TRUE(isCanonical(decoder.list(), 3000));
      ASSERT_NE(decoder.toggled(), followed.toggled);
    }
  }
}

// What is accepted is what the encoder would have written.
TEST(ListCoder, EveryShortDeltaIsRefusedOrTheOnlyEncoding) {
  Delta delta;
  unsigned accepted = 0;
  for (const std::uint32_t leafCount : {7U, 16U, 21U, 43U, 300U}) {
    ListEncoder encoder(leafCount);
    ListDecoder decoder(leafCount);
    encoder.encode({{1, 3}, {4, 6}}, delta);
    ASSERT_TRUE(decoder.decode(delta).ok());
    for (unsigned number = 0; number < 1U << 16U; ++number) {
      for (const std::size_t size : {1U, 2U}) {
        delta = {static_cast<std::byte>(number & 0xFFU), static_cast<std::byte>(number >> 8U)};
        delta.resize(size);
        if (delta.front() == kPlainDelta || (size == 1 && number > 0xFF)) continue;
        ListDecoder trial = decoder;
        if (!trial.decode(delta).ok()) {
          ASSERT_TRUE(trial.toggled().empty());
          continue;
        }
        ++accepted;
        ASSERT_TRUE(isCanonical(trial.list(), leafCount));
        ListEncoder again = encoder;
        Delta same;
        again.encode(trial.toggled(), same);
        ASSERT_EQ(same, delta) << leafCount;
      }
    }
  }
  EXPECT_GT(accepted, 100U);
}

TEST(ListCoder, MorePiecesThanTheBytesAreWorthAreRefusedAtOnce) {
  Delta delta;
  ListModel model;
  RangeEncoder coder(delta);
  model.codeCount(coder, 1'000'000);
  coder.finish();
  ListDecoder decoder(UINT32_MAX);
  const Status status = decoder.decode(delta);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().text().find("too many pieces"), std::string::npos) << status.error().text();
}

TEST(ListCoder, GarbageIsRefusedOrCanonicalAndBounded) {
  std::mt19937 random(45);
  for (const std::uint32_t leafCount : {0U, 1U, 100U, 100'000U, UINT32_MAX}) {
    ListDecoder followed =
        leafCount == 100'000 ? follow(leafCount, 50, 3, 1).decoder : ListDecoder(leafCount);
    for (int i = 0; i < 20'000; ++i) {
      Delta garbage(1 + random() % 40);
      const auto kind = static_cast<unsigned>(random() % 3);
      for (std::byte& byte : garbage)
        byte = static_cast<std::byte>(kind == 0 ? random() : kind == 1 ? random() % 3 : 0xFE + random() % 2);
      ListDecoder decoder = followed;
      const ExactBytes exact(garbage);
      const Status status = decoder.decode(exact.view());
      if (!status) {
        ASSERT_TRUE(decoder.toggled().empty());
        ASSERT_TRUE(protocolErrorOf(status.error()).has_value());
        continue;
      }
      ASSERT_TRUE(isCanonical(decoder.list(), leafCount));
      ASSERT_LE(decoder.toggled().size(), mostPieces(garbage.size()));
    }
  }
}

TEST(ListCoder, FlippedBitsAreRefusedOrAnotherDelta) {
  const Followed followed = follow(2000, 30, 60, 7);
  for (std::size_t bit = 0; bit < 8 * followed.next.size(); ++bit) {
    Delta flipped = followed.next;
    flipped[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    ListDecoder decoder = followed.decoder;
    if (!decoder.decode(ExactBytes(flipped).view()).ok()) continue;
    ASSERT_TRUE(isCanonical(decoder.list(), 2000));
    ASSERT_NE(decoder.toggled(), followed.toggled);
  }
}

TEST(ListCoder, BuffersAreReused) {
  Views views(1000, 42);
  ListEncoder encoder(1000);
  Delta delta;
  encoder.encode(views.toggle(300), delta);
  const VisibleList few = views.toggle(5);
  encoder.encode(few, delta);
  const auto* bytes = delta.data();
  std::set<const void*> lists;
  for (int i = 0; i < 10; ++i) {
    encoder.encode(few, delta);
    lists.insert(encoder.list().data());
  }
  EXPECT_EQ(delta.data(), bytes);
  EXPECT_LE(lists.size(), 2U);
}

}  // namespace
}  // namespace tessera::proto
