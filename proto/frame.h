#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "common/base/result.h"
#include "proto/protocol_error.h"

namespace tessera::proto {

// Framing: every message is a header of 20 bytes and a payload. All numbers are little-endian.
//
//   offset  bytes  field
//        0      4  magic, "TSRA"
//        4      2  protocol version
//        6      2  message type
//        8      4  payload bytes
//       12      4  CRC-32C of the payload
//       16      4  CRC-32C of bytes 0 to 15
//
// Magic and version keep their place for ever, so that every version can say why it refuses another one.
// The header has a checksum of its own because a damaged length must be known before anyone waits for, or
// makes room for, that many bytes.

inline constexpr std::uint32_t kMagic = 0x41525354;  // "TSRA" as the bytes lie on the wire
inline constexpr std::uint16_t kProtocolVersion = 2;
inline constexpr std::size_t kHeaderBytes = 20;

/// Numbers on the wire; they never change their meaning.
enum class MessageType : std::uint16_t {
  Hello = 1,
  Welcome = 2,
  Assets = 3,
  Leaves = 4,
  Frame = 5,
  Ready = 6,
  Swap = 7,
  Shown = 8,
  Ping = 9,
  Pong = 10,
  Bye = 11,
  Error = 12,
  TileSetup = 13,
  Input = 14,
  Have = 15,
  Lacks = 16,
  Keep = 17,
  Poses = 20,
};

[[nodiscard]] constexpr bool isKnown(MessageType type) {
  return (type >= MessageType::Hello && type <= MessageType::Keep) || type == MessageType::Poses;
}

/// What a receiver is ready to accept; decides which message types may come.
enum class Expect {
  Anything,        ///< any known type
  Hello,           ///< the master, before the handshake
  Have,            ///< the master, of a tile that has said Hello and has more to say
  WelcomeOrError,  ///< a tile, before the handshake
  FromTile,        ///< the master, after the handshake
  FromMaster,      ///< a tile, after the handshake
};

[[nodiscard]] constexpr bool isFromTile(MessageType type) {
  return type == MessageType::Ready || type == MessageType::Shown || type == MessageType::Pong ||
         type == MessageType::Bye || type == MessageType::Error || type == MessageType::Input ||
         type == MessageType::Lacks;
}

[[nodiscard]] constexpr bool isFromMaster(MessageType type) {
  return type == MessageType::Assets || type == MessageType::Leaves || type == MessageType::Frame ||
         type == MessageType::Swap || type == MessageType::Ping || type == MessageType::Bye ||
         type == MessageType::Error || type == MessageType::TileSetup || type == MessageType::Poses ||
         type == MessageType::Keep;
}

[[nodiscard]] constexpr bool isExpected(MessageType type, Expect expect) {
  switch (expect) {
    case Expect::Anything:
      return isKnown(type);
    case Expect::Hello:
      return type == MessageType::Hello;
    case Expect::Have:
      return type == MessageType::Have;
    case Expect::WelcomeOrError:
      return type == MessageType::Welcome || type == MessageType::Error;
    case Expect::FromTile:
      return isFromTile(type);
    case Expect::FromMaster:
      return isFromMaster(type);
  }
  return false;
}

/// "Hello", "Welcome", ...; "unknown" for any other number.
[[nodiscard]] std::string_view nameOf(MessageType type);

/// No payload is larger than this.
inline constexpr std::uint32_t kMaxPayloadBytes = 256U << 20U;

/// The largest payload of a type: tight for all that have no bulk, so that a hostile peer cannot make us
/// hold memory; 0 for an unknown type.
[[nodiscard]] constexpr std::uint32_t maxPayloadBytes(MessageType type) {
  switch (type) {
    case MessageType::Assets:
    case MessageType::Shown:
      return kMaxPayloadBytes;
    case MessageType::Leaves:
    case MessageType::Frame:
    case MessageType::TileSetup:
    case MessageType::Poses:
    case MessageType::Have:
    case MessageType::Keep:
      return 64U << 20U;
    case MessageType::Lacks:
      return 64U << 10U;
    case MessageType::Hello:
    case MessageType::Welcome:
    case MessageType::Bye:
    case MessageType::Error:
      return 4096;
    case MessageType::Ready:
    case MessageType::Swap:
    case MessageType::Ping:
    case MessageType::Pong:
    case MessageType::Input:
      return 256;
  }
  return 0;
}

/// A header that has been found good.
struct FrameHeader {
  MessageType type = MessageType::Hello;
  std::uint32_t payloadBytes = 0;
  std::uint32_t payloadCrc32c = 0;
  friend bool operator==(const FrameHeader&, const FrameHeader&) = default;
};

/// The header that belongs before `payload`.
[[nodiscard]] FrameHeader headerFor(MessageType type, std::span<const std::byte> payload);

void writeHeader(const FrameHeader& header, std::span<std::byte, kHeaderBytes> out);

/// Reads and checks a header. Safe for untrusted bytes. Only after this has succeeded make room for
/// `payloadBytes`; they are within the limit of the type. `expect` refuses types that have no business at
/// this point of the conversation.
[[nodiscard]] Result<FrameHeader> parseHeader(std::span<const std::byte, kHeaderBytes> bytes,
                                              Expect expect = Expect::Anything);

/// Checks size and checksum of a payload against its header. Safe for untrusted bytes.
[[nodiscard]] Status checkPayload(const FrameHeader& header, std::span<const std::byte> payload);
/// The same of a payload that was summed up as it came.
[[nodiscard]] Status checkPayload(const FrameHeader& header, std::size_t payloadBytes,
                                  std::uint32_t payloadCrc32c);

/// One message as its type and payload, which refers to the bytes it was parsed from.
struct FrameView {
  MessageType type = MessageType::Hello;
  std::span<const std::byte> payload = {};
};

/// parseHeader and checkPayload for bytes that hold exactly one message: too few are `Truncated`, too many
/// `TrailingBytes`. Safe for untrusted bytes.
[[nodiscard]] Result<FrameView> parseFrame(std::span<const std::byte> bytes,
                                           Expect expect = Expect::Anything);

}  // namespace tessera::proto
