// The frame loop's thread must not allocate once warm: this program counts what each thread allocates.

#include <array>
#include <cstdlib>
#include <memory>
#include <new>
#include <numbers>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

#include "common/wall/wall_file.h"
#include "proto/list_coder.h"
#include "server/master/master.h"

namespace {

thread_local std::uint64_t allocations = 0;

void* countedNew(std::size_t bytes, std::size_t alignment) {
  ++allocations;
  void* memory = alignment > alignof(std::max_align_t)
                     ? std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment)
                     : std::malloc(bytes ? bytes : 1);
  if (!memory) throw std::bad_alloc();
  return memory;
}

}  // namespace

// The other forms of new and delete come to these.
void* operator new(std::size_t bytes) {
  return countedNew(bytes, 1);
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return countedNew(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace tessera {
namespace {

constexpr std::uint64_t kLoopFrames = 100;
constexpr std::uint64_t kFrames = 4 * kLoopFrames + 1;  // the path's last pose is its first
// Turns are alike but for the path's two ends, which are rounded off less: a loop in its middle is judged.
constexpr std::uint64_t kWarmFrames = 2 * kLoopFrames;

/// A tile that draws nothing, but keeps its list as a tile must and checks what it is told.
class FakeTile {
 public:
  FakeTile(net::asio::io_context& io, std::string port, std::string name) {
    net::asio::co_spawn(io, converse(std::move(port), std::move(name)), net::asio::detached);
  }
  [[nodiscard]] std::uint64_t framesShown() const { return framesShown_; }
  [[nodiscard]] std::uint64_t wholeLists() const { return wholeLists_; }
  [[nodiscard]] const std::string& fault() const { return fault_; }
  /// Keeps back the Ready of one frame so long.
  void dawdle(std::uint64_t frame, std::chrono::milliseconds so) { slowFrame_ = frame, slowness_ = so; }

 private:
  net::awaitable<void> converse(std::string port, std::string name) {
    const net::HostPort address{"127.0.0.1", port};
    auto connected = co_await net::connect(address, net::Milliseconds(5000));
    if (!connected) {
      fault_ = connected.error().text();
      co_return;
    }
    const std::shared_ptr<net::Connection> master = *connected;
    master->startWriter(net::Milliseconds(5000));
    proto::Hello hello;
    hello.tileName = name;
    hello.programVersion = "test";
    master->send(proto::encode(hello));
    auto expect = proto::Expect::WelcomeOrError;
    for (bool over = false; !over && fault_.empty(); expect = proto::Expect::FromMaster) {
      auto message = co_await master->read(expect, net::Milliseconds(20'000));
      if (!message) {
        fault_ = message.error().text();
        break;
      }
      if (message->type == proto::MessageType::Welcome) {
        leafCount_ = proto::decodeWelcome(message->payload)->leafCount;
        list_ = proto::ListDecoder(leafCount_);
      }
      if (message->type == proto::MessageType::Leaves) {
        known_.resize(leafCount_);
        const auto leaves = proto::decodeLeaves(message->payload);
        for (const auto& leaf : leaves->leaves)
          known_[leaf.id] = true;
      }
      if (message->type == proto::MessageType::Frame) {
        const auto frame = proto::decodeFrame(message->payload);
        take(*frame);
        if (frame->frame == slowFrame_) {
          net::asio::steady_timer pause(co_await net::asio::this_coro::executor, slowness_);
          co_await pause.async_wait(net::asio::use_awaitable);
        }
        master->send(proto::encode(proto::Ready{frame->frame, 1, frame->listLeafCount}));
      }
      if (message->type == proto::MessageType::Swap) {
        const std::uint64_t frame = proto::decodeSwap(message->payload)->frame;
        if (frame == frame_) {
          ++framesShown_;
          master->send(proto::encode(proto::Shown{.frame = frame, .shownNs = 1, .picture = {}}));
        }
      }
      if (message->type == proto::MessageType::Bye) {
        master->send(proto::encode(proto::Bye{.reason = "bye"}));
        over = true;
      }
    }
    master->closeAfterSending();
  }

  void take(const proto::Frame& frame) {
    if (frame.baseFrame != 0 && frame.baseFrame != frame_)
      fault_ = "a frame builds on a list that is not here";
    if (frame.baseFrame == 0) {
      list_.reset();
      ++wholeLists_;
    }
    if (!list_.decode(frame.toggles)) fault_ = "a delta is refused";
    if (leafCount(list_.list()) != frame.listLeafCount) fault_ = "a list is not as long as it should be";
    known_.resize(leafCount_);
    forEachLeaf(list_.list(), [this](std::uint32_t leaf) {
      if (!known_[leaf]) fault_ = "a leaf is listed that was not sent";
    });
    frame_ = frame.frame;
  }

  std::uint32_t leafCount_ = 0;
  std::vector<bool> known_;
  proto::ListDecoder list_{0};
  std::uint64_t frame_ = 0, framesShown_ = 0, wholeLists_ = 0, slowFrame_ = 0;
  std::chrono::milliseconds slowness_{0};
  std::string fault_;
};

/// Boxes on a square, in groups of rows.
Scene squareOfBoxes(int side) {
  Scene scene;
  const std::uint32_t drawable = *scene.assets.add(AssetKind::Drawable, "a box");
  const std::uint32_t state = *scene.assets.add(AssetKind::State, "a state");
  ObjectHierarchyBuilder builder;
  builder.openNode();
  for (int row = 0; row < side; ++row) {
    builder.openNode();
    for (int column = 0; column < side; ++column) {
      std::array<Vec3, 8> corners;
      for (unsigned i = 0; i < 8; ++i)
        corners[i] = Vec3(column + (i & 1U) * 0.5, (i >> 1U & 1U) * 0.5, row + (i >> 2U & 1U) * 0.5);
      builder.addLeaf(boundsOf(corners, Vec3::Zero()));
      SceneLeaf leaf;
      leaf.drawable = drawable;
      leaf.state = state;
      leaf.triangles = 12;
      scene.leaves.push_back(leaf);
    }
    builder.closeNode();
  }
  builder.closeNode();
  scene.hierarchy = builder.finish();
  scene.source = "boxes";
  return scene;
}

/// Over the boxes, `turns` times around.
CameraPath circling(std::uint64_t turns) {
  constexpr std::uint64_t kKeyframes = 16;
  std::string text = R"({"space": "scene", "keyframes": [)";
  for (std::uint64_t i = 0; i <= turns * kKeyframes; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i % kKeyframes) / kKeyframes;
    text += (i ? ", " : "") + std::string(R"({"time_s": )") + std::to_string(i) + R"(, "eye": [)" +
            std::to_string(0.6 * std::cos(angle)) + ", 0.2, " + std::to_string(0.6 * std::sin(angle)) +
            R"(], "target": [0, 0, 0.1]})";
  }
  return *parseCameraPath(text + "]}", "test");
}

Wall wallOf(int columns, int rows) {
  return *parseWall("{\"grid\": {\"columns\": " + std::to_string(columns) +
                        ", \"rows\": " + std::to_string(rows) + ", \"tile_px\": [64, 48]}}",
                    "test");
}

/// A master and its tiles, which run in a thread of their own.
class FrameLoop : public ::testing::Test {
 protected:
  void run(const MasterOptions& options, const CameraPath& path) {
    const auto setups = TileSetups::make(wall_);
    Master master(scene_, wall_, path, *setups, options);
    const auto port = master.listen({"127.0.0.1", "0"});
    ASSERT_TRUE(port) << port.error().text();
    net::asio::io_context io(1);
    for (const Tile& tile : wall_.tiles)
      tiles_.push_back(std::make_unique<FakeTile>(io, std::to_string(*port), tile.name));
    if (slowFrame_ != 0) tiles_.front()->dawdle(slowFrame_, slowness_);
    std::thread thread([&io] { io.run(); });
    std::uint64_t frame = 0;
    Master::Hooks hooks;
    hooks.whileWaitingForTiles = [] { return Status(Done{}); };
    hooks.eachFrame = [&] {
      if (++frame == kWarmFrames) whenWarm_ = allocations;
      if (frame == kWarmFrames + kLoopFrames) aLoopLater_ = allocations;
      if (frame == kFrames) master.stop();
    };
    auto report = master.run(hooks, false);
    thread.join();
    ASSERT_TRUE(report) << report.error().text();
    report_ = *std::move(report);
    for (const auto& tile : tiles_)
      EXPECT_EQ(tile->fault(), "");
  }

  Scene scene_ = squareOfBoxes(40);
  Wall wall_ = wallOf(4, 4);
  std::vector<std::unique_ptr<FakeTile>> tiles_;
  std::uint64_t slowFrame_ = 0;
  std::chrono::milliseconds slowness_{0};
  std::uint64_t whenWarm_ = 0, aLoopLater_ = 0;
  RunReport report_;
};

class FrameLoopOf : public FrameLoop, public ::testing::WithParamInterface<cull::Algorithm> {};

TEST_P(FrameLoopOf, DoesNotAllocateOnceEverythingHasBeenSeen) {
  MasterOptions options;
  options.cull.algorithm = GetParam();
  options.frames = kFrames;
  options.stream.predictFrames = 0;  // else the next round sends ahead what this one did not
  run(options, circling(4));
  EXPECT_GT(whenWarm_, 0U) << "nothing is counted";
  EXPECT_EQ(aLoopLater_ - whenWarm_, 0U);
  EXPECT_EQ(report_.frames, kFrames);
  EXPECT_EQ(report_.masterMs.values.size(), kFrames);
  EXPECT_GT(report_.listBytesPerFrame.max(), 0);
  for (const auto& tile : tiles_) {
    EXPECT_GE(tile->framesShown(), kFrames - 1);
    EXPECT_EQ(tile->wholeLists(), 1U) << "a tile that keeps up is told the changes";
  }
}

INSTANTIATE_TEST_SUITE_P(Algorithms, FrameLoopOf,
                         ::testing::Values(cull::Algorithm::Adaptive, cull::Algorithm::Auto),
                         [](const auto& test) { return std::string(cull::nameOf(test.param)); });

TEST_F(FrameLoop, DoesNotAllocateInARunWithoutAnEnd) {
  MasterOptions options;
  options.frames = 0;
  options.loopFrames = kLoopFrames;
  options.stream.predictFrames = 0;
  run(options, circling(1));
  EXPECT_EQ(aLoopLater_ - whenWarm_, 0U);
  EXPECT_EQ(report_.frames, kFrames);
}

TEST_F(FrameLoop, PredictingDoesNotAllocateOnceAllIsThere) {
  MasterOptions options;
  options.frames = kFrames;
  const CameraPath standing = *parseCameraPath(R"({"space": "scene", "keyframes": [
      {"time_s": 0, "eye": [0.6, 0.2, 0], "target": [0, 0, 0.1]},
      {"time_s": 1, "eye": [0.6, 0.2, 0], "target": [0, 0, 0.1]}]})",
                                               "test");
  run(options, standing);
  EXPECT_EQ(aLoopLater_ - whenWarm_, 0U);
  std::uint64_t ahead = 0;
  for (const auto& tile : report_.tiles)
    ahead += tile.predictedBytes;
  EXPECT_EQ(report_.frames, kFrames);
  EXPECT_EQ(ahead, 0U) << "both assets are there from the start";
}

TEST_F(FrameLoop, ATileThatFellBehindIsSentItsWholeListAgain) {
  slowFrame_ = 20;
  slowness_ = std::chrono::milliseconds(300);
  MasterOptions options;
  options.frames = 100;
  options.framesPerSecond = 100;
  options.frameDeadline = std::chrono::milliseconds(100);
  run(options, circling(1));
  EXPECT_EQ(tiles_.front()->wholeLists(), 2U);
  EXPECT_EQ(tiles_.back()->wholeLists(), 1U);
  EXPECT_GT(report_.tiles.front().counts.framesMissed, 0U);
}

TEST(Recorded, KeepsTheLastValuesOfARunWithoutAnEnd) {
  Samples all, last;
  last.keepLast(10);
  for (int i = 1; i <= 1005; ++i) {
    all.add(i);
    last.add(i);
  }
  EXPECT_EQ(all.percentile(100), 1005);
  EXPECT_EQ(all.percentile(0), 1);
  EXPECT_EQ(last.values.size(), 10U);
  EXPECT_EQ(last.percentile(0), 996);
  EXPECT_EQ(last.percentile(100), 1005);
}

}  // namespace
}  // namespace tessera
