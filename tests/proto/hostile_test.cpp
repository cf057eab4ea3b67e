// Payloads that are sound for the framing and, mostly, for FlatBuffers, but break a rule of the protocol.
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

#include "flatbuffers/flatbuffers.h"
#include "proto/codec.h"
#include "proto/tessera_generated.h"
#include "tests/proto/test_messages.h"

namespace tessera::proto {
namespace {

using test::ExactBytes;
using test::MessageMaker;
using test::payloadOf;

using Builder = flatbuffers::FlatBufferBuilder;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::optional<ProtocolError> refusal(MessageType type, std::span<const std::byte> payload) {
  const ExactBytes exact(payload);
  const auto decoded = decode(type, exact.view());
  if (decoded) return std::nullopt;
  return protocolErrorOf(decoded.error());
}

/// Encodes `good` after `spoil` and returns why it is refused.
template <class Message>
std::optional<ProtocolError> refusalOf(Message good, const std::function<void(Message&)>& spoil) {
  const auto type = test::typeOf(AnyMessage(good));
  EXPECT_EQ(refusal(type, payloadOf(encode(good))), std::nullopt);
  spoil(good);
  return refusal(type, payloadOf(encode(good)));
}

template <class Table>
std::optional<ProtocolError> refusalOfBuilt(MessageType type, Builder& builder,
                                            flatbuffers::Offset<Table> root) {
  builder.FinishSizePrefixed(root);
  return refusal(type, std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize())));
}

TEST(Hostile, Hello) {
  const Hello good = {
      .tileName = "r0c0", .programVersion = "0.1", .clockId = "", .surface = SurfaceKind::None};
  const auto refused = [&](const std::function<void(Hello&)>& spoil) { return refusalOf(good, spoil); };
  EXPECT_EQ(refused([](Hello& m) { m.tileName = ""; }), ProtocolError::BadText);
  EXPECT_EQ(refused([](Hello& m) { m.tileName = std::string(65, 'a'); }), ProtocolError::BadText);
  EXPECT_EQ(refused([](Hello& m) { m.tileName = "a\nb"; }), ProtocolError::BadText);
  EXPECT_EQ(refused([](Hello& m) { m.tileName = std::string("a\0b", 3); }), ProtocolError::BadText);
  EXPECT_EQ(refused([](Hello& m) { m.programVersion = "\xff"; }), ProtocolError::BadText);
  EXPECT_EQ(refused([](Hello& m) { m.clockId = "\xed\xa0\x80"; }), ProtocolError::BadText);
  EXPECT_EQ(refused([](Hello& m) { m.surface = static_cast<SurfaceKind>(4); }), ProtocolError::BadEnum);
  EXPECT_EQ(refused([](Hello& m) { m.tileName = std::string(64, 'a'); }), std::nullopt);
  EXPECT_TRUE(encode(Hello{.tileName = std::string(5000, 'a')}).empty());
}

TEST(Hostile, Welcome) {
  const Welcome good = {.tileName = "r0c0",
                        .widthPx = 8,
                        .heightPx = 9,
                        .idleTimeoutMs = 1,
                        .wallWidthPx = 8,
                        .wallHeightPx = 9};
  const auto refused = [&](const std::function<void(Welcome&)>& spoil) { return refusalOf(good, spoil); };
  for (const std::int32_t px : {0, -1, kMaxImagePx + 1, INT32_MAX, INT32_MIN}) {
    EXPECT_EQ(refused([&](Welcome& m) { m.widthPx = px; }), ProtocolError::BadPicture);
    EXPECT_EQ(refused([&](Welcome& m) { m.heightPx = px; }), ProtocolError::BadPicture);
  }
  EXPECT_EQ(refused([](Welcome& m) { m.xPx = -1; }), ProtocolError::BadNumber);
  EXPECT_EQ(refused([](Welcome& m) { m.yPx = INT32_MAX; }), ProtocolError::BadNumber);
  EXPECT_EQ(refused([](Welcome& m) { m.xPx = 1; }), ProtocolError::BadNumber) << "sticks out of the wall";
  EXPECT_EQ(refused([](Welcome& m) { m.wallHeightPx = 8; }), ProtocolError::BadNumber);
  EXPECT_EQ(refused([](Welcome& m) { m.idleTimeoutMs = 0; }), ProtocolError::BadNumber);
  EXPECT_EQ(refused([](Welcome& m) { m.picture = static_cast<PictureFormat>(2); }), ProtocolError::BadEnum);
  for (const float channel : {-0.01F, 1.01F, std::numeric_limits<float>::quiet_NaN()}) {
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(refused([&](Welcome& m) { m.backgroundRgb[i] = channel; }), ProtocolError::BadNumber);
    }
  }
}

