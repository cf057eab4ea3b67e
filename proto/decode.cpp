#include <utility>

#include "proto/codec.h"
#include "proto/decode_check.h"

namespace tessera::proto {

namespace {

constexpr std::int32_t kMaxWallPx = 1 << 24;

template <class Message>
Result<AnyMessage> toAny(Result<Message> result) {
  if (!result) return result.error();
  return AnyMessage(std::move(result).value());
}

std::int32_t placePx(DecodeCheck& check, std::int32_t px, std::string_view field) {
  check.require(px >= 0 && px <= kMaxWallPx, ProtocolError::BadNumber, field);
  return px;
}

std::array<float, 3> colour(DecodeCheck& check, const wire::Rgb* rgb) {
  const std::array<float, 3> channels = {rgb->r(), rgb->g(), rgb->b()};
  for (const float channel : channels) {
    check.require(channel >= 0 && channel <= 1, ProtocolError::BadNumber, "background");  // false for NaN
  }
  return channels;
}

/// A number from `least` to `limit`; no comparison holds for NaN.
template <class Float>
Float within(DecodeCheck& check, Float number, Float least, Float limit, std::string_view field) {
  check.require(number >= least && number <= limit, ProtocolError::BadNumber, field);
  return number;
}

std::array<float, 6> gamepadAxes(DecodeCheck& check, const wire::Axes* axes) {
  const wire::Axes copy = DecodeCheck::copyOf(axes);
  std::array<float, 6> values = {};
  for (std::uint16_t i = 0; i < 6; ++i)
    values[i] = within(check, copy.values()->Get(i), -1.0F, 1.0F, "axes");
  return values;
}

}  // namespace

Result<Hello> decodeHello(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Hello);
  const auto* hello = check.root<wire::Hello>(payload);
  if (hello == nullptr) return check.error();
  return check.finish(Hello{.tileName = check.name(hello->tile_name(), "tile_name"),
                            .programVersion = check.name(hello->program_version(), "program_version"),
                            .clockId = check.name(hello->clock_id(), "clock_id", true),
                            .surface = check.enumeration(hello->surface(), SurfaceKind::Egl, "surface"),
                            .pid = hello->pid(),
                            .maxWidthPx = hello->max_width_px(),
                            .maxHeightPx = hello->max_height_px(),
                            .cacheBytes = hello->cache_bytes(),
                            .haveCount = hello->have_count()});
}

Result<Welcome> decodeWelcome(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Welcome);
  const auto* welcome = check.root<wire::Welcome>(payload);
  if (welcome == nullptr) return check.error();
  check.require(welcome->idle_timeout_ms() > 0, ProtocolError::BadNumber, "idle_timeout_ms");
  Welcome decoded{.session = welcome->session(),
                  .wallName = check.name(welcome->wall_name(), "wall_name", true),
                  .tileName = check.name(welcome->tile_name(), "tile_name"),
                  .widthPx = check.imagePx(welcome->width_px(), "width_px"),
                  .heightPx = check.imagePx(welcome->height_px(), "height_px"),
                  .xPx = placePx(check, welcome->x_px(), "x_px"),
                  .yPx = placePx(check, welcome->y_px(), "y_px"),
                  .idleTimeoutMs = welcome->idle_timeout_ms(),
                  .leafCount = welcome->leaf_count(),
                  .picture = check.enumeration(welcome->picture(), PictureFormat::RawRgb8, "picture"),
                  .backgroundRgb = colour(check, welcome->background()),
                  .wallWidthPx = welcome->wall_width_px(),
                  .wallHeightPx = welcome->wall_height_px(),
                  .onMiss = check.enumeration(welcome->on_miss(), OnMiss::Skip, "on_miss"),
                  .uploadMs = within(check, welcome->upload_ms(), 0.0F, 1e6F, "upload_ms")};
  const auto holds = [](std::int64_t wallPx, std::int64_t atPx, std::int64_t sidePx) {
    return atPx + sidePx <= wallPx;
  };
  check.require(holds(decoded.wallWidthPx, decoded.xPx, decoded.widthPx) &&
                    holds(decoded.wallHeightPx, decoded.yPx, decoded.heightPx),
                ProtocolError::BadNumber, "wall_width_px, wall_height_px");
  return check.finish(std::move(decoded));
}

