// What a tile answers to a master that plays its part badly, or just at its own pace.
#include <array>
#include <cstring>
#include <future>
#include <span>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "client/offscreen_surface.h"
#include "client/test_pattern.h"
#include "client/tile_client.h"
#include "common/image/picture.h"
#include "proto/codec.h"

namespace tessera::test {
namespace {

using proto::MessageType;

/// A master with one tile, by blocking sockets; every wait ends after ten seconds.
class FakeMaster {
 public:
  FakeMaster() : listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
    limit(listener_);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    EXPECT_EQ(::bind(listener_, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
    EXPECT_EQ(::listen(listener_, 1), 0);
    EXPECT_EQ(::getsockname(listener_, reinterpret_cast<sockaddr*>(&at), &size), 0);
    port_ = ntohs(at.sin_port);
  }
  ~FakeMaster() {
    if (peer_ >= 0) ::close(peer_);
    ::close(listener_);
  }
  FakeMaster(const FakeMaster&) = delete;
  FakeMaster& operator=(const FakeMaster&) = delete;

  [[nodiscard]] int port() const { return port_; }

  /// Waits for the tile's Hello and welcomes it.
  void welcome(int widthPx, int heightPx) {
    peer_ = ::accept(listener_, nullptr, nullptr);
    ASSERT_GE(peer_, 0);
    limit(peer_);
    ASSERT_EQ(hear().type, MessageType::Hello);
    proto::Welcome welcome;
    welcome.wallName = "wall";
    welcome.tileName = "r0c0";
    welcome.widthPx = welcome.wallWidthPx = widthPx;
    welcome.heightPx = welcome.wallHeightPx = heightPx;
    welcome.idleTimeoutMs = 10'000;
    welcome.leafCount = 1;
    welcome.picture = proto::PictureFormat::RawRgb8;
    say(proto::encode(welcome));
  }

  void say(const proto::Bytes& bytes) const {
    EXPECT_EQ(::send(peer_, bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
  }

  struct Heard {
    MessageType type = MessageType::Error;
    std::vector<std::byte> payload;
  };
  [[nodiscard]] Heard hear() const {
    std::array<std::byte, proto::kHeaderBytes> bytes = {};
    receive(bytes);
    const auto header = proto::parseHeader(bytes);
    EXPECT_TRUE(header.ok());
    if (!header) return {};
    Heard heard{header->type, std::vector<std::byte>(header->payloadBytes)};
    receive(heard.payload);
    return heard;
  }

  [[nodiscard]] std::string hearError() const {
    const Heard heard = hear();
    EXPECT_EQ(heard.type, MessageType::Error) << proto::nameOf(heard.type);
    const auto error = proto::decodeError(heard.payload);
    return error ? error->text : std::string();
  }

  /// Swaps the frame that was sent and returns its picture.
  [[nodiscard]] Picture swapped(std::uint64_t frame) const {
    EXPECT_EQ(hear().type, MessageType::Ready);
    say(proto::encode(proto::Swap{frame}));
    const Heard heard = hear();
    const auto shown = proto::decodeShown(heard.payload);
    EXPECT_TRUE(shown.ok() && shown->picture);
    if (!shown || !shown->picture) return {};
    Picture picture(shown->picture->widthPx, shown->picture->heightPx);
    std::memcpy(picture.rgb.data(), shown->picture->bytes.data(), picture.rgb.size());
    return picture;
  }

 private:
  static void limit(int socket) {
    const timeval tenSeconds{10, 0};
    ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &tenSeconds, sizeof tenSeconds);
  }
  void receive(std::span<std::byte> to) const {
    while (!to.empty()) {
      const ssize_t count = ::recv(peer_, to.data(), to.size(), 0);
      ASSERT_GT(count, 0) << "the tile says nothing";
      to = to.subspan(static_cast<std::size_t>(count));
    }
  }

  int listener_, peer_ = -1;
  int port_ = 0;
};

class Conversation : public ::testing::Test {
 protected:
  void start(proto::SurfaceKind surface) {
    tile_ = std::async(std::launch::async, [this, surface] {
      TileOptions options;
      options.master = {"127.0.0.1", std::to_string(master_.port())};
      options.tileNames = {"r0c0"};
      options.surface = surface;
      const std::unique_ptr<SurfaceMaker> surfaces = makeOffscreenSurfaces();
      if (surface != proto::SurfaceKind::None) options.surfaces = surfaces.get();
      return runTiles(options);
    });
    master_.welcome(64, 48);
  }

  static proto::Frame frame(std::uint64_t number) {
    proto::Frame frame;
    frame.frame = number;
    frame.corners = {Vec3(-1, -1, -1), Vec3(1, -1, -1), Vec3(1, 1, -1), Vec3(-1, 1, -1)};
    frame.wantPicture = true;
    return frame;
  }

  void endInOrder() {
    master_.say(proto::encode(proto::Bye{.reason = "done"}));
    EXPECT_EQ(master_.hear().type, MessageType::Bye);
    const Status status = tile_.get();
    EXPECT_TRUE(status.ok()) << (status ? "" : status.error().text());
  }

  FakeMaster master_;
  std::future<Status> tile_;
};

TEST_F(Conversation, ASecondSetupIsRefused) {
  start(proto::SurfaceKind::None);
  master_.say(proto::encode(proto::TileSetup{}));
  master_.say(proto::encode(proto::TileSetup{}));
  EXPECT_NE(master_.hearError().find("a second time"), std::string::npos);
  EXPECT_FALSE(tile_.get().ok());
}

TEST_F(Conversation, ASetupAfterAFrameIsRefused) {
  start(proto::SurfaceKind::None);
  master_.say(proto::encode(frame(1)));
  EXPECT_EQ(master_.hear().type, MessageType::Ready);
  master_.say(proto::encode(proto::TileSetup{}));
  EXPECT_NE(master_.hearError().find("after a frame"), std::string::npos);
  EXPECT_FALSE(tile_.get().ok());
}

TEST_F(Conversation, ASetupIsFineWhereNothingIsDrawn) {
  start(proto::SurfaceKind::None);
  master_.say(proto::encode(proto::TileSetup{.gainRgb = {2, 2, 2}}));
  proto::Frame all = frame(1);
  all.overlay = true;
  all.pattern = proto::Pattern::Alignment;
  all.wantPicture = false;
  master_.say(proto::encode(all));
  EXPECT_EQ(master_.hear().type, MessageType::Ready);
  endInOrder();
}

TEST_F(Conversation, TheSetupHoldsForAllFrames) {
  start(proto::SurfaceKind::Offscreen);
  const proto::TileSetup setup = {.screenName = "front", .screenWidthM = 2, .screenHeightM = 1.5};
  master_.say(proto::encode(setup));
  const TilePlace place = {.tileName = "r0c0",
                           .screenName = "front",
                           .widthPx = 64,
                           .heightPx = 48,
                           .screenWidthM = 2,
                           .screenHeightM = 1.5,
                           .cornersM = setup.cornersM};
  for (const std::uint64_t number : {1U, 2U}) {
    proto::Frame pattern = frame(number);
    pattern.pattern = proto::Pattern::Alignment;
    master_.say(proto::encode(pattern));
    EXPECT_EQ(master_.swapped(number).rgb, alignmentPattern(place).rgb);
  }
  // The overlay tells what this tile was sent: bytes, but no leaves.
  proto::Frame overlay = frame(3);
  overlay.overlay = true;
  master_.say(proto::encode(overlay));
  const Picture with = master_.swapped(3);
  master_.say(proto::encode(frame(4)));
  EXPECT_NE(with.rgb, master_.swapped(4).rgb);
  endInOrder();
}

TEST_F(Conversation, StereoThatTheDisplayCannotShowEndsWithOneError) {
  start(proto::SurfaceKind::Offscreen);
  proto::Frame stereo = frame(1);
  stereo.stereo = proto::StereoLayout::QuadBuffer;
  stereo.rightEye = proto::RightEye{stereo.eye, stereo.corners};
  master_.say(proto::encode(stereo));
  EXPECT_NE(master_.hearError().find("quad-buffered stereo"), std::string::npos);
  EXPECT_FALSE(tile_.get().ok());
}

}  // namespace
}  // namespace tessera::test