TEST(Hostile, FrameNumbers) {
  MessageMaker maker(30);
  Frame good = maker.frame();
  const auto refused = [&](const std::function<void(Frame&)>& spoil) { return refusalOf(good, spoil); };
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(refused([&](Frame& m) { m.eye[i] = bad; }), ProtocolError::BadNumber);
      EXPECT_EQ(refused([&](Frame& m) { m.right[i] = bad; }), ProtocolError::BadNumber);
      EXPECT_EQ(refused([&](Frame& m) { m.up[i] = bad; }), ProtocolError::BadNumber);
      for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_EQ(refused([&](Frame& m) { m.corners[k][i] = bad; }), ProtocolError::BadNumber);
      }
    }
    EXPECT_EQ(refused([&](Frame& m) { m.nearM = bad; }), ProtocolError::BadNumber);
    EXPECT_EQ(refused([&](Frame& m) { m.farM = bad; }), ProtocolError::BadNumber);
  }
  EXPECT_EQ(refused([](Frame& m) { m.nearM = 0; }), ProtocolError::BadDepthRange);
  EXPECT_EQ(refused([](Frame& m) { m.nearM = -1; }), ProtocolError::BadDepthRange);
  EXPECT_EQ(refused([](Frame& m) { m.farM = m.nearM; }), ProtocolError::BadDepthRange);
  EXPECT_EQ(refused([](Frame& m) { m.right *= 1.01; }), ProtocolError::BadAxes);
  EXPECT_EQ(refused([](Frame& m) { m.up.setZero(); }), ProtocolError::BadAxes);
  EXPECT_EQ(refused([](Frame& m) { m.up = m.right; }), ProtocolError::BadAxes);
  EXPECT_EQ(refused([](Frame& m) { m.up *= 1e200; }), ProtocolError::BadAxes);
  EXPECT_EQ(refused([](Frame& m) { m.frame = m.baseFrame = 0; }), ProtocolError::BadNumber);
  EXPECT_EQ(refused([](Frame& m) { m.baseFrame = m.frame; }), ProtocolError::BadNumber);
}

TEST(Hostile, FrameStereoAndPattern) {
  MessageMaker maker(33);
  Frame good = maker.frame();
  good.stereo = StereoLayout::SideBySide;
  good.rightEye = RightEye{};
  const auto refused = [&](const std::function<void(Frame&)>& spoil) { return refusalOf(good, spoil); };
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(refused([&](Frame& m) { m.rightEye->eye[i] = bad; }), ProtocolError::BadNumber);
      for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_EQ(refused([&](Frame& m) { m.rightEye->corners[k][i] = bad; }), ProtocolError::BadNumber);
      }
    }
  }
  EXPECT_EQ(refused([](Frame& m) { m.pattern = static_cast<Pattern>(3); }), ProtocolError::BadEnum);
  EXPECT_EQ(refused([](Frame& m) { m.stereo = static_cast<StereoLayout>(4); }), ProtocolError::BadEnum);
  EXPECT_EQ(refused([](Frame& m) { m.stereo = StereoLayout::None; }), ProtocolError::BadEnum);
  EXPECT_EQ(refused([](Frame& m) { m.rightEye.reset(); }), ProtocolError::BadEnum);
}

