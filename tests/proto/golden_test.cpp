// The bytes of version 2. They never change: whoever must change them makes a new protocol version.
#include <string>

#include <gtest/gtest.h>

#include "proto/codec.h"
#include "tests/proto/test_messages.h"

namespace tessera::proto {
namespace {

using test::isSame;

// A line of header, then the payload.
constexpr const char* kHello =
    "54535241020001006000000095730cd097253905"
    "5c0000001800000000001200200008000c0010000700140018001c001200000000000001300000002000000010000000"
    "92100000001e0000e010000006000000686f73742d61000005000000302e312e30000000040000007230633100000000";

constexpr const char* kFrame =
    "545352410200050008010000a38dd2db762c6f83"
    "04010000240000000000000000001a00d800b800c00008002000c800d00080009800b000b40007001a00000000000001"
    "000000000000f03f00000000000000400000000000000840000000000000f0bf000000000000e0bf0000000000000040"
    "0000000000000000000000000000e0bf00000000000000400000000000000000000000000000e03f0000000000000040"
    "000000000000f0bf000000000000e03f0000000000000040000000000000f03f00000000000000000000000000000000"
    "0000000000000000000000000000f03f0000000000000000280000000200000007000000000000000600000000000000"
    "000000000000d03f0000000000408f400300000001030100";

constexpr const char* kTileSetup =
    "5453524102000d0018010000db80b92758b1ecb6"
    "140100001c000000000016008c0004007800800008004800540060006400740016000000e8000000000000000000e03f"
    "000000000000d03f0000000000000040000000000000d03f0000000000000040000000000000f03f000000000000e03f"
    "000000000000f03f0000003f0000803f000000400000803e000000000000003e00002040000000430000000000008042"
    "000000422c000000000000000000104000000000000002400000000014002000040008000c0010001400180000001c00"
    "1400000002000000020000001c0000000100000001000000080000000000004002000000ff7f00002000000000000000"
    "0000803f0000803f000000000000c07f0000c07f0000803f0000803f0500000066726f6e74000000";

constexpr const char* kStereoFrame =
    "5453524102000500a001000023b637bc9bbb177a"
    "9c0100002c000000000000002400e400c000c80008002000d000d80080009800b000b400040005000600b800bc000700"
    "2400000001010202000000000000f03f00000000000000400000000000000840000000000000f0bf000000000000e0bf"
    "00000000000000400000000000000000000000000000e0bf00000000000000400000000000000000000000000000e03f"
    "0000000000000040000000000000f0bf000000000000e03f0000000000000040000000000000f03f0000000000000000"
    "00000000000000000000000000000000000000000000f03f0000000000000000b800000002000000a401000030000000"
    "07000000000000000600000000000000000000000000d03f0000000000408f400000000008007c0004001c0008000000"
    "000000000000f83f00000000000000400000000000000840000000000000f0bf000000000000e0bf0000000000000040"
    "0000000000000000000000000000e0bf00000000000000400000000000000000000000000000e03f0000000000000040"
    "000000000000f0bf000000000000e03f00000000000000400300000001030100";

constexpr const char* kPoses =
    "5453524102001400d00000006217f7432f19e9d7"
    "cc0000000c00000000000600080004000600000004000000b4000000030301000000000000f03f000000000000000000"
    "000000000000000000000000000000000000000000f03f00000000000000000000000000000000000000000000000000"
    "0000000000f03f000000000000000000000000000004400000000000000000000af60003ec02018001000000000000d7"
    "040400020000803e0000803fc30104010000803f0000000000000000000000000000803f000000000000000000000000"
    "0000803f000000000000000000008040";

const Hello kHelloMessage = {.tileName = "r0c1",
                             .programVersion = "0.1.0",
                             .clockId = "host-a",
                             .surface = SurfaceKind::Offscreen,
                             .pid = 4242,
                             .maxWidthPx = 7680,
                             .maxHeightPx = 4320};

constexpr std::byte kToggles[] = {std::byte{1}, std::byte{3}, std::byte{1}};

Frame frameMessage() {
  return {.frame = 7,
          .baseFrame = 6,
          .eye = {1, 2, 3},
          .corners = {Vec3(-1, -0.5, 2), Vec3(0, -0.5, 2), Vec3(0, 0.5, 2), Vec3(-1, 0.5, 2)},
          .nearM = 0.25,
          .farM = 1000,
          .right = {1, 0, 0},
          .up = {0, 1, 0},
          .toggles = kToggles,
          .listLeafCount = 2,
          .wantPicture = true};
}

constexpr std::byte kUv[] = {
    std::byte{0},    std::byte{0},    std::byte{0},    std::byte{0},    std::byte{0},    std::byte{0},
    std::byte{0x80}, std::byte{0x3f}, std::byte{0},    std::byte{0},    std::byte{0x80}, std::byte{0x3f},
    std::byte{0},    std::byte{0},    std::byte{0},    std::byte{0},    std::byte{0},    std::byte{0},
    std::byte{0xc0}, std::byte{0x7f}, std::byte{0},    std::byte{0},    std::byte{0xc0}, std::byte{0x7f},
    std::byte{0},    std::byte{0},    std::byte{0x80}, std::byte{0x3f}, std::byte{0},    std::byte{0},
    std::byte{0x80}, std::byte{0x3f}};
constexpr std::byte kAlpha[] = {std::byte{0xff}, std::byte{0x7f}};

TileSetup tileSetupMessage() {
  return {.screenName = "front",
          .screenWidthM = 4,
          .screenHeightM = 2.25,
          .cornersM = {Vec2(0.5, 0.25), Vec2(2, 0.25), Vec2(2, 1), Vec2(0.5, 1)},
          .gainRgb = {0.5F, 1, 2},
          .blackRgb = {0.25F, 0, 0.125F},
          .gamma = 2.5F,
          .blendPx = {128, 0, 64, 32},
          .warp = Warp{.columns = 2,
                       .rows = 2,
                       .uv = kUv,
                       .maskWidthPx = 1,
                       .maskHeightPx = 1,
                       .alpha = kAlpha,
                       .maskGamma = 2}};
}

Poses posesMessage() {
  Poses poses;
  poses.poses.push_back({.id = 3, .form = PoseForm::Matrix});
  poses.poses.back().localToWorld(1, 3) = 2.5;
  poses.poses.push_back({.id = 4, .form = PoseForm::Steps, .weights = {0.25F, 1}});
  poses.poses.back().steps = {.exponents = {-10, 0, 3, -20},
                              .counts = {1, -1, 64, 0, 0, 0, 0, 0, 0, -300, 2, 0}};
  poses.poses.push_back({.id = 200, .joints = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 4}});
  return poses;
}

std::string hexOf(std::span<const std::byte> bytes) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string hex;
  for (const std::byte byte : bytes) {
    hex += kDigits[std::to_integer<unsigned>(byte >> 4U)];
    hex += kDigits[std::to_integer<unsigned>(byte & std::byte{15})];
  }
  return hex;
}

