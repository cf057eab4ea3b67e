#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tessera::proto {

/// CRC-32C (Castagnoli, as in iSCSI, RFC 3720) of `bytes`. `previous` is the CRC of the bytes before them, so
/// that a long row may be given in pieces. Uses the processor's instruction where it has one.
[[nodiscard]] std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t previous = 0);

// The two ways behind crc32c, which tests compare.
namespace detail {

/// Tables, eight bytes a step; on every machine.
[[nodiscard]] std::uint32_t crc32cByTables(std::span<const std::byte> bytes, std::uint32_t previous = 0);

/// True where crc32cByInstruction may be called (x86-64 with SSE4.2).
[[nodiscard]] bool hasCrc32cInstruction();
[[nodiscard]] std::uint32_t crc32cByInstruction(std::span<const std::byte> bytes, std::uint32_t previous = 0);

}  // namespace detail

}  // namespace tessera::proto