TEST(Hostile, TileSetup) {
  const TileSetup good;
  const auto refused = [&](const std::function<void(TileSetup&)>& spoil) { return refusalOf(good, spoil); };
  constexpr auto kNaNF = std::numeric_limits<float>::quiet_NaN();
  constexpr auto kInfinityF = std::numeric_limits<float>::infinity();
  EXPECT_EQ(refused([](TileSetup& m) { m.screenName = std::string(65, 'a'); }), ProtocolError::BadText);
  EXPECT_EQ(refused([](TileSetup& m) { m.screenName = "a\x1b"; }), ProtocolError::BadText);
  for (const double bad : {kNaN, kInfinity, 0.0, -1.0, 1.1e6}) {
    EXPECT_EQ(refused([&](TileSetup& m) { m.screenWidthM = bad; }), ProtocolError::BadNumber);
    EXPECT_EQ(refused([&](TileSetup& m) { m.screenHeightM = bad; }), ProtocolError::BadNumber);
  }
  for (std::size_t k = 0; k < 4; ++k) {
    for (const double bad : {kNaN, kInfinity, -kInfinity, 1.1e6, -1.1e6}) {
      EXPECT_EQ(refused([&](TileSetup& m) { m.cornersM[k].x() = bad; }), ProtocolError::BadNumber);
      EXPECT_EQ(refused([&](TileSetup& m) { m.cornersM[k].y() = bad; }), ProtocolError::BadNumber);
    }
    for (const float bad : {kNaNF, kInfinityF, -0.1F, 16385.0F})
      EXPECT_EQ(refused([&](TileSetup& m) { m.blendPx[k] = bad; }), ProtocolError::BadNumber);
  }
  EXPECT_EQ(refused([](TileSetup& m) { m.cornersM[1] = m.cornersM[0]; }), ProtocolError::BadNumber)
      << "no area";
  for (std::size_t i = 0; i < 3; ++i) {
    for (const float bad : {kNaNF, -0.1F, 4.1F})
      EXPECT_EQ(refused([&](TileSetup& m) { m.gainRgb[i] = bad; }), ProtocolError::BadNumber);
    for (const float bad : {kNaNF, -0.1F, 1.1F})
      EXPECT_EQ(refused([&](TileSetup& m) { m.blackRgb[i] = bad; }), ProtocolError::BadNumber);
  }
  for (const float bad : {kNaNF, 0.0F, 0.49F, 5.1F})
    EXPECT_EQ(refused([&](TileSetup& m) { m.gamma = bad; }), ProtocolError::BadNumber);
}

TEST(Hostile, Warps) {
  MessageMaker maker(34);
  TileSetup good;
  good.warp = Warp{.columns = 2,
                   .rows = 3,
                   .uv = maker.floats(12),
                   .maskWidthPx = 4,
                   .maskHeightPx = 5,
                   .alpha = maker.bytes(40),
                   .beta = maker.bytes(40)};
  const auto refused = [&](const std::function<void(Warp&)>& spoil) {
    return refusalOf<TileSetup>(good, [&](TileSetup& m) { spoil(*m.warp); });
  };
  EXPECT_EQ(refused([](Warp& m) { m.beta = {}; }), std::nullopt) << "beta may be missing";
  EXPECT_EQ(refused([](Warp& m) { m.alpha = m.alpha.first(38); }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Warp& m) { m.alpha = {}; }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Warp& m) { m.beta = m.beta.first(38); }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Warp& m) { m.maskWidthPx = 0; }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Warp& m) { m.maskWidthPx = m.maskHeightPx = 0; }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Warp& m) { m.maskWidthPx = 16385; }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Warp& m) { m.maskHeightPx = UINT32_MAX; }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Warp& m) { m.uv = m.uv.first(44); }), ProtocolError::BadCount);
  EXPECT_EQ(refused([](Warp& m) { m.columns = m.rows = 1; }), ProtocolError::BadCount);
  EXPECT_EQ(refused([](Warp& m) { m.columns = 3; }), ProtocolError::BadCount);
  EXPECT_EQ(refused([](Warp& m) { m.rows = kMaxWarpSide + 1; }), ProtocolError::BadCount);
  EXPECT_EQ(refused([](Warp& m) { m.columns = m.rows = 0x80000000U; }), ProtocolError::BadCount);
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.09F, 10.1F})
    EXPECT_EQ(refused([&](Warp& m) { m.maskGamma = bad; }), ProtocolError::BadNumber);
  std::vector<std::byte> uv(good.warp->uv.begin(), good.warp->uv.end());
  for (const float bad : {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()}) {
    std::memcpy(uv.data() + 44, &bad, sizeof bad);
    EXPECT_EQ(refused([&](Warp& m) { m.uv = uv; }), ProtocolError::BadNumber);
  }
  EXPECT_TRUE(
      encode(TileSetup{.warp = Warp{.uv = std::span<const std::byte>(uv.data(), SIZE_MAX / 2)}}).empty());
}

