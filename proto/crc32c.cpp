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

__attribute__((target("sse4.2"))) std::uint32_t crc32cByInstruction(std::span<const std::byte> bytes,
                                                                    std::uint32_t previous) {
  std::uint64_t crc = ~previous;
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + i, sizeof(word));
    crc = _mm_crc32_u64(crc, word);
  }
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
