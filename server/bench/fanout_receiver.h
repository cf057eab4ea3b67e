#pragma once

#include <cstdint>
#include <vector>

#include "proto/codec.h"

namespace tessera::bench {

/// What a receiver does with what it gets.
enum class FanoutReceiver {
  Bare,       ///< reads into one small buffer
  BareWhole,  ///< reads into a buffer as large as a message, as whoever uses messages must
  Messages,
  CheckedAssets
};

/// The most that is read or written at once.
inline constexpr std::size_t kBareStretchBytes = 1 << 20;

/// Connects to a port of this machine, receives `bytes` bytes, which are `messages` messages, and tells by
/// one byte that it has them. False after any failure.
[[nodiscard]] bool receiveFanout(FanoutReceiver receiver, std::uint16_t port, std::uint64_t bytes,
                                 std::uint64_t messages);

}  // namespace tessera::bench