// Masks and mesh may not be one run of bytes that is named three times.
TEST(Hostile, SharedWarpBytesDoNotMultiply) {
  Builder builder;
  const auto shared = builder.CreateVector(std::vector<std::uint8_t>(8 * 100 * 100));
  const auto warp = wire::CreateWarp(builder, 100, 100, shared, 200, 200, shared, shared, 1);
  const auto name = builder.CreateString("");
  const wire::FlatCorners corners(wire::Vec2(0, 0), wire::Vec2(1, 0), wire::Vec2(1, 1), wire::Vec2(0, 1));
  const wire::Rgb gain(1, 1, 1), black(0, 0, 0);
  const wire::Edges blend(0, 0, 0, 0);
  EXPECT_EQ(
      refusalOfBuilt(MessageType::TileSetup, builder,
                     wire::CreateTileSetup(builder, name, 1, 1, &corners, &gain, &black, 2.2F, &blend, warp)),
      ProtocolError::BadCount);
}

TEST(Hostile, FrameZeroIsNoFrame) {
  EXPECT_EQ(refusal(MessageType::Ready, payloadOf(encode(Ready{}))), ProtocolError::BadNumber);
  EXPECT_EQ(refusal(MessageType::Swap, payloadOf(encode(Swap{}))), ProtocolError::BadNumber);
  EXPECT_EQ(refusal(MessageType::Shown, payloadOf(encode(Shown{}))), ProtocolError::BadNumber);
}

TEST(Hostile, Leaves) {
  MessageMaker maker(31);
  Leaves good = {{maker.leaf(), maker.leaf()}};
  good.leaves[1].billboard = LeafBillboard{};
  const auto refused = [&](const std::function<void(LeafRecord&)>& spoil) {
    return refusalOf<Leaves>(good, [&](Leaves& m) { spoil(m.leaves[1]); });
  };
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    for (int i = 0; i < 16; ++i) {
      EXPECT_EQ(refused([&](LeafRecord& m) { m.localToWorld(i) = bad; }), ProtocolError::BadNumber);
    }
    EXPECT_EQ(refused([&](LeafRecord& m) { m.radius = bad; }), ProtocolError::BadNumber);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(refused([&](LeafRecord& m) { m.center[i] = bad; }), ProtocolError::BadNumber);
      EXPECT_EQ(refused([&](LeafRecord& m) { m.billboard->axis[i] = bad; }), ProtocolError::BadNumber);
      EXPECT_EQ(refused([&](LeafRecord& m) { m.billboard->normal[i] = bad; }), ProtocolError::BadNumber);
      EXPECT_EQ(refused([&](LeafRecord& m) { m.billboard->position[i] = bad; }), ProtocolError::BadNumber);
    }
  }
  EXPECT_EQ(refused([](LeafRecord& m) { m.radius = -1; }), ProtocolError::BadNumber);
  EXPECT_EQ(refused([](LeafRecord& m) { m.billboard->mode = static_cast<BillboardMode>(3); }),
            ProtocolError::BadEnum);
}

