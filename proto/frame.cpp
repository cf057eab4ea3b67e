#include "proto/frame.h"

#include <string>

#include "proto/crc32c.h"
#include "proto/little_endian.h"

namespace tessera::proto {

namespace {

constexpr std::size_t kCheckedHeaderBytes = 16;

std::string whereOf(MessageType type) {
  return std::string(nameOf(type)) + " message";
}

std::string sizeDetail(std::size_t bytes, std::size_t limit) {
  return std::to_string(bytes) + " bytes, at most " + std::to_string(limit);
}

Status checkMagicAndVersion(std::span<const std::byte, kHeaderBytes> bytes) {
  if (loadLittleEndian<std::uint32_t>(bytes.subspan<0, 4>()) != kMagic) {
    return protocolError(ProtocolError::BadMagic, "header");
  }
  const auto version = loadLittleEndian<std::uint16_t>(bytes.subspan<4, 2>());
  if (version != kProtocolVersion) {
    return protocolError(ProtocolError::WrongVersion, "header",
                         "theirs " + std::to_string(version) + ", ours " + std::to_string(kProtocolVersion));
  }
  return Done{};
}

Status checkTypeAndSize(const FrameHeader& header, Expect expect) {
  if (!isKnown(header.type)) {
    return protocolError(ProtocolError::UnknownType, "header",
                         std::to_string(static_cast<std::uint16_t>(header.type)));
  }
  if (!isExpected(header.type, expect)) {
    return protocolError(ProtocolError::UnexpectedType, whereOf(header.type));
  }
  const std::uint32_t limit = maxPayloadBytes(header.type);
  if (header.payloadBytes > limit) {
    return protocolError(ProtocolError::TooLarge, whereOf(header.type),
                         sizeDetail(header.payloadBytes, limit));
  }
  return Done{};
}

}  // namespace

std::string_view nameOf(MessageType type) {
  switch (type) {
    case MessageType::Hello:
      return "Hello";
    case MessageType::Welcome:
      return "Welcome";
    case MessageType::Assets:
      return "Assets";
    case MessageType::Leaves:
      return "Leaves";
    case MessageType::Frame:
      return "Frame";
    case MessageType::Ready:
      return "Ready";
    case MessageType::Swap:
      return "Swap";
    case MessageType::Shown:
      return "Shown";
    case MessageType::Ping:
      return "Ping";
    case MessageType::Pong:
      return "Pong";
    case MessageType::Bye:
      return "Bye";
    case MessageType::Error:
      return "Error";
    case MessageType::TileSetup:
      return "TileSetup";
    case MessageType::Input:
      return "Input";
    case MessageType::Have:
      return "Have";
    case MessageType::Lacks:
      return "Lacks";
    case MessageType::Keep:
      return "Keep";
    case MessageType::Poses:
      return "Poses";
  }
  return "unknown";
}

FrameHeader headerFor(MessageType type, std::span<const std::byte> payload) {
  return {.type = type,
          .payloadBytes = static_cast<std::uint32_t>(payload.size()),
          .payloadCrc32c = crc32c(payload)};
}

void writeHeader(const FrameHeader& header, std::span<std::byte, kHeaderBytes> out) {
  storeLittleEndian(kMagic, out.subspan<0, 4>());
  storeLittleEndian(kProtocolVersion, out.subspan<4, 2>());
  storeLittleEndian(static_cast<std::uint16_t>(header.type), out.subspan<6, 2>());
  storeLittleEndian(header.payloadBytes, out.subspan<8, 4>());
  storeLittleEndian(header.payloadCrc32c, out.subspan<12, 4>());
  storeLittleEndian(crc32c(out.first<kCheckedHeaderBytes>()), out.subspan<16, 4>());
}

Result<FrameHeader> parseHeader(std::span<const std::byte, kHeaderBytes> bytes, Expect expect) {
  // Magic and version first: the rest of the header is ours to read only where they are ours.
  if (Status good = checkMagicAndVersion(bytes); !good) return good.error();
  if (crc32c(bytes.first<kCheckedHeaderBytes>()) != loadLittleEndian<std::uint32_t>(bytes.subspan<16, 4>())) {
    return protocolError(ProtocolError::BadHeaderChecksum, "header");
  }
  const FrameHeader header = {
      .type = static_cast<MessageType>(loadLittleEndian<std::uint16_t>(bytes.subspan<6, 2>())),
      .payloadBytes = loadLittleEndian<std::uint32_t>(bytes.subspan<8, 4>()),
      .payloadCrc32c = loadLittleEndian<std::uint32_t>(bytes.subspan<12, 4>())};
  if (Status good = checkTypeAndSize(header, expect); !good) return good.error();
  return header;
}

Status checkPayload(const FrameHeader& header, std::span<const std::byte> payload) {
  return checkPayload(header, payload.size(), crc32c(payload));
}

Status checkPayload(const FrameHeader& header, std::size_t payloadBytes, std::uint32_t payloadCrc32c) {
  if (payloadBytes < header.payloadBytes) {
    return protocolError(ProtocolError::Truncated, whereOf(header.type));
  }
  if (payloadBytes > header.payloadBytes) {
    return protocolError(ProtocolError::TrailingBytes, whereOf(header.type));
  }
  if (payloadCrc32c != header.payloadCrc32c) {
    return protocolError(ProtocolError::BadPayloadChecksum, whereOf(header.type));
  }
  return Done{};
}

Result<FrameView> parseFrame(std::span<const std::byte> bytes, Expect expect) {
  if (bytes.size() < kHeaderBytes) return protocolError(ProtocolError::Truncated, "header");
  const Result<FrameHeader> header = parseHeader(bytes.first<kHeaderBytes>(), expect);
  if (!header) return header.error();
  const std::span<const std::byte> payload = bytes.subspan(kHeaderBytes);
  if (Status good = checkPayload(*header, payload); !good) return good.error();
  return FrameView{.type = header->type, .payload = payload};
}

}  // namespace tessera::proto
