#pragma once

#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include <flatbuffers/flatbuffers.h>

#include "common/base/result.h"
#include "common/geometry/vec.h"
#include "proto/frame.h"
#include "proto/messages.h"
#include "proto/protocol_error.h"
#include "proto/tessera_generated.h"

namespace tessera::proto {

/// Reads the fields of one payload and keeps the first thing that is wrong with it. Once something is wrong,
/// what the readers return is of no use, but harmless.
class DecodeCheck {
 public:
  explicit DecodeCheck(MessageType type) : type_(type) {}

  /// The root table of `payload` after FlatBuffers has verified every offset in it; null where it has not.
  template <class Table>
  const Table* root(std::span<const std::byte> payload, std::uint32_t maxTables = kMaxTables) {
    if (!checkEnvelope(payload)) return nullptr;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(payload.data());
    flatbuffers::Verifier verifier(bytes, payload.size(), kMaxDepth, maxTables);
    if (!require(verifier.VerifySizePrefixedBuffer<Table>(nullptr), ProtocolError::Malformed)) return nullptr;
    return flatbuffers::GetSizePrefixedRoot<Table>(bytes);
  }

  /// Notes `error` about `field` unless `isGood`; returns `isGood`.
  bool require(bool isGood, ProtocolError error, std::string_view field = {});

  /// 1 to kMaxNameBytes of printable UTF-8; none is fine, too, where `mayBeEmpty`.
  std::string name(const flatbuffers::String* text, std::string_view field, bool mayBeEmpty = false);

  /// Up to kMaxTextBytes of UTF-8.
  std::string text(const flatbuffers::String* text, std::string_view field);

  /// The number of an enumeration on the wire as our own, whose last value is `last`.
  template <class Enum, class WireEnum>
  Enum enumeration(WireEnum value, Enum last, std::string_view field) {
    const auto number = static_cast<std::underlying_type_t<Enum>>(value);
    require(number <= static_cast<std::underlying_type_t<Enum>>(last), ProtocolError::BadEnum, field);
    return static_cast<Enum>(number);
  }

  template <class Float>
  Float finite(Float number, std::string_view field) {
    require(std::isfinite(number), ProtocolError::BadNumber, field);
    return number;
  }

  Vec3 vec3(const wire::Vec3* v, std::string_view field) { return finiteVec3(copyOf(v), field); }
  std::array<Vec3, 4> corners(const wire::Corners* c, std::string_view field);
  Mat4 mat4(const wire::Mat4* m, std::string_view field);
  std::int32_t imagePx(std::int32_t px, std::string_view field);
  std::uint64_t frameNumber(std::uint64_t frame);

  [[nodiscard]] bool ok() const { return !failure_; }
  [[nodiscard]] const Error& error() const { return *failure_; }

  /// The message, or what is wrong with it.
  template <class Message>
  Result<Message> finish(Message message) {
    if (failure_) return *failure_;
    return message;
  }

  /// A struct of the buffer, which lies at a multiple of 4 bytes but not always of 8.
  template <class Struct>
  static Struct copyOf(const Struct* inBuffer) {
    Struct copy;
    std::memcpy(static_cast<void*>(&copy), static_cast<const void*>(inBuffer), sizeof(copy));
    return copy;
  }

 private:
  static constexpr std::uint32_t kMaxTables = 2;
  static constexpr std::uint32_t kMaxDepth = 3;

  bool checkEnvelope(std::span<const std::byte> payload);
  Vec3 finiteVec3(const wire::Vec3& v, std::string_view field);

  MessageType type_;
  std::optional<Error> failure_;
};

[[nodiscard]] Sha256 sha256Of(const wire::Sha256* id);

[[nodiscard]] std::span<const std::byte> bytesOf(const flatbuffers::Vector<std::uint8_t>* bytes);

}  // namespace tessera::proto
