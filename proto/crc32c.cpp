#include "proto/crc32c.h"

#include <array>
#include <cstring>

#if defined(__x86_64__)
#include <nmmintrin.h>
#endif

namespace tessera::proto {

namespace {

constexpr std::uint32_t kReversedPolynomial = 0x82F63B78;

using Tables = std::array<std::array<std::uint32_t, 256>, 8>;

// tables[k][b] is the CRC of the byte b followed by k zero bytes, which lets eight bytes be looked up at once
// ("slicing by 8", Kounavis and Berry, 2005).
constexpr Tables makeTables() {
  Tables tables = {};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit)
      crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? kReversedPolynomial : 0U);
    tables[0][byte] = crc;
  }
  for (std::size_t k = 1; k < tables.size(); ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = tables[k - 1][byte];
      tables[k][byte] = (before >> 8U) ^ tables[0][before & 0xFFU];
    }
  }
  return tables;
}

constexpr Tables kTables = makeTables();

std::uint32_t oneByte(std::uint32_t crc, std::byte byte) {
  return (crc >> 8U) ^ kTables[0][(crc ^ std::to_integer<std::uint32_t>(byte)) & 0xFFU];
}

std::uint32_t eightBytes(std::uint32_t crc, const std::byte* bytes) {
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    const std::uint32_t mixedIn = i < 4 ? crc >> (8U * i) : 0U;
    next ^= kTables[7 - i][(mixedIn ^ std::to_integer<std::uint32_t>(bytes[i])) & 0xFFU];
  }
  return next;
}

}  // namespace

namespace detail {

std::uint32_t crc32cByTables(std::span<const std::byte> bytes, std::uint32_t previous) {
  std::uint32_t crc = ~previous;
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8)
    crc = eightBytes(crc, bytes.data() + i);
  for (; i < bytes.size(); ++i)
    crc = oneByte(crc, bytes[i]);
  return ~crc;
}

#if defined(__x86_64__)

bool hasCrc32cInstruction() {
  static const bool has = __builtin_cpu_supports("sse4.2") != 0;
  return has;
}

// The instruction takes 3 cycles, and one can start in each: three lanes of a block are summed up side by
// side. The sum of bytes that others follow is that of as many zeros after it, which is linear in it: a
// matrix of bits, looked up by bytes.
constexpr std::size_t kLaneBytes = 1024;

using BitMatrix = std::array<std::uint32_t, 32>;  // columns

constexpr std::uint32_t times(const BitMatrix& matrix, std::uint32_t vector) {
  std::uint32_t product = 0;
  for (std::size_t i = 0; i < matrix.size(); ++i)
    product ^= ((vector >> i) & 1U) != 0 ? matrix[i] : 0;
  return product;
}

constexpr std::array<std::array<std::uint32_t, 256>, 4> makeLaneTables() {
  BitMatrix zeros = {};  // what one zero byte does, then two, four, ...
  for (std::size_t i = 0; i < zeros.size(); ++i) {
    const std::uint32_t bit = std::uint32_t{1} << i;
    zeros[i] = (bit >> 8U) ^ kTables[0][bit & 0xFFU];
  }
  for (std::size_t bytes = 1; bytes < kLaneBytes; bytes *= 2) {
    BitMatrix twice = {};
    for (std::size_t i = 0; i < twice.size(); ++i)
      twice[i] = times(zeros, zeros[i]);
    zeros = twice;
  }
  std::array<std::array<std::uint32_t, 256>, 4> tables = {};
  for (std::size_t k = 0; k < tables.size(); ++k) {
    for (std::uint32_t byte = 0; byte < 256; ++byte)
      tables[k][byte] = times(zeros, byte << (8 * k));
  }
  return tables;
}

constexpr auto kLaneTables = makeLaneTables();

std::uint32_t afterLane(std::uint64_t crc) {
  return kLaneTables[0][crc & 0xFFU] ^ kLaneTables[1][(crc >> 8U) & 0xFFU] ^
         kLaneTables[2][(crc >> 16U) & 0xFFU] ^ kLaneTables[3][(crc >> 24U) & 0xFFU];
}

std::uint64_t wordAt(const std::byte* bytes) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, sizeof(word));
  return word;
}

__attribute__((target("sse4.2"))) std::uint32_t crc32cByInstruction(std::span<const std::byte> bytes,
                                                                    std::uint32_t previous) {
  std::uint64_t crc = ~previous;
  std::size_t i = 0;
  for (; i + 3 * kLaneBytes <= bytes.size(); i += 3 * kLaneBytes) {
    const std::byte* lane = bytes.data() + i;
    std::uint64_t second = 0, third = 0;
    for (std::size_t at = 0; at < kLaneBytes; at += 8) {
      crc = _mm_crc32_u64(crc, wordAt(lane + at));
      second = _mm_crc32_u64(second, wordAt(lane + kLaneBytes + at));
      third = _mm_crc32_u64(third, wordAt(lane + 2 * kLaneBytes + at));
    }
    crc = afterLane(afterLane(crc) ^ second) ^ third;
  }
  for (; i + 8 <= bytes.size(); i += 8)
    crc = _mm_crc32_u64(crc, wordAt(bytes.data() + i));
  auto rest = static_cast<std::uint32_t>(crc);
  for (; i < bytes.size(); ++i)
    rest = _mm_crc32_u8(rest, std::to_integer<std::uint8_t>(bytes[i]));
  return ~rest;
}

#else

bool hasCrc32cInstruction() {
  return false;
}

std::uint32_t crc32cByInstruction(std::span<const std::byte> bytes, std::uint32_t previous) {
  return crc32cByTables(bytes, previous);
}

#endif

}  // namespace detail

std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t previous) {
  return detail::hasCrc32cInstruction() ? detail::crc32cByInstruction(bytes, previous)
                                        : detail::crc32cByTables(bytes, previous);
}

}  // namespace tessera::proto