TEST(Hostile, Pictures) {
  MessageMaker maker(32);
  Shown good = {.frame = 1};
  good.picture = Picture{.widthPx = 4, .heightPx = 5, .bytes = maker.bytes(60)};
  const auto refused = [&](const std::function<void(Picture&)>& spoil) {
    return refusalOf<Shown>(good, [&](Shown& m) { spoil(*m.picture); });
  };
  EXPECT_EQ(refused([](Picture& m) { m.bytes = m.bytes.first(59); }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Picture& m) { m.bytes = {}; }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Picture& m) { m.widthPx = 5; }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Picture& m) { m.heightPx = 0; }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Picture& m) { m.widthPx = m.heightPx = -5; }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Picture& m) { m.widthPx = m.heightPx = INT32_MAX; }), ProtocolError::BadPicture);
  EXPECT_EQ(refused([](Picture& m) { m.format = PictureFormat::None; }), ProtocolError::BadEnum);
  EXPECT_EQ(refused([](Picture& m) { m.format = static_cast<PictureFormat>(2); }), ProtocolError::BadEnum);
}

TEST(Hostile, EnumerationsOfAssetsAndErrors) {
  EXPECT_EQ(refusal(MessageType::Assets, payloadOf(encode(Assets{{{.kind = static_cast<AssetKind>(3)}}}))),
            ProtocolError::BadEnum);
  EXPECT_EQ(refusal(MessageType::Error,
                    payloadOf(encode(ErrorMessage{.code = static_cast<ErrorCode>(9), .text = ""}))),
            ProtocolError::BadEnum);
}

TEST(Hostile, Input) {
  const Input move = {.kind = InputKind::Move, .x = 1, .y = 0};
  const auto refused = [&](const std::function<void(Input&)>& spoil) { return refusalOf(move, spoil); };
  EXPECT_EQ(refused([](Input& m) { m.kind = static_cast<InputKind>(6); }), ProtocolError::BadEnum);
  EXPECT_EQ(refused([](Input& m) { m.code = -1; }), ProtocolError::BadNumber);
  EXPECT_EQ(refused([](Input& m) { m.code = kMaxInputCode + 1; }), ProtocolError::BadNumber);
  EXPECT_EQ(refused([](Input& m) { m.modifiers = 64; }), ProtocolError::BadNumber);
  EXPECT_EQ(refused([](Input& m) { m.modifiers = 63; }), std::nullopt);
  EXPECT_EQ(refused([](Input& m) { m.buttons = 1U << 15U; }), ProtocolError::BadNumber);
  EXPECT_EQ(refused([](Input& m) { m.buttons = 0xFFFFFFFFU; }), ProtocolError::BadNumber);
  for (const double wrong : {-0.001, 1.001, kNaN, kInfinity, -kInfinity}) {
    EXPECT_EQ(refused([&](Input& m) { m.x = wrong; }), ProtocolError::BadNumber) << wrong;
    EXPECT_EQ(refused([&](Input& m) { m.y = wrong; }), ProtocolError::BadNumber) << wrong;
    const auto axis = static_cast<float>(wrong < 0 ? wrong - 1 : wrong);
    EXPECT_EQ(refused([&](Input& m) { m.axes[5] = axis; }), ProtocolError::BadNumber) << axis;
  }
  const Input scroll = {.kind = InputKind::Scroll, .x = -kMaxScrollSteps, .y = kMaxScrollSteps};
  EXPECT_EQ(refusalOf<Input>(scroll, [](Input& m) { m.x = -1001; }), ProtocolError::BadNumber);
  EXPECT_EQ(refusalOf<Input>(scroll, [](Input& m) { m.y = 1001; }), ProtocolError::BadNumber);
  EXPECT_EQ(refusalOf<Input>(scroll, [](Input& m) { m.y = kNaN; }), ProtocolError::BadNumber);
}

