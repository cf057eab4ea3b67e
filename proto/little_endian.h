#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace tessera::proto {

/// Writes an unsigned number at the front of `out`, lowest byte first.
template <class U>
void storeLittleEndian(U number, std::span<std::byte, sizeof(U)> out) {
  static_assert(std::is_unsigned_v<U>);
  for (std::size_t i = 0; i < sizeof(U); ++i) {
    out[i] = static_cast<std::byte>((number >> (8U * i)) & 0xFFU);
  }
}

template <class U>
[[nodiscard]] U loadLittleEndian(std::span<const std::byte, sizeof(U)> bytes) {
  static_assert(std::is_unsigned_v<U>);
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < sizeof(U); ++i)
    number |= std::to_integer<std::uint64_t>(bytes[i]) << (8U * i);
  return static_cast<U>(number);
}

}  // namespace tessera::proto
