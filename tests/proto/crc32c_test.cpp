#include "proto/crc32c.h"

#include <cstddef>
#include <random>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace tessera::proto {
namespace {

using Crc = std::uint32_t (*)(std::span<const std::byte>, std::uint32_t);

std::vector<Crc> allWays() {
  std::vector<Crc> ways = {&crc32c, &detail::crc32cByTables};
  if (detail::hasCrc32cInstruction()) ways.push_back(&detail::crc32cByInstruction);
  return ways;
}

std::span<const std::byte> bytesOf(std::string_view text) {
  return std::as_bytes(std::span(text));
}

/// One bit at a time, straight from the definition.
std::uint32_t crcByBits(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (const std::byte byte : bytes) {
    crc ^= std::to_integer<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit)
      crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0x82F63B78U : 0U);
  }
  return ~crc;
}

std::vector<std::byte> randomBytes(std::size_t count, std::mt19937& random) {
  std::vector<std::byte> bytes(count);
  for (std::byte& byte : bytes)
    byte = static_cast<std::byte>(random() & 0xFFU);
  return bytes;
}

TEST(Crc32c, PublishedVectors) {
  std::vector<std::byte> ascending(32), descending(32);
  for (std::size_t i = 0; i < 32; ++i) {
    ascending[i] = static_cast<std::byte>(i);
    descending[i] = static_cast<std::byte>(31 - i);
  }
  for (const Crc crc : allWays()) {
    EXPECT_EQ(crc(bytesOf(""), 0), 0U);
    EXPECT_EQ(crc(bytesOf("123456789"), 0), 0xE3069283U);
    // RFC 3720, B.4.
    EXPECT_EQ(crc(std::vector<std::byte>(32, std::byte{0}), 0), 0x8A9136AAU);
    EXPECT_EQ(crc(std::vector<std::byte>(32, std::byte{0xFF}), 0), 0x62A8AB43U);
    EXPECT_EQ(crc(ascending, 0), 0x46DD794EU);
    EXPECT_EQ(crc(descending, 0), 0x113FDB5CU);
  }
}

TEST(Crc32c, EveryWayAgreesAtEveryLengthAndOffset) {
  std::mt19937 random(1);
  const std::vector<std::byte> bytes = randomBytes(300, random);
  for (std::size_t offset = 0; offset < 9; ++offset) {
    for (std::size_t count = 0; count + offset <= bytes.size(); ++count) {
      const auto part = std::span(bytes).subspan(offset, count);
      const std::uint32_t expected = crcByBits(part);
      for (const Crc crc : allWays())
        ASSERT_EQ(crc(part, 0), expected) << offset << " " << count;
    }
  }
}

TEST(Crc32c, PiecesGiveTheWhole) {
  std::mt19937 random(2);
  const std::vector<std::byte> bytes = randomBytes(100, random);
  for (const Crc crc : allWays()) {
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
      const std::uint32_t front = crc(std::span(bytes).first(cut), 0);
      ASSERT_EQ(crc(std::span(bytes).subspan(cut), front), crc(bytes, 0)) << cut;
    }
  }
}

TEST(Crc32c, EveryWayAgreesOnALargeBuffer) {
  std::mt19937 random(3);
  const std::vector<std::byte> bytes = randomBytes((1U << 20U) + 5, random);
  for (const Crc crc : allWays())
    EXPECT_EQ(crc(bytes, 0), crcByBits(bytes));
}

// The instruction goes by blocks of several lanes.
TEST(Crc32c, LongStretchesAreTheSumOfTheirParts) {
  std::mt19937 random(12);
  const std::vector<std::byte> bytes = randomBytes(20'000, random);
  for (const std::size_t size : {1024U, 3071U, 3072U, 3073U, 3079U, 6143U, 6144U, 6151U, 12'345U, 20'000U}) {
    for (const std::size_t offset : {0U, 1U, 7U}) {
      const auto part = std::span(bytes).subspan(offset).first(size - offset);
      const std::uint32_t expected = crcByBits(part);
      for (const Crc crc : allWays()) {
        EXPECT_EQ(crc(part, 0), expected) << size;
        for (const std::size_t cut : {std::size_t{1}, part.size() / 2, part.size() - 3})
          EXPECT_EQ(crc(part.subspan(cut), crc(part.first(cut), 0)), expected) << size << " cut at " << cut;
      }
    }
  }
}

}  // namespace
}  // namespace tessera::proto