TEST(Hostile, TextsThatOurEncoderWouldNotSend) {
  for (const std::string& text : {std::string(kMaxTextBytes + 1, 'x'), std::string("\xc0\xaf")}) {
    Builder byeBuilder;
    EXPECT_EQ(refusalOfBuilt(MessageType::Bye, byeBuilder,
                             wire::CreateBye(byeBuilder, byeBuilder.CreateString(text))),
              ProtocolError::BadText);
    Builder errorBuilder;
    EXPECT_EQ(refusalOfBuilt(MessageType::Error, errorBuilder,
                             wire::CreateError(errorBuilder, wire::ErrorCode::Internal,
                                               errorBuilder.CreateString(text))),
              ProtocolError::BadText);
  }
}

// A table whose required fields are missing: an empty one, as Ping without a nonce.
TEST(Hostile, MissingFields) {
  for (const MessageType type : {MessageType::Hello, MessageType::Welcome, MessageType::Assets,
                                 MessageType::Leaves, MessageType::Frame, MessageType::Bye,
                                 MessageType::Error, MessageType::TileSetup, MessageType::Input}) {
    Builder builder;
    EXPECT_EQ(refusalOfBuilt(type, builder, wire::CreatePing(builder)), ProtocolError::Malformed)
        << nameOf(type);
  }
}

TEST(Hostile, TheSizeInFrontMustBeTrue) {
  const Bytes message = encode(Ping{.nonce = 5});
  const auto payload = payloadOf(message);
  for (const int change : {-4, -1, 1, 4, 100}) {
    std::vector<std::byte> bytes(payload.begin(), payload.end());
    bytes[0] = static_cast<std::byte>(std::to_integer<int>(bytes[0]) + change);
    EXPECT_EQ(refusal(MessageType::Ping, bytes),
              change < 0 ? ProtocolError::TrailingBytes : ProtocolError::Truncated);
  }
}

TEST(Hostile, PayloadsOverTheLimitAreRefusedUnread) {
  const std::vector<std::byte> large(maxPayloadBytes(MessageType::Ready) + 4);
  EXPECT_EQ(refusal(MessageType::Ready, large), ProtocolError::TooLarge);
}

// One small table named by many offsets must not become many records.
TEST(Hostile, SharedLeavesDoNotMultiply) {
  for (const std::size_t count : {100U, 60000U, 200000U}) {
    Builder builder;
    const wire::Sha256 id;
    const wire::Mat4 matrix;
    const wire::Vec3 zero;
    const auto leaf = wire::CreateLeaf(builder, 1, &id, &id, &matrix, &zero);
    const auto refused =
        refusalOfBuilt(MessageType::Leaves, builder,
                       wire::CreateLeaves(builder, builder.CreateVector(std::vector(count, leaf))));
    EXPECT_EQ(refused, count > kMaxLeavesPerMessage * 2 ? ProtocolError::Malformed : ProtocolError::BadCount);
  }
}

TEST(Hostile, SharedAssetBytesDoNotMultiply) {
  Builder builder;
  const std::vector<std::uint8_t> bytes(10000);
  const auto vector = builder.CreateVector(bytes);
  std::vector<flatbuffers::Offset<wire::Asset>> assets;
  for (int i = 0; i < 100; ++i) {
    const wire::Sha256 id;
    assets.push_back(wire::CreateAsset(builder, &id, wire::AssetKind::Image, vector));
  }
  EXPECT_EQ(
      refusalOfBuilt(MessageType::Assets, builder, wire::CreateAssets(builder, builder.CreateVector(assets))),
      ProtocolError::BadCount);
}

TEST(Hostile, SharedAssetsDoNotMultiply) {
  Builder builder;
  const wire::Sha256 id;
  const auto asset = wire::CreateAsset(builder, &id, wire::AssetKind::Image,
                                       builder.CreateVector(std::vector<std::uint8_t>(1)));
  EXPECT_EQ(refusalOfBuilt(MessageType::Assets, builder,
                           wire::CreateAssets(builder, builder.CreateVector(std::vector(1000, asset)))),
            ProtocolError::BadCount);
}

}  // namespace
}  // namespace tessera::proto
