// What people do at the tiles' windows, from the tile's message to the end of the run.

#include <memory>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

#include "common/wall/wall_file.h"
#include "server/master/input_queue.h"
#include "server/master/master.h"

namespace tessera {
namespace {

using proto::Input;
using proto::InputKind;

Input key(int code) {
  return {.kind = InputKind::Key, .code = code, .pressed = true};
}
Input move(double x) {
  return {.kind = InputKind::Move, .x = x, .y = 0.5};
}
constexpr Input kQuit = {.kind = InputKind::Quit};

class Queue : public ::testing::Test {
 protected:
  std::vector<TileInput> drain() {
    std::vector<TileInput> inputs;
    queue_.drainInto(inputs);
    return inputs;
  }
  InputQueue queue_;
};

TEST_F(Queue, GivesEverythingOnceAndInOrder) {
  queue_.add(3, key(1));
  queue_.add(1, key(2));
  queue_.add(3, key(1));
  std::vector<TileInput> inputs(7);
  queue_.drainInto(inputs);
  ASSERT_EQ(inputs.size(), 3U) << "what was there before is gone";
  EXPECT_EQ(inputs[0].tile, 3U);
  EXPECT_EQ(inputs[1].tile, 1U);
  EXPECT_EQ(inputs[1].input, key(2));
  EXPECT_TRUE(drain().empty());
}

TEST_F(Queue, MovesOfATileInARowAreOne) {
  queue_.add(0, move(0.1));
  queue_.add(1, move(0.2));
  queue_.add(0, move(0.3));
  queue_.add(0, key(1));
  queue_.add(0, move(0.4));
  const auto inputs = drain();
  ASSERT_EQ(inputs.size(), 4U);
  EXPECT_EQ(inputs[0].input, move(0.3));
  EXPECT_EQ(inputs[1].input, move(0.2));
  EXPECT_EQ(inputs[3].input, move(0.4));
}

TEST_F(Queue, TurnsOfTheWheelAddUpAndStayAllowed) {
  for (int i = 0; i < 3; ++i)
    queue_.add(0, {.kind = InputKind::Scroll, .x = 1, .y = -900});
  const auto inputs = drain();
  ASSERT_EQ(inputs.size(), 1U);
  EXPECT_EQ(inputs[0].input.x, 3);
  EXPECT_EQ(inputs[0].input.y, -proto::kMaxScrollSteps);
}

TEST_F(Queue, AGamepadsButtonThatWasPressedAndLetGoIsSeen) {
  const auto pad = [](float x, std::uint32_t buttons) {
    return Input{.kind = InputKind::Gamepad, .axes = {x}, .buttons = buttons};
  };
  queue_.add(0, pad(0.1F, 0));
  queue_.add(0, pad(0.2F, 0));
  queue_.add(0, pad(0.2F, 1));
  queue_.add(0, pad(0.2F, 0));
  const auto inputs = drain();
  ASSERT_EQ(inputs.size(), 3U);
  EXPECT_EQ(inputs[0].input.axes[0], 0.2F);
  EXPECT_EQ(inputs[1].input.buttons, 1U);
}

TEST_F(Queue, WhenFullTheOldestMoveMakesRoomFirst) {
  queue_.add(0, key(7));
  queue_.add(0, move(0.5));
  for (std::uint32_t i = 0; i < InputQueue::kCapacity - 1; ++i)
    queue_.add(1, key(static_cast<int>(i)));
  auto inputs = drain();
  ASSERT_EQ(inputs.size(), InputQueue::kCapacity);
  EXPECT_EQ(inputs[0].input, key(7)) << "older than the move, and kept";
  EXPECT_EQ(inputs[1].input, key(0));
  for (std::uint32_t i = 0; i < InputQueue::kCapacity + 10; ++i)
    queue_.add(1, key(static_cast<int>(i)));
  inputs = drain();
  ASSERT_EQ(inputs.size(), InputQueue::kCapacity);
  EXPECT_EQ(inputs[0].input, key(10)) << "without a move the oldest makes room";
}

TEST_F(Queue, QuitIsNeverDropped) {
  queue_.add(5, kQuit);
  for (int i = 0; i < 10'000; ++i)
    queue_.add(static_cast<std::uint32_t>(i % 7), i % 2 ? key(i % 1000) : move(i % 100 / 100.0));
  std::size_t quits = 0;
  const auto inputs = drain();
  EXPECT_LE(inputs.size(), InputQueue::kCapacity);
  for (const TileInput& one : inputs)
    quits += one.tile == 5 && one.input.kind == InputKind::Quit ? 1U : 0U;
  EXPECT_EQ(quits, 1U);
}

TEST_F(Queue, TakesAndGivesFromSeveralThreads) {
  constexpr int kEach = 20'000;
  std::vector<std::thread> threads;
  for (std::uint32_t tile = 0; tile < 3; ++tile) {
    threads.emplace_back([this, tile] {
      for (int i = 0; i < kEach; ++i)
        queue_.add(tile, key(i % 1000));
    });
  }
  std::vector<TileInput> inputs;
  std::size_t all = 0;
  for (int i = 0; i < 1000; ++i) {
    queue_.drainInto(inputs);
    ASSERT_LE(inputs.size(), InputQueue::kCapacity);
    all += inputs.size();
  }
  for (std::thread& thread : threads)
    thread.join();
  EXPECT_LE(all + drain().size(), 3U * kEach);
}

/// A tile that draws nothing and says `inputs` once it has shown a frame, or at once.
class FakeTile {
 public:
  FakeTile(net::asio::io_context& io, std::uint16_t port, std::string name, std::vector<Input> inputs,
           std::uint64_t afterFrame)
      : inputs_(std::move(inputs)), afterFrame_(afterFrame) {
    net::asio::co_spawn(io, converse(std::to_string(port), std::move(name)), net::asio::detached);
  }
  [[nodiscard]] std::uint64_t framesShown() const { return framesShown_; }
  [[nodiscard]] bool heardBye() const { return heardBye_; }
  [[nodiscard]] const std::optional<proto::ErrorMessage>& refusal() const { return refusal_; }

 private:
  net::awaitable<void> converse(std::string port, std::string name) {
    const net::HostPort address{"127.0.0.1", port};
    const auto connected = co_await net::connect(address, net::Milliseconds(5000));
    if (!connected) co_return;
    const std::shared_ptr<net::Connection> master = *connected;
    master->startWriter(net::Milliseconds(5000));
    master->send(proto::encode(proto::Hello{.tileName = name, .programVersion = "test"}));
    auto expect = proto::Expect::WelcomeOrError;
    for (; !heardBye_ && !refusal_; expect = proto::Expect::FromMaster) {
      auto message = co_await master->read(expect, net::Milliseconds(20'000));
      if (!message) break;
      if (message->type == proto::MessageType::Frame) {
        const auto frame = proto::decodeFrame(message->payload);
        master->send(proto::encode(proto::Ready{frame->frame, 1, frame->listLeafCount}));
      }
      if (message->type == proto::MessageType::Swap) {
        ++framesShown_;
        master->send(proto::encode(proto::Shown{proto::decodeSwap(message->payload)->frame, 1, {}}));
      }
      if (framesShown_ == afterFrame_) {
        for (const Input& input : inputs_)
          master->send(proto::encode(input));
        inputs_.clear();
      }
      if (message->type == proto::MessageType::Error) refusal_ = *proto::decodeError(message->payload);
      if (message->type == proto::MessageType::Bye) {
        master->send(proto::encode(proto::Bye{.reason = "bye"}));
        heardBye_ = true;
      }
    }
    master->closeAfterSending();
  }

  std::vector<Input> inputs_;
  std::uint64_t afterFrame_, framesShown_ = 0;
  bool heardBye_ = false;
  std::optional<proto::ErrorMessage> refusal_;
};

Scene oneBox() {
  Scene scene;
  ObjectHierarchyBuilder builder;
  builder.openNode();
  std::array<Vec3, 8> corners;
  for (unsigned i = 0; i < 8; ++i)
    corners[i] = Vec3(i & 1U, i >> 1U & 1U, i >> 2U & 1U);
  builder.addLeaf(boundsOf(corners, Vec3::Zero()));
  builder.closeNode();
  scene.hierarchy = builder.finish();
  SceneLeaf leaf;
  leaf.drawable = *scene.assets.add(AssetKind::Drawable, "a box");
  leaf.state = *scene.assets.add(AssetKind::State, "a state");
  leaf.triangles = 12;
  scene.leaves.push_back(leaf);
  return scene;
}

/// A wall of two tiles, of which the second says what the test tells it to.
class InputOfTiles : public ::testing::Test {
 protected:
  void run(std::vector<Input> inputs, std::uint64_t afterFrame, bool withFirst, MasterOptions options) {
    const auto setups = TileSetups::make(wall_);
    Master master(scene_, wall_, path_, *setups, options);
    const auto port = master.listen({"127.0.0.1", "0"});
    ASSERT_TRUE(port) << port.error().text();
    net::asio::io_context io(1);
    if (withFirst) first_.emplace(io, *port, "r0c0", std::vector<Input>{}, UINT64_MAX);
    second_.emplace(io, *port, "r0c1", std::move(inputs), afterFrame);
    std::thread thread([&io] { io.run(); });
    Master::Hooks hooks;
    hooks.whileWaitingForTiles = [] { return Status(Done{}); };
    hooks.input = [this](std::uint32_t tile, const Input& input) { seen_.push_back({tile, input}); };
    const auto start = std::chrono::steady_clock::now();
    auto report = master.run(hooks, true);
    tookS_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    thread.join();
    ASSERT_TRUE(report) << report.error().text();
    report_ = *std::move(report);
  }

  static MasterOptions endless() {
    MasterOptions options;
    options.frames = 0;
    options.framesPerSecond = 200;
    return options;
  }

  const Scene scene_ = oneBox();
  const Wall wall_ = *parseWall(R"({"grid": {"columns": 2, "rows": 1, "tile_px": [64, 48]}})", "test");
  const CameraPath path_ = *parseCameraPath(
      R"({"space": "scene", "keyframes": [{"time_s": 0, "eye": [0, 0, 3], "target": [0, 0, 0]}]})", "test");
  std::optional<FakeTile> first_, second_;
  std::vector<TileInput> seen_;
  RunReport report_;
  double tookS_ = 0;
};

TEST_F(InputOfTiles, ReachesTheHookAndQuitEndsTheRunInOrder) {
  run({key(65), move(0.25), kQuit}, 5, true, endless());
  ASSERT_EQ(seen_.size(), 3U);
  for (const TileInput& one : seen_)
    EXPECT_EQ(one.tile, 1U);
  EXPECT_EQ(seen_[0].input, key(65));
  EXPECT_EQ(seen_[1].input, move(0.25));
  EXPECT_EQ(seen_[2].input, kQuit);
  EXPECT_GE(report_.frames, 5U);
  EXPECT_TRUE(first_->heardBye());
  EXPECT_TRUE(second_->heardBye());
  EXPECT_LT(tookS_, 5);
}

TEST_F(InputOfTiles, QuitEndsTheWaitForOtherTiles) {
  MasterOptions options = endless();
  options.tilesDeadline = std::chrono::seconds(20);
  run({kQuit}, 0, false, options);
  EXPECT_EQ(report_.frames, 0U);
  EXPECT_TRUE(second_->heardBye());
  EXPECT_LT(tookS_, 5);
}

TEST_F(InputOfTiles, OtherInputEndsNothing) {
  MasterOptions options = endless();
  options.frames = 50;
  options.framesPerSecond = 0;
  run({key(256), move(1)}, 5, true, options);
  EXPECT_EQ(report_.frames, 50U);
  EXPECT_EQ(seen_.size(), 2U);
  EXPECT_GE(first_->framesShown(), 49U);
}

TEST_F(InputOfTiles, AThousandInASecondAreAllowed) {
  MasterOptions options = endless();
  options.frames = 50;
  run(std::vector<Input>(1000, key(65)), 5, true, options);
  EXPECT_FALSE(second_->refusal());
  EXPECT_TRUE(second_->heardBye());
}

TEST_F(InputOfTiles, AFloodIsAViolationThatLeavesTheOthersAlone) {
  MasterOptions options = endless();
  options.frames = 200;
  run(std::vector<Input>(3000, key(65)), 5, true, options);
  ASSERT_TRUE(second_->refusal());
  EXPECT_EQ(second_->refusal()->code, proto::ErrorCode::ProtocolViolation);
  EXPECT_NE(second_->refusal()->text.find("more input than"), std::string::npos) << second_->refusal()->text;
  EXPECT_LT(second_->framesShown(), 150U);
  EXPECT_EQ(report_.frames, 200U);
  EXPECT_GE(first_->framesShown(), 199U);
  EXPECT_TRUE(first_->heardBye());
}

}  // namespace
}  // namespace tessera