Bytes bytesOf(const std::string& hex) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

TEST(Golden, Hello) {
  EXPECT_EQ(hexOf(encode(kHelloMessage)), kHello);
  const Bytes bytes = bytesOf(kHello);
  const auto frame = parseFrame(bytes, Expect::Hello);
  ASSERT_TRUE(frame.ok()) << frame.error().text();
  EXPECT_EQ(*decodeHello(frame->payload), kHelloMessage);
}

TEST(Golden, Frame) {
  EXPECT_EQ(hexOf(encode(frameMessage())), kFrame);
  const Bytes bytes = bytesOf(kFrame);
  const auto frame = parseFrame(bytes, Expect::FromMaster);
  ASSERT_TRUE(frame.ok()) << frame.error().text();
  EXPECT_TRUE(isSame(*decodeFrame(frame->payload), frameMessage()));
}

TEST(Golden, Poses) {
  EXPECT_EQ(hexOf(encode(posesMessage())), kPoses);
  const Bytes bytes = bytesOf(kPoses);
  const auto frame = parseFrame(bytes, Expect::FromMaster);
  ASSERT_TRUE(frame.ok()) << frame.error().text();
  EXPECT_EQ(*decodePoses(frame->payload), posesMessage());
}

TEST(Golden, TileSetup) {
  EXPECT_EQ(hexOf(encode(tileSetupMessage())), kTileSetup);
  const Bytes bytes = bytesOf(kTileSetup);
  const auto frame = parseFrame(bytes, Expect::FromMaster);
  ASSERT_TRUE(frame.ok()) << frame.error().text();
  EXPECT_TRUE(isSame(*decodeTileSetup(frame->payload), tileSetupMessage()));
}

// All that a frame may have.
TEST(Golden, StereoFrame) {
  tessera::proto::Frame message = frameMessage();
  message.overlay = true;
  message.pattern = Pattern::Alignment;
  message.skewUs = 420;
  message.rightEye = RightEye{.eye = {1.5, 2, 3}, .corners = message.corners};
  message.stereo = StereoLayout::TopBottom;
  EXPECT_EQ(hexOf(encode(message)), kStereoFrame);
  const Bytes bytes = bytesOf(kStereoFrame);
  EXPECT_TRUE(isSame(*decodeFrame(test::payloadOf(bytes)), message));
}

TEST(Golden, AnEncoderGivesTheSameBytesWhateverItEncodedBefore) {
  Encoder encoder;
  const std::vector<std::byte> longer(5000, std::byte{1});
  Frame other = frameMessage();
  other.toggles = longer;
  for (int round = 0; round < 3; ++round) {
    EXPECT_EQ(hexOf(encoder.encode(frameMessage())), kFrame);
    EXPECT_EQ(hexOf(encoder.encode(other)), hexOf(encode(other)));
    EXPECT_EQ(hexOf(encoder.encode(Swap{9})), hexOf(encode(Swap{9})));
  }
}

}  // namespace
}  // namespace tessera::proto
