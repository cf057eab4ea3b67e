#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "proto/codec.h"
#include "proto/little_endian.h"

// Messages with random content, and comparison of messages that hold spans.
namespace tessera::proto::test {

/// A copy of bytes in an allocation of just their size, so that AddressSanitizer sees every read past the
/// end.
class ExactBytes {
 public:
  explicit ExactBytes(std::span<const std::byte> bytes)
      : bytes_(std::make_unique<std::byte[]>(bytes.size())), size_(bytes.size()) {
    std::copy(bytes.begin(), bytes.end(), bytes_.get());
  }
  [[nodiscard]] std::span<const std::byte> view() const { return {bytes_.get(), size_}; }

 private:
  std::unique_ptr<std::byte[]> bytes_;
  std::size_t size_;
};

inline std::span<const std::byte> payloadOf(const Bytes& message) {
  return std::span(message).subspan(kHeaderBytes);
}

template <class T>
bool sameBytes(std::span<const T> a, std::span<const T> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

inline bool operator==(const Asset& a, const Asset& b) {
  return a.id == b.id && a.kind == b.kind && sameBytes(a.bytes, b.bytes) && a.diskBytes == b.diskBytes &&
         a.needs == b.needs;
}

template <class Message>
bool isSame(const Message& a, const Message& b) {
  return a == b;
}

inline bool isSame(const Assets& a, const Assets& b) {
  return std::equal(a.assets.begin(), a.assets.end(), b.assets.begin(), b.assets.end(),
                    [](const Asset& x, const Asset& y) { return x == y; });
}

inline bool isSame(const Keep& a, const Keep& b) {
  return sameBytes(a.leaves, b.leaves);
}

inline bool isSame(const Frame& a, const Frame& b) {
  return a.frame == b.frame && a.baseFrame == b.baseFrame && a.eye == b.eye && a.corners == b.corners &&
         a.nearM == b.nearM && a.farM == b.farM && a.right == b.right && a.up == b.up &&
         sameBytes(a.toggles, b.toggles) && a.listLeafCount == b.listLeafCount &&
         a.wantPicture == b.wantPicture && a.overlay == b.overlay && a.pattern == b.pattern &&
         a.skewUs == b.skewUs && a.rightEye == b.rightEye && a.stereo == b.stereo;
}

inline bool isSame(const Warp& a, const Warp& b) {
  return a.columns == b.columns && a.rows == b.rows && sameBytes(a.uv, b.uv) &&
         a.maskWidthPx == b.maskWidthPx && a.maskHeightPx == b.maskHeightPx && sameBytes(a.alpha, b.alpha) &&
         sameBytes(a.beta, b.beta) && a.maskGamma == b.maskGamma;
}

inline bool isSame(const TileSetup& a, const TileSetup& b) {
  return a.screenName == b.screenName && a.screenWidthM == b.screenWidthM &&
         a.screenHeightM == b.screenHeightM && a.cornersM == b.cornersM && a.gainRgb == b.gainRgb &&
         a.blackRgb == b.blackRgb && a.gamma == b.gamma && a.blendPx == b.blendPx &&
         a.warp.has_value() == b.warp.has_value() && (!a.warp || isSame(*a.warp, *b.warp));
}

inline bool isSame(const Shown& a, const Shown& b) {
  if (a.frame != b.frame || a.shownNs != b.shownNs || a.picture.has_value() != b.picture.has_value())
    return false;
  return !a.picture ||
         (a.picture->widthPx == b.picture->widthPx && a.picture->heightPx == b.picture->heightPx &&
          a.picture->format == b.picture->format && sameBytes(a.picture->bytes, b.picture->bytes));
}

inline bool isSame(const AnyMessage& a, const AnyMessage& b) {
  if (a.index() != b.index()) return false;
  return std::visit(
      [&](const auto& message) { return isSame(message, std::get<std::decay_t<decltype(message)>>(b)); }, a);
}

inline Bytes encodeAny(const AnyMessage& message) {
  return std::visit([](const auto& one) { return encode(one); }, message);
}

inline MessageType typeOf(const AnyMessage& message) {
  if (std::holds_alternative<Input>(message)) return MessageType::Input;
  if (std::holds_alternative<Have>(message)) return MessageType::Have;
  if (std::holds_alternative<Lacks>(message)) return MessageType::Lacks;
  if (std::holds_alternative<Keep>(message)) return MessageType::Keep;
  if (std::holds_alternative<Poses>(message)) return MessageType::Poses;
  return static_cast<MessageType>(message.index() + 1);
}

/// Makes messages; owns the bytes that their spans refer to.
class MessageMaker {
 public:
  explicit MessageMaker(std::uint64_t seed) : random_(seed) {}

  Hello hello() {
    return {.tileName = name(),
            .programVersion = name(),
            .clockId = name(),
            .surface = static_cast<SurfaceKind>(below(4)),
            .pid = number32(),
            .maxWidthPx = number32(),
            .maxHeightPx = number32(),
            .cacheBytes = random_(),
            .haveCount = number32()};
  }

  Welcome welcome() {
    return {.session = random_(),
            .wallName = name(),
            .tileName = name(),
            .widthPx = px(kMaxImagePx),
            .heightPx = px(kMaxImagePx),
            .xPx = px(1 << 20) - 1,
            .yPx = px(1 << 20) - 1,
            .idleTimeoutMs = 1 + number32() / 2,
            .leafCount = number32(),
            .picture = static_cast<PictureFormat>(below(2)),
            .backgroundRgb = {channel(), channel(), channel()},
            .wallWidthPx = (1 << 20) + kMaxImagePx + px(1000),
            .wallHeightPx = (1 << 20) + kMaxImagePx + px(1000),
            .onMiss = static_cast<OnMiss>(below(3)),
            .uploadMs = channel()};
  }

  Assets assets() {
    Assets message;
    for (std::uint64_t i = below(5); i > 0; --i) {
      const auto kind = static_cast<AssetKind>(below(3));
      const bool isOnDisk = below(3) == 0;
      message.assets.push_back(
          {.id = hash(),
           .kind = kind,
           .bytes = bytes(isOnDisk ? 0 : below(300)),
           .diskBytes = isOnDisk ? number32() % (1U << 20U) : 0,
           .needs = kind == AssetKind::State ? hashes(below(4)) : std::vector<Sha256>()});
    }
    return message;
  }

  Leaves leaves() {
    Leaves message;
    for (std::uint64_t i = below(5); i > 0; --i)
      message.leaves.push_back(leaf());
    return message;
  }

  Frame frame() {
    const std::uint64_t number = 1 + random_() / 2;
    const double near = std::abs(real()) + 1e-6;
    const Vec3 right = vec3().normalized();
    const auto stereo = static_cast<StereoLayout>(below(4));
    return {
        .frame = number,
        .baseFrame = random_() % number,
        .eye = vec3(),
        .corners = {vec3(), vec3(), vec3(), vec3()},
        .nearM = near,
        .farM = near + std::abs(real()) + 1,
        .right = right,
        .up = right.cross(vec3()).normalized(),
        .toggles = bytes(below(100)),
        .listLeafCount = number32(),
        .wantPicture = below(2) == 1,
        .overlay = below(2) == 1,
        .pattern = static_cast<Pattern>(below(3)),
        .skewUs = number32(),
        .rightEye = stereo == StereoLayout::None
                        ? std::nullopt
                        : std::optional(RightEye{.eye = vec3(), .corners = {vec3(), vec3(), vec3(), vec3()}}),
        .stereo = stereo};
  }

  Ready ready() {
    return {.frame = 1 + random_() / 2,
            .drawUs = number32(),
            .leafCount = number32(),
            .missingLeaves = number32(),
            .missingPx = random_()};
  }
  Swap swap() { return {.frame = 1 + random_() / 2}; }

  Shown shown() {
    Shown message = {
        .frame = 1 + random_() / 2, .shownNs = static_cast<std::int64_t>(random_()), .picture = std::nullopt};
    if (below(2) == 1) {
      const std::int32_t width = px(9), height = px(9);
      message.picture = Picture{.widthPx = width,
                                .heightPx = height,
                                .format = PictureFormat::RawRgb8,
                                .bytes = bytes(std::size_t{3} * static_cast<std::size_t>(width) *
                                               static_cast<std::size_t>(height))};
    }
    return message;
  }

  Ping ping() { return {.nonce = random_()}; }
  Pong pong() { return {.nonce = random_()}; }
  Bye bye() { return {.reason = text(), .peakResidentBytes = random_(), .framesShown = random_()}; }
  ErrorMessage error() { return {.code = static_cast<ErrorCode>(below(9)), .text = text()}; }

  TileSetup tileSetup() {
    return {.screenName = name(),
            .screenWidthM = 1e-6 + std::abs(real()) / 2,
            .screenHeightM = 1e-6 + std::abs(real()) / 2,
            .cornersM = {vec2(), vec2(), vec2(), vec2()},
            .gainRgb = {4 * channel(), channel(), channel()},
            .blackRgb = {channel(), channel(), channel()},
            .gamma = 0.5F + channel(),
            .blendPx = {100 * channel(), 0, channel(), 7},
            .warp = below(3) == 0 ? std::nullopt : std::optional(warp())};
  }

  Warp warp() {
    const std::size_t masks = below(3), columns = 2 + below(5), rows = 2 + below(5);
    const std::size_t width = masks > 0 ? 1 + below(7) : 0, height = masks > 0 ? 1 + below(7) : 0;
    return {.columns = static_cast<std::uint32_t>(columns),
            .rows = static_cast<std::uint32_t>(rows),
            .uv = floats(columns * rows * 2),
            .maskWidthPx = static_cast<std::uint32_t>(width),
            .maskHeightPx = static_cast<std::uint32_t>(height),
            .alpha = bytes(width * height * 2),
            .beta = bytes(masks == 2 ? width * height * 2 : 0),
            .maskGamma = 0.1F + channel()};
  }

  Input input() {
    const auto kind = static_cast<InputKind>(below(6));
    const auto part = [this] { return static_cast<double>(below(1001)) / 1000; };
    const auto place = [&] { return kind == InputKind::Scroll ? 2000 * part() - 1000 : part(); };
    Input message = {.kind = kind,
                     .code = static_cast<std::int32_t>(below(kMaxInputCode + 1)),
                     .pressed = below(2) == 1,
                     .modifiers = number32() % (1U << kInputModifierBits),
                     .x = place(),
                     .y = place(),
                     .buttons = number32() % (1U << kGamepadButtonBits)};
    for (float& axis : message.axes)
      axis = 2 * channel() - 1;
    return message;
  }

  std::vector<Sha256> hashes(std::uint64_t count) {
    std::vector<Sha256> made(count);
    for (Sha256& id : made)
      id = hash();
    return made;
  }
  Have have() { return {.ids = hashes(below(5))}; }
  Lacks lacks() { return {.ids = hashes(below(5))}; }
  Keep keep() { return {.leaves = bytes(below(60))}; }

  Pose pose(std::uint32_t id) {
    Pose made = {.id = id, .form = static_cast<PoseForm>(below(3))};
    if (made.form == PoseForm::Matrix) {
      made.localToWorld = Mat4::NullaryExpr([&] { return real(); });
      made.localToWorld.row(3) << 0, 0, 0, 1;
    }
    if (made.form == PoseForm::Steps) {
      for (std::int8_t& exponent : made.steps.exponents)
        exponent = static_cast<std::int8_t>(below(256));
      for (std::int64_t& count : made.steps.counts)
        count = std::clamp(static_cast<std::int64_t>(random_()) >> below(64), -kMaxPoseSteps, kMaxPoseSteps);
    }
    made.joints.resize(below(3) * 12);
    made.weights.resize(below(4) + (made.form == PoseForm::Kept ? 1 : 0));
    for (std::vector<float>* numbers : {&made.joints, &made.weights})
      std::generate(numbers->begin(), numbers->end(), [&] { return channel(); });
    return made;
  }

  Poses poses() {
    Poses made;
    std::uint32_t id = 0;
    for (std::uint64_t i = below(5); i > 0; --i) {
      id += static_cast<std::uint32_t>(1 + below(300));
      made.poses.push_back(pose(id));
    }
    return made;
  }

  AnyMessage any(MessageType type) {
    switch (type) {
      case MessageType::Hello:
        return hello();
      case MessageType::Welcome:
        return welcome();
      case MessageType::Assets:
        return assets();
      case MessageType::Leaves:
        return leaves();
      case MessageType::Frame:
        return frame();
      case MessageType::Ready:
        return ready();
      case MessageType::Swap:
        return swap();
      case MessageType::Shown:
        return shown();
      case MessageType::Ping:
        return ping();
      case MessageType::Pong:
        return pong();
      case MessageType::Bye:
        return bye();
      case MessageType::Error:
        return error();
      case MessageType::TileSetup:
        return tileSetup();
      case MessageType::Input:
        return input();
      case MessageType::Have:
        return have();
      case MessageType::Lacks:
        return lacks();
      case MessageType::Keep:
        return keep();
      case MessageType::Poses:
        return poses();
    }
    return Ping{};
  }

  LeafRecord leaf() {
    LeafRecord record = {.id = number32(),
                         .drawable = hash(),
                         .state = hash(),
                         .localToWorld = Mat4::NullaryExpr([&] { return real(); }),
                         .center = vec3(),
                         .radius = std::abs(real()),
                         .halfAxes = {vec3(), vec3(), vec3()},
                         .meanRgb = {channel(), channel(), channel()},
                         .billboard = std::nullopt};
    if (below(2) == 1) {
      record.billboard = LeafBillboard{
          .mode = static_cast<BillboardMode>(below(3)), .axis = vec3(), .normal = vec3(), .position = vec3()};
    }
    return record;
  }

  std::uint64_t below(std::uint64_t limit) { return random_() % limit; }

  std::span<const std::byte> bytes(std::size_t count) {
    auto& made = owned_.emplace_back(std::make_unique<std::vector<std::byte>>(count));
    std::generate(made->begin(), made->end(), [&] { return static_cast<std::byte>(below(256)); });
    return *made;
  }

  /// Little-endian floats in [0, 1], some of them NaN.
  std::span<const std::byte> floats(std::size_t count) {
    auto& made = owned_.emplace_back(std::make_unique<std::vector<std::byte>>(count * sizeof(float)));
    for (std::size_t i = 0; i < count; ++i) {
      const float value = below(8) == 0 ? std::numeric_limits<float>::quiet_NaN() : channel();
      storeLittleEndian(std::bit_cast<std::uint32_t>(value), std::span(*made).subspan(4 * i).first<4>());
    }
    return *made;
  }

 private:
  std::uint32_t number32() { return static_cast<std::uint32_t>(random_()); }
  std::int32_t px(std::int32_t max) {
    return static_cast<std::int32_t>(1 + below(static_cast<std::uint64_t>(max)));
  }
  float channel() { return static_cast<float>(below(1001)) / 1000.0F; }
  double real() { return std::uniform_real_distribution(-1e6, 1e6)(random_); }
  Vec2 vec2() { return {real(), real()}; }
  Vec3 vec3() { return {real(), real(), real()}; }

  Sha256 hash() {
    Sha256 id;
    std::generate(id.begin(), id.end(), [&] { return static_cast<std::uint8_t>(below(256)); });
    return id;
  }

  std::string characters(std::uint64_t maxCount) {
    static constexpr const char* kCharacters[] = {"a", "Z", "7", "-", " ", "\u00e9", "\u2603", "\U0001f5bc"};
    std::string made;
    for (std::uint64_t i = 1 + below(maxCount); i > 0; --i)
      made += kCharacters[below(8)];
    return made;
  }
  std::string name() { return characters(kMaxNameBytes / 4); }
  std::string text() { return characters(kMaxTextBytes / 4); }

  std::mt19937_64 random_;
  std::vector<std::unique_ptr<std::vector<std::byte>>> owned_;
};

inline constexpr MessageType kAllTypes[] = {
    MessageType::Hello, MessageType::Welcome, MessageType::Assets,    MessageType::Leaves, MessageType::Frame,
    MessageType::Ready, MessageType::Swap,    MessageType::Shown,     MessageType::Ping,   MessageType::Pong,
    MessageType::Bye,   MessageType::Error,   MessageType::TileSetup, MessageType::Input,  MessageType::Have,
    MessageType::Lacks, MessageType::Keep,    MessageType::Poses};

}  // namespace tessera::proto::test