Result<Ready> decodeReady(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Ready);
  const auto* ready = check.root<wire::Ready>(payload);
  if (ready == nullptr) return check.error();
  return check.finish(Ready{.frame = check.frameNumber(ready->frame()),
                            .drawUs = ready->draw_us(),
                            .leafCount = ready->leaf_count(),
                            .missingLeaves = ready->missing_leaves(),
                            .missingPx = ready->missing_px()});
}

Result<Swap> decodeSwap(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Swap);
  const auto* swap = check.root<wire::Swap>(payload);
  if (swap == nullptr) return check.error();
  return check.finish(Swap{.frame = check.frameNumber(swap->frame())});
}

Result<Ping> decodePing(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Ping);
  const auto* ping = check.root<wire::Ping>(payload);
  if (ping == nullptr) return check.error();
  return Ping{.nonce = ping->nonce()};
}

Result<Pong> decodePong(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Pong);
  const auto* pong = check.root<wire::Pong>(payload);
  if (pong == nullptr) return check.error();
  return Pong{.nonce = pong->nonce()};
}

Result<Bye> decodeBye(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Bye);
  const auto* bye = check.root<wire::Bye>(payload);
  if (bye == nullptr) return check.error();
  return check.finish(Bye{.reason = check.text(bye->reason(), "reason"),
                          .peakResidentBytes = bye->peak_resident_bytes(),
                          .framesShown = bye->frames_shown()});
}

Result<ErrorMessage> decodeError(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Error);
  const auto* error = check.root<wire::Error>(payload);
  if (error == nullptr) return check.error();
  return check.finish(ErrorMessage{.code = check.enumeration(error->code(), ErrorCode::ShuttingDown, "code"),
                                   .text = check.text(error->text(), "text")});
}

Result<Input> decodeInput(std::span<const std::byte> payload) {
  DecodeCheck check(MessageType::Input);
  const auto* input = check.root<wire::Input>(payload);
  if (input == nullptr) return check.error();
  const InputKind kind = check.enumeration(input->kind(), InputKind::Gamepad, "kind");
  const double least = kind == InputKind::Scroll ? -kMaxScrollSteps : 0;
  const double limit = kind == InputKind::Scroll ? kMaxScrollSteps : 1;
  check.require(input->code() >= 0 && input->code() <= kMaxInputCode, ProtocolError::BadNumber, "code");
  check.require(input->modifiers() >> kInputModifierBits == 0, ProtocolError::BadNumber, "modifiers");
  check.require(input->buttons() >> kGamepadButtonBits == 0, ProtocolError::BadNumber, "buttons");
  return check.finish(Input{.kind = kind,
                            .code = input->code(),
                            .pressed = input->pressed(),
                            .modifiers = input->modifiers(),
                            .x = within(check, input->x(), least, limit, "x"),
                            .y = within(check, input->y(), least, limit, "y"),
                            .axes = gamepadAxes(check, input->axes()),
                            .buttons = input->buttons()});
}

Result<AnyMessage> decode(MessageType type, std::span<const std::byte> payload) {
  switch (type) {
    case MessageType::Hello:
      return toAny(decodeHello(payload));
    case MessageType::Welcome:
      return toAny(decodeWelcome(payload));
    case MessageType::Assets:
      return toAny(decodeAssets(payload));
    case MessageType::Leaves:
      return toAny(decodeLeaves(payload));
    case MessageType::Frame:
      return toAny(decodeFrame(payload));
    case MessageType::Ready:
      return toAny(decodeReady(payload));
    case MessageType::Swap:
      return toAny(decodeSwap(payload));
    case MessageType::Shown:
      return toAny(decodeShown(payload));
    case MessageType::Ping:
      return toAny(decodePing(payload));
    case MessageType::Pong:
      return toAny(decodePong(payload));
    case MessageType::Bye:
      return toAny(decodeBye(payload));
    case MessageType::Error:
      return toAny(decodeError(payload));
    case MessageType::TileSetup:
      return toAny(decodeTileSetup(payload));
    case MessageType::Input:
      return toAny(decodeInput(payload));
    case MessageType::Have:
      return toAny(decodeHave(payload));
    case MessageType::Lacks:
      return toAny(decodeLacks(payload));
    case MessageType::Keep:
      return toAny(decodeKeep(payload));
    case MessageType::Poses:
      return toAny(decodePoses(payload));
  }
  return protocolError(ProtocolError::UnknownType, "message");
}

}  // namespace tessera::proto
