#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <variant>
#include <vector>

#include "common/base/result.h"
#include "proto/frame.h"
#include "proto/messages.h"

namespace tessera::proto {

/// A message ready to be sent: header and payload.
using Bytes = std::vector<std::byte>;

// Encoders. The caller answers for the content: what breaks a rule of messages.h is refused by the receiver.
// Texts of Bye and ErrorMessage are made fit (cut to kMaxTextBytes, valid UTF-8), as they may quote anything.
// A message over the limit of its type gives no bytes at all.
[[nodiscard]] Bytes encode(const Hello& hello);
[[nodiscard]] Bytes encode(const Welcome& welcome);
[[nodiscard]] Bytes encode(const Assets& assets);
[[nodiscard]] Bytes encode(const Leaves& leaves);
[[nodiscard]] Bytes encode(const Frame& frame);
[[nodiscard]] Bytes encode(const Ready& ready);
[[nodiscard]] Bytes encode(const Swap& swap);
[[nodiscard]] Bytes encode(const Shown& shown);
[[nodiscard]] Bytes encode(const Ping& ping);
[[nodiscard]] Bytes encode(const Pong& pong);
[[nodiscard]] Bytes encode(const Bye& bye);
[[nodiscard]] Bytes encode(const ErrorMessage& error);
[[nodiscard]] Bytes encode(const TileSetup& setup);
[[nodiscard]] Bytes encode(const Input& input);
[[nodiscard]] Bytes encode(const Have& have);
[[nodiscard]] Bytes encode(const Lacks& lacks);
[[nodiscard]] Bytes encode(const Keep& keep);
[[nodiscard]] Bytes encode(const Poses& poses);

/// Encodes the messages of every frame to the bytes of encode(), in memory that is kept: does not allocate
/// once warm.
class Encoder {
 public:
  Encoder();
  ~Encoder();
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
  /// The message, until the next call.
  [[nodiscard]] std::span<const std::byte> encode(const Frame& frame);
  [[nodiscard]] std::span<const std::byte> encode(const Swap& swap);

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

// Decoders of a payload (without header). Safe for untrusted bytes: each reads nothing outside of `payload`,
// holds no more memory than a small multiple of it, and refuses with a ProtocolError whatever is malformed or
// breaks a rule of messages.h. What depends on the session (leaf ids, frame order, hashes) is left to the
// caller. Spans in the result refer to `payload`, which must outlive them.
// `payload` must start at a multiple of 4 bytes in memory, as it does in any vector, alone or after its
// header.
[[nodiscard]] Result<Hello> decodeHello(std::span<const std::byte> payload);
[[nodiscard]] Result<Welcome> decodeWelcome(std::span<const std::byte> payload);
[[nodiscard]] Result<Assets> decodeAssets(std::span<const std::byte> payload);
[[nodiscard]] Result<Leaves> decodeLeaves(std::span<const std::byte> payload);
[[nodiscard]] Result<Frame> decodeFrame(std::span<const std::byte> payload);
[[nodiscard]] Result<Ready> decodeReady(std::span<const std::byte> payload);
[[nodiscard]] Result<Swap> decodeSwap(std::span<const std::byte> payload);
[[nodiscard]] Result<Shown> decodeShown(std::span<const std::byte> payload);
[[nodiscard]] Result<Ping> decodePing(std::span<const std::byte> payload);
[[nodiscard]] Result<Pong> decodePong(std::span<const std::byte> payload);
[[nodiscard]] Result<Bye> decodeBye(std::span<const std::byte> payload);
[[nodiscard]] Result<ErrorMessage> decodeError(std::span<const std::byte> payload);
[[nodiscard]] Result<TileSetup> decodeTileSetup(std::span<const std::byte> payload);
[[nodiscard]] Result<Input> decodeInput(std::span<const std::byte> payload);
[[nodiscard]] Result<Have> decodeHave(std::span<const std::byte> payload);
[[nodiscard]] Result<Lacks> decodeLacks(std::span<const std::byte> payload);
[[nodiscard]] Result<Keep> decodeKeep(std::span<const std::byte> payload);
[[nodiscard]] Result<Poses> decodePoses(std::span<const std::byte> payload);

using AnyMessage = std::variant<Hello, Welcome, Assets, Leaves, Frame, Ready, Swap, Shown, Ping, Pong, Bye,
                                ErrorMessage, TileSetup, Input, Have, Lacks, Keep, Poses>;

/// The decoder that belongs to `type`; the terms above hold.
[[nodiscard]] Result<AnyMessage> decode(MessageType type, std::span<const std::byte> payload);

}  // namespace tessera::proto
