#include <bit>

#include "proto/codec.h"
#include "proto/decode_check.h"
#include "proto/little_endian.h"

namespace tessera::proto {

namespace {

constexpr std::size_t kUvBytes = 2 * sizeof(float);

std::span<const std::byte> bytesOrNone(const flatbuffers::Vector<std::uint8_t>* bytes) {
  return bytes == nullptr ? std::span<const std::byte>() : bytesOf(bytes);
}

/// False for NaN.
template <class Float>
Float within(DecodeCheck& check, Float number, Float least, Float most, std::string_view field) {
  check.require(least <= number && number <= most, ProtocolError::BadNumber, field);
  return number;
}

std::array<float, 3> rgbOf(DecodeCheck& check, const wire::Rgb* rgb, float most, std::string_view field) {
  return {within(check, rgb->r(), 0.0F, most, field), within(check, rgb->g(), 0.0F, most, field),
          within(check, rgb->b(), 0.0F, most, field)};
}

Vec2 pointOf(DecodeCheck& check, const wire::Vec2& point) {
  return {within(check, point.x(), -kMaxScreenM, kMaxScreenM, "corners_m"),
          within(check, point.y(), -kMaxScreenM, kMaxScreenM, "corners_m")};
}

/// The corners of a picture that covers something.
std::array<Vec2, 4> flatCornersOf(DecodeCheck& check, const wire::FlatCorners* inBuffer) {
  const wire::FlatCorners copy = DecodeCheck::copyOf(inBuffer);
  const std::array<Vec2, 4> corners = {pointOf(check, copy.lower_left()), pointOf(check, copy.lower_right()),
                                       pointOf(check, copy.upper_right()), pointOf(check, copy.upper_left())};
  const Vec2 right = corners[1] - corners[0], up = corners[3] - corners[0];
  const double area = right.x() * up.y() - right.y() * up.x();
  check.require(area > 0 || area < 0, ProtocolError::BadNumber, "corners_m");
  return corners;
}

std::array<float, 4> blendOf(DecodeCheck& check, const wire::Edges& edges) {
  constexpr auto kMost = static_cast<float>(kMaxImagePx);
  return {within(check, edges.left(), 0.0F, kMost, "blend_px"),
          within(check, edges.right(), 0.0F, kMost, "blend_px"),
          within(check, edges.bottom(), 0.0F, kMost, "blend_px"),
          within(check, edges.top(), 0.0F, kMost, "blend_px")};
}

/// NaN is a hole, infinity a fault.
void checkUv(DecodeCheck& check, std::span<const std::byte> uv) {
  bool isGood = true;
  for (std::size_t at = 0; at < uv.size(); at += sizeof(float)) {
    const auto bits = loadLittleEndian<std::uint32_t>(uv.subspan(at).first<sizeof(float)>());
    isGood = isGood && !std::isinf(std::bit_cast<float>(bits));
  }
  check.require(isGood, ProtocolError::BadNumber, "warp.uv");
}

void checkMasks(DecodeCheck& check, const Warp& warp) {
  constexpr auto kMost = static_cast<std::uint32_t>(kMaxImagePx);
  const bool isGood = warp.maskWidthPx <= kMost && warp.maskHeightPx <= kMost &&
                      (warp.maskWidthPx == 0) == (warp.maskHeightPx == 0);
  if (!check.require(isGood, ProtocolError::BadPicture, "warp.mask_width_px, warp.mask_height_px")) return;
  const std::size_t bytes = std::size_t{warp.maskWidthPx} * warp.maskHeightPx * sizeof(std::uint16_t);
  check.require(warp.alpha.size() == bytes, ProtocolError::BadPicture, "warp.alpha");
  check.require(warp.beta.empty() || warp.beta.size() == bytes, ProtocolError::BadPicture, "warp.beta");
}

std::optional<Warp> warpOf(DecodeCheck& check, const wire::Warp* inBuffer, std::size_t payloadBytes) {
  if (inBuffer == nullptr) return std::nullopt;
  const Warp warp = {.columns = inBuffer->columns(),
                     .rows = inBuffer->rows(),
                     .uv = bytesOf(inBuffer->uv()),
                     .maskWidthPx = inBuffer->mask_width_px(),
                     .maskHeightPx = inBuffer->mask_height_px(),
                     .alpha = bytesOrNone(inBuffer->alpha()),
                     .beta = bytesOrNone(inBuffer->beta()),
                     .maskGamma = within(check, inBuffer->mask_gamma(), 0.1F, 10.0F, "warp.mask_gamma")};
  const auto isSide = [](std::uint32_t vertices) { return vertices >= 2 && vertices <= kMaxWarpSide; };
  check.require(isSide(warp.columns) && isSide(warp.rows), ProtocolError::BadCount,
                "warp.columns, warp.rows");
  check.require(warp.uv.size() == std::size_t{warp.columns} * warp.rows * kUvBytes, ProtocolError::BadCount,
                "warp.uv");
  // One run of bytes may not serve as several.
  check.require(warp.uv.size() + warp.alpha.size() + warp.beta.size() <= payloadBytes,
                ProtocolError::BadCount, "warp");
  checkMasks(check, warp);
  if (check.ok()) checkUv(check, warp.uv);
  return warp;
}

}  // namespace

Result<TileSetup> decodeTileSetup(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::TileSetup);
  const auto* setup = check.root<wire::TileSetup>(payload);
  if (setup == nullptr) return check.error();
  constexpr double kLeastM = 1e-6;
  TileSetup decoded{
      .screenName = check.name(setup->screen_name(), "screen_name", true),
      .screenWidthM = within(check, setup->screen_width_m(), kLeastM, kMaxScreenM, "screen_width_m"),
      .screenHeightM = within(check, setup->screen_height_m(), kLeastM, kMaxScreenM, "screen_height_m"),
      .cornersM = flatCornersOf(check, setup->corners_m()),
      .gainRgb = rgbOf(check, setup->gain(), 4.0F, "gain"),
      .blackRgb = rgbOf(check, setup->black(), 1.0F, "black"),
      .gamma = within(check, setup->gamma(), 0.5F, 5.0F, "gamma"),
      .blendPx = blendOf(check, *setup->blend_px()),
      .warp = warpOf(check, setup->warp(), payload.size())};
  return check.finish(std::move(decoded));
}

}  // namespace tessera::proto
