#include "proto/decode_check.h"

#include "proto/little_endian.h"
#include "proto/utf8.h"

namespace tessera::proto {

namespace {

constexpr std::size_t kSizePrefixBytes = 4;
constexpr std::uintptr_t kPayloadAlignBytes = 4;

}  // namespace

bool DecodeCheck::require(bool isGood, ProtocolError error, std::string_view field) {
  if (!isGood && !failure_) {
    failure_ = protocolError(error, std::string(nameOf(type_)) + " message", std::string(field));
  }
  return isGood;
}

// FlatBuffers does not know where its buffer ends. The size in front of it does, so that a payload cut within
// padding or with bytes behind it is refused.
bool DecodeCheck::checkEnvelope(std::span<const std::byte> payload) {
  if (!require(payload.size() <= maxPayloadBytes(type_), ProtocolError::TooLarge)) return false;
  if (!require(payload.size() >= kSizePrefixBytes, ProtocolError::Truncated)) return false;
  const bool isAligned = reinterpret_cast<std::uintptr_t>(payload.data()) % kPayloadAlignBytes == 0;
  if (!require(isAligned, ProtocolError::Misaligned)) return false;
  const std::size_t promised = loadLittleEndian<std::uint32_t>(payload.first<kSizePrefixBytes>());
  const std::size_t present = payload.size() - kSizePrefixBytes;
  return require(present >= promised, ProtocolError::Truncated) &&
         require(present <= promised, ProtocolError::TrailingBytes);
}

std::string DecodeCheck::name(const flatbuffers::String* text, std::string_view field, bool mayBeEmpty) {
  const std::string_view view = text->string_view();
  const bool isGood = view.size() <= kMaxNameBytes && (mayBeEmpty || !view.empty()) && isUtf8(view) &&
                      !hasControlCharacter(view);
  return require(isGood, ProtocolError::BadText, field) ? std::string(view) : std::string();
}

std::string DecodeCheck::text(const flatbuffers::String* text, std::string_view field) {
  const std::string_view view = text->string_view();
  const bool isGood = view.size() <= kMaxTextBytes && isUtf8(view);
  return require(isGood, ProtocolError::BadText, field) ? std::string(view) : std::string();
}

Vec3 DecodeCheck::finiteVec3(const wire::Vec3& v, std::string_view field) {
  Vec3 vector(v.x(), v.y(), v.z());
  require(isFinite(vector), ProtocolError::BadNumber, field);
  return vector;
}

std::array<Vec3, 4> DecodeCheck::corners(const wire::Corners* c, std::string_view field) {
  const wire::Corners copy = copyOf(c);
  return {finiteVec3(copy.lower_left(), field), finiteVec3(copy.lower_right(), field),
          finiteVec3(copy.upper_right(), field), finiteVec3(copy.upper_left(), field)};
}

Mat4 DecodeCheck::mat4(const wire::Mat4* m, std::string_view field) {
  const wire::Mat4 copy = copyOf(m);
  Mat4 matrix;
  for (std::uint16_t i = 0; i < 16; ++i)
    matrix(i % 4, i / 4) = copy.column_major()->Get(i);
  require(matrix.allFinite(), ProtocolError::BadNumber, field);
  return matrix;
}

std::int32_t DecodeCheck::imagePx(std::int32_t px, std::string_view field) {
  require(px >= 1 && px <= kMaxImagePx, ProtocolError::BadPicture, field);
  return px;
}

std::uint64_t DecodeCheck::frameNumber(std::uint64_t frame) {
  require(frame >= 1, ProtocolError::BadNumber, "frame");
  return frame;
}

Sha256 sha256Of(const wire::Sha256* id) {
  Sha256 copy = {};
  std::memcpy(copy.data(), id, copy.size());
  return copy;
}

std::span<const std::byte> bytesOf(const flatbuffers::Vector<std::uint8_t>* bytes) {
  return std::as_bytes(std::span(bytes->data(), bytes->size()));
}

}  // namespace tessera::proto
