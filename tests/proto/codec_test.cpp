#include "proto/codec.h"

#include <limits>

#include <gtest/gtest.h>

#include "proto/list_codec.h"
#include "proto/utf8.h"
#include "tests/proto/test_messages.h"

namespace tessera::proto {
namespace {

using test::encodeAny;
using test::ExactBytes;
using test::isSame;
using test::kAllTypes;
using test::MessageMaker;
using test::payloadOf;

class EveryMessage : public testing::TestWithParam<MessageType> {};

INSTANTIATE_TEST_SUITE_P(Types, EveryMessage, testing::ValuesIn(kAllTypes),
                         [](const auto& type) { return std::string(nameOf(type.param)); });

TEST_P(EveryMessage, RoundTrips) {
  MessageMaker maker(10);
  for (int i = 0; i < 300; ++i) {
    const AnyMessage message = maker.any(GetParam());
    const Bytes bytes = encodeAny(message);
    const auto frame = parseFrame(bytes);
    ASSERT_TRUE(frame.ok()) << frame.error().text();
    ASSERT_EQ(frame->type, GetParam());
    const auto decoded = decode(frame->type, frame->payload);
    ASSERT_TRUE(decoded.ok()) << decoded.error().text();
    EXPECT_TRUE(isSame(*decoded, message));
    EXPECT_EQ(encodeAny(*decoded), bytes);
  }
}

TEST_P(EveryMessage, EveryPrefixIsRefused) {
  MessageMaker maker(11);
  for (int round = 0; round < 5; ++round) {
    const Bytes bytes = encodeAny(maker.any(GetParam()));
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const ExactBytes exact{std::span(bytes).first(size)};
      const auto frame = parseFrame(exact.view());
      ASSERT_FALSE(frame.ok()) << size;
      EXPECT_EQ(protocolErrorOf(frame.error()), ProtocolError::Truncated);
    }
    const auto payload = payloadOf(bytes);
    for (std::size_t size = 0; size < payload.size(); ++size) {
      const ExactBytes exact(payload.first(size));
      const auto decoded = decode(GetParam(), exact.view());
      ASSERT_FALSE(decoded.ok()) << size;
      EXPECT_EQ(protocolErrorOf(decoded.error()), ProtocolError::Truncated);
    }
  }
}

TEST_P(EveryMessage, ExtraBytesAreRefused) {
  MessageMaker maker(12);
  const Bytes bytes = encodeAny(maker.any(GetParam()));
  for (std::size_t extra = 1; extra < 20; ++extra) {
    Bytes longer = bytes;
    longer.resize(bytes.size() + extra);
    const auto frame = parseFrame(longer);
    ASSERT_FALSE(frame.ok());
    EXPECT_EQ(protocolErrorOf(frame.error()), ProtocolError::TrailingBytes);
    const auto decoded = decode(GetParam(), payloadOf(longer));
    ASSERT_FALSE(decoded.ok());
    const auto error = protocolErrorOf(decoded.error());
    EXPECT_TRUE(error == ProtocolError::TrailingBytes || error == ProtocolError::TooLarge);
  }
}

TEST_P(EveryMessage, EveryFlippedBitIsRefused) {
  MessageMaker maker(13);
  for (int round = 0; round < 3; ++round) {
    const Bytes bytes = encodeAny(maker.any(GetParam()));
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      ExactBytes exact(bytes);
      Bytes flipped = bytes;
      flipped[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
      const auto frame = parseFrame(flipped);
      ASSERT_FALSE(frame.ok()) << bit;
      ASSERT_TRUE(protocolErrorOf(frame.error()).has_value());
    }
  }
}

TEST_P(EveryMessage, AnotherTypeOfPayloadDoesNoHarm) {
  MessageMaker maker(14);
  for (const MessageType other : kAllTypes) {
    const Bytes bytes = encodeAny(maker.any(other));
    const ExactBytes payload(payloadOf(bytes));
    if (const auto decoded = decode(GetParam(), payload.view())) {
      EXPECT_FALSE(encodeAny(*decoded).empty());
    }
  }
}

TEST_P(EveryMessage, RandomPayloadsAreRefused) {
  MessageMaker maker(15);
  for (int i = 0; i < 10000; ++i) {
    const ExactBytes payload(maker.bytes(maker.below(120)));
    ASSERT_FALSE(decode(GetParam(), payload.view()).ok());
  }
}

// Past the checksum, as a hostile peer can be: whatever is accepted must be good for another round trip.
TEST_P(EveryMessage, DamagedPayloadsAreRefusedOrSound) {
  MessageMaker maker(16);
  for (int round = 0; round < 100; ++round) {
    const Bytes bytes = encodeAny(maker.any(GetParam()));
    const auto payload = payloadOf(bytes);
    for (int i = 0; i < 100; ++i) {
      std::vector<std::byte> damaged(payload.begin(), payload.end());
      for (std::uint64_t hits = 1 + maker.below(4); hits > 0; --hits) {
        damaged[maker.below(damaged.size())] = static_cast<std::byte>(maker.below(256));
      }
      const ExactBytes exact(damaged);
      const auto decoded = decode(GetParam(), exact.view());
      if (!decoded) {
        ASSERT_TRUE(protocolErrorOf(decoded.error()).has_value());
        continue;
      }
      const Bytes again = encodeAny(*decoded);
      const auto decodedAgain = decode(GetParam(), payloadOf(again));
      ASSERT_TRUE(decodedAgain.ok()) << decodedAgain.error().text();
      EXPECT_TRUE(isSame(*decoded, *decodedAgain));
    }
  }
}

TEST_P(EveryMessage, AnOddAddressIsRefusedAndFourIsEnough) {
  MessageMaker maker(17);
  const AnyMessage message = maker.any(GetParam());
  const Bytes bytes = encodeAny(message);
  const auto payload = payloadOf(bytes);
  for (std::size_t shift = 0; shift < 9; ++shift) {
    std::vector<std::byte> moved(payload.size() + shift);
    std::copy(payload.begin(), payload.end(), moved.begin() + static_cast<std::ptrdiff_t>(shift));
    const auto decoded = decode(GetParam(), std::span<const std::byte>(moved).subspan(shift));
    ASSERT_EQ(decoded.ok(), shift % 4 == 0);
    if (decoded) {
      EXPECT_TRUE(isSame(*decoded, message));
    } else {
      EXPECT_EQ(protocolErrorOf(decoded.error()), ProtocolError::Misaligned);
    }
  }
}

TEST(Codec, UnknownTypeIsRefused) {
  const auto decoded = decode(static_cast<MessageType>(99), {});
  ASSERT_FALSE(decoded.ok());
  EXPECT_EQ(protocolErrorOf(decoded.error()), ProtocolError::UnknownType);
}

TEST(Codec, EmptyBulkRoundTrips) {
  EXPECT_TRUE(decodeAssets(payloadOf(encode(Assets{}))).ok());
  EXPECT_TRUE(decodeLeaves(payloadOf(encode(Leaves{}))).ok());
  const Bytes frame = encode(Frame{.frame = 1});
  EXPECT_TRUE(decodeFrame(payloadOf(frame))->toggles.empty());
}

TEST(Codec, AssetBytesAreNotCopied) {
  MessageMaker maker(20);
  const Assets assets = {{{.bytes = maker.bytes(5000)}}};
  const Bytes message = encode(assets);
  const auto decoded = decodeAssets(payloadOf(message));
  ASSERT_TRUE(decoded.ok());
  const auto view = decoded->assets[0].bytes;
  EXPECT_GE(view.data(), message.data());
  EXPECT_LE(view.data() + view.size(), message.data() + message.size());
}

TEST(Codec, ABigAssetAndAFullLeafBatchFit) {
  MessageMaker maker(21);
  const std::vector<std::byte> big(20U << 20U, std::byte{9});
  const Bytes bytes = encode(Assets{{{.kind = AssetKind::Image, .bytes = big}}});
  EXPECT_TRUE(
      test::sameBytes(decodeAssets(payloadOf(bytes))->assets[0].bytes, std::span<const std::byte>(big)));

  Leaves leaves;
  for (std::size_t i = 0; i < kMaxLeavesPerMessage; ++i)
    leaves.leaves.push_back(maker.leaf());
  const Bytes batch = encode(leaves);
  const auto decoded = decodeLeaves(payloadOf(batch));
  ASSERT_TRUE(decoded.ok()) << decoded.error().text();
  EXPECT_TRUE(isSame(*decoded, leaves));
  leaves.leaves.push_back(maker.leaf());
  EXPECT_TRUE(encode(leaves).empty());
}

TEST(Codec, MoreAssetsThanAMessageHoldsGiveNoBytes) {
  static_assert(kMaxAssetBytes + 4096 <= kMaxPayloadBytes);
  const std::vector<std::byte> big(65U << 20U);
  const Asset asset = {.bytes = big};
  EXPECT_TRUE(encode(Assets{{asset, asset, asset, asset}}).empty());
  EXPECT_TRUE(encode(Assets{std::vector<Asset>(kMaxAssetsPerMessage + 1)}).empty());
}

TEST(Codec, AListDeltaTravelsInAFrame) {
  const VisibleList before = {{0, 10}, {20, 30}};
  const VisibleList now = {{5, 10}, {20, 31}, {40, 41}};
  std::vector<std::byte> delta;
  encodeListDelta(before, now, delta);
  const Bytes bytes = encode(Frame{.frame = 2, .baseFrame = 1, .toggles = delta, .listLeafCount = 17});
  const auto frame = decodeFrame(payloadOf(bytes));
  ASSERT_TRUE(frame.ok()) << frame.error().text();
  EXPECT_EQ(*applyListDelta(before, frame->toggles, 41), now);
  EXPECT_EQ(leafCount(now), frame->listLeafCount);
}

TEST(Codec, TextsThatQuoteAnythingAreMadeFit) {
  const std::string hostile = "bad \xff\xc0\xaf " + std::string(5000, 'x') + "\xe2\x98\x83";
  const Bytes bytes = encode(ErrorMessage{.code = ErrorCode::Internal, .text = hostile});
  const auto error = decodeError(payloadOf(bytes));
  ASSERT_TRUE(error.ok()) << error.error().text();
  EXPECT_EQ(error->text.size(), kMaxTextBytes);
  EXPECT_TRUE(error->text.starts_with("bad ??? xxx"));
  EXPECT_TRUE(decodeBye(payloadOf(encode(Bye{.reason = hostile}))).ok());
}

TEST(Utf8, FollowsTheTableOfUnicode) {
  for (const char* good : {"", "a", "\xc2\x80", "\xdf\xbf", "\xe0\xa0\x80", "\xed\x9f\xbf", "\xee\x80\x80",
                           "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf"}) {
    EXPECT_TRUE(isUtf8(good)) << good;
  }
  for (const char* bad : {"\x80", "\xbf", "\xc0\x80", "\xc1\xbf", "\xc2", "\xc2\x7f", "\xe0\x9f\xbf",
                          "\xe0\xa0", "\xed\xa0\x80", "\xed\xbf\xbf", "\xf0\x8f\xbf\xbf", "\xf0\x90\x80",
                          "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff", "ok\xfe"}) {
    EXPECT_FALSE(isUtf8(bad));
  }
}

TEST(Utf8, FittingNeverSplitsACharacter) {
  const std::string snow = "a\xe2\x98\x83\xe2\x98\x83";
  EXPECT_EQ(fitUtf8(snow, 100), snow);
  EXPECT_EQ(fitUtf8(snow, 6), "a\xe2\x98\x83");
  EXPECT_EQ(fitUtf8(snow, 3), "a");
  EXPECT_EQ(fitUtf8("\xe2\x98", 9), "??");
}

}  // namespace
}  // namespace tessera::proto
