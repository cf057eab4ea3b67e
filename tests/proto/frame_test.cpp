#include "proto/frame.h"

#include <algorithm>
#include <array>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "proto/crc32c.h"
#include "proto/little_endian.h"
#include "tests/proto/test_messages.h"

namespace tessera::proto {
namespace {

using test::ExactBytes;
using test::kAllTypes;

using HeaderBytes = std::array<std::byte, kHeaderBytes>;

template <class T>
ProtocolError errorOf(const Result<T>& result) {
  EXPECT_FALSE(result.ok());
  const auto error = protocolErrorOf(result.error());
  EXPECT_TRUE(error.has_value()) << result.error().text();
  return *error;
}

HeaderBytes written(const FrameHeader& header) {
  HeaderBytes bytes;
  writeHeader(header, bytes);
  return bytes;
}

/// Puts the right checksum on a header that was tampered with.
HeaderBytes resealed(HeaderBytes bytes) {
  storeLittleEndian(crc32c(std::span(bytes).first<16>()), std::span(bytes).subspan<16, 4>());
  return bytes;
}

TEST(Frame, HeaderIsWrittenByteByByteAsDocumented) {
  const HeaderBytes bytes =
      written({.type = MessageType::Frame, .payloadBytes = 0x00030201, .payloadCrc32c = 0xA4A3A2A1});
  const std::array<unsigned, 16> expected = {'T', 'S', 'R', 'A', 2,    0,    5,    0,
                                             1,   2,   3,   0,   0xA1, 0xA2, 0xA3, 0xA4};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(std::to_integer<unsigned>(bytes[i]), expected[i]) << i;
  }
}

TEST(Frame, HeaderRoundTrips) {
  for (const MessageType type : kAllTypes) {
    for (const std::uint32_t size : {0U, 1U, maxPayloadBytes(type)}) {
      const FrameHeader header = {.type = type, .payloadBytes = size, .payloadCrc32c = 77 * size};
      const auto parsed = parseHeader(written(header));
      ASSERT_TRUE(parsed.ok()) << parsed.error().text();
      EXPECT_EQ(*parsed, header);
    }
  }
}

TEST(Frame, AnotherProgramIsRefusedFirst) {
  const std::string_view request = "GET / HTTP/1.1\r\nHost:";
  HeaderBytes bytes;
  std::copy_n(std::as_bytes(std::span(request)).begin(), kHeaderBytes, bytes.begin());
  EXPECT_EQ(errorOf(parseHeader(bytes)), ProtocolError::BadMagic);
}

TEST(Frame, AnotherVersionIsNamedWhateverFollows) {
  HeaderBytes bytes = {};
  bytes.fill(std::byte{0xEE});
  storeLittleEndian(kMagic, std::span(bytes).first<4>());
  storeLittleEndian(std::uint16_t{7}, std::span(bytes).subspan<4, 2>());
  const auto parsed = parseHeader(bytes);
  EXPECT_EQ(errorOf(parsed), ProtocolError::WrongVersion);
  EXPECT_NE(parsed.error().text().find("theirs 7, ours 2"), std::string::npos) << parsed.error().text();
}

TEST(Frame, UnknownTypesAreRefused) {
  for (const unsigned type : {0U, 18U, 19U, 21U, 255U, 256U + 5U, 65535U}) {
    const HeaderBytes bytes = written({.type = static_cast<MessageType>(type)});
    EXPECT_EQ(errorOf(parseHeader(bytes)), ProtocolError::UnknownType) << type;
  }
}

TEST(Frame, OversizeIsRefusedWithBothNumbers) {
  for (const MessageType type : kAllTypes) {
    for (const std::uint32_t size : {maxPayloadBytes(type) + 1, kMaxPayloadBytes + 1, 0xFFFFFFFFU}) {
      const auto parsed = parseHeader(written({.type = type, .payloadBytes = size}));
      EXPECT_EQ(errorOf(parsed), ProtocolError::TooLarge);
      EXPECT_NE(parsed.error().text().find(std::to_string(size)), std::string::npos);
      EXPECT_NE(parsed.error().text().find(std::to_string(maxPayloadBytes(type))), std::string::npos);
    }
  }
}

TEST(Frame, LimitsBeforeTheHandshakeAreSmall) {
  EXPECT_LE(maxPayloadBytes(MessageType::Hello), 4096U);
  EXPECT_LE(maxPayloadBytes(MessageType::Welcome), 4096U);
  EXPECT_LE(maxPayloadBytes(MessageType::Error), 4096U);
  EXPECT_EQ(maxPayloadBytes(static_cast<MessageType>(18)), 0U);
}

TEST(Frame, OnlyWhatIsExpectedIsAccepted) {
  struct Row {
    Expect expect;
    std::set<MessageType> types;
  };
  using enum MessageType;
  const Row rows[] = {{Expect::Hello, {Hello}},
                      {Expect::WelcomeOrError, {Welcome, Error}},
                      {Expect::FromTile, {Ready, Shown, Pong, Bye, Error, Input, Lacks}},
                      {Expect::FromMaster,
                       {Assets, Leaves, MessageType::Frame, Swap, Ping, Bye, Error, TileSetup, Poses, Keep}},
                      {Expect::Have, {Have}},
                      {Expect::Anything, std::set<MessageType>(std::begin(kAllTypes), std::end(kAllTypes))}};
  for (const Row& row : rows) {
    for (const MessageType type : kAllTypes) {
      const auto parsed = parseHeader(written({.type = type}), row.expect);
      EXPECT_EQ(parsed.ok(), row.types.contains(type)) << nameOf(type);
      if (!parsed) {
        EXPECT_EQ(errorOf(parsed), ProtocolError::UnexpectedType);
      }
    }
  }
}

TEST(Frame, EveryFlippedBitOfAHeaderIsRefused) {
  const HeaderBytes good = written({.type = MessageType::Frame, .payloadBytes = 1000, .payloadCrc32c = 99});
  for (std::size_t bit = 0; bit < 8 * kHeaderBytes; ++bit) {
    HeaderBytes bytes = good;
    bytes[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    const ProtocolError expected = bit < 32   ? ProtocolError::BadMagic
                                   : bit < 48 ? ProtocolError::WrongVersion
                                              : ProtocolError::BadHeaderChecksum;
    EXPECT_EQ(errorOf(parseHeader(bytes)), expected) << bit;
  }
}

TEST(Frame, PayloadIsCheckedForSizeAndSum) {
  const std::vector<std::byte> payload(10, std::byte{3});
  const FrameHeader header = headerFor(MessageType::Ready, payload);
  EXPECT_TRUE(checkPayload(header, payload).ok());
  EXPECT_EQ(errorOf(checkPayload(header, std::span(payload).first(9))), ProtocolError::Truncated);
  EXPECT_EQ(errorOf(checkPayload(header, std::vector<std::byte>(11, std::byte{3}))),
            ProtocolError::TrailingBytes);
  EXPECT_EQ(errorOf(checkPayload(header, std::vector<std::byte>(10, std::byte{4}))),
            ProtocolError::BadPayloadChecksum);
}

TEST(Frame, ResealedRandomHeadersNeverPassALimit) {
  std::mt19937 random(5);
  for (int i = 0; i < 100000; ++i) {
    HeaderBytes bytes;
    for (std::byte& byte : bytes)
      byte = static_cast<std::byte>(random() & 0xFFU);
    storeLittleEndian(kMagic, std::span(bytes).first<4>());
    storeLittleEndian(kProtocolVersion, std::span(bytes).subspan<4, 2>());
    storeLittleEndian(static_cast<std::uint16_t>(random() % 16), std::span(bytes).subspan<6, 2>());
    const auto parsed = parseHeader(resealed(bytes));
    if (parsed) {
      ASSERT_LE(parsed->payloadBytes, maxPayloadBytes(parsed->type));
    }
  }
}

TEST(Frame, RandomGarbageIsRefused) {
  std::mt19937 random(6);
  for (int i = 0; i < 100000; ++i) {
    std::vector<std::byte> bytes(random() % 64);
    for (std::byte& byte : bytes)
      byte = static_cast<std::byte>(random() & 0xFFU);
    const ExactBytes exact(bytes);
    ASSERT_FALSE(parseFrame(exact.view()).ok());
  }
}

TEST(ProtocolErrors, SentencesAreDistinctAndLeadBack) {
  for (int i = 0; i < kProtocolErrorCount; ++i) {
    const auto error = static_cast<ProtocolError>(i);
    EXPECT_EQ(protocolErrorOf(protocolError(error, "x", "detail")), error) << sentence(error);
    EXPECT_EQ(protocolErrorOf(protocolError(error, "x")), error) << sentence(error);
  }
  EXPECT_FALSE(protocolErrorOf(runtimeError("x", "the disk is full")).has_value());
}

}  // namespace
}  // namespace tessera::proto
