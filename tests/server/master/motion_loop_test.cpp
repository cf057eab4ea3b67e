// Tiles know where moving leaves are whenever they draw them: also those that come late or fall behind.

#include <array>
#include <memory>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

#include "common/scene/motion/channel.h"
#include "common/scene/motion/motion_codec.h"
#include "common/wall/wall_file.h"
#include "proto/list_coder.h"
#include "proto/pose_codec.h"
#include "server/master/master.h"

namespace tessera {
namespace {

constexpr int kSide = 12;
constexpr std::uint64_t kFrames = 90;

/// Every third box goes up and down, each in its own time; all stand in rows.
motion::Motion upAndDown() {
  motion::Motion motion;
  for (std::uint32_t leaf = 0; leaf < kSide * kSide; leaf += 3) {
    const auto node = static_cast<std::uint32_t>(motion.nodes.size());
    motion.nodes.emplace_back();
    motion::Channel channel;
    channel.node = node;
    channel.periodS = 1 + 0.01F * static_cast<float>(leaf);
    channel.timesS = {0, channel.periodS / 2, channel.periodS};
    channel.values = {0, 0, 0, 0, 5, 0, 0, 0, 0};
    motion.channels.push_back(channel);
    motion::Leaf moving;
    moving.graphLeaf = leaf;
    moving.node = node;
    const std::array corners = {Vec3(0, 0, 0), Vec3(0.5, 0.5, 0.5)};
    moving.bounds = boundsOf(corners, Vec3::Zero());
    moving.nodeToLeaf.topRightCorner<3, 1>() = Vec3(leaf % kSide, 0, leaf / kSide);
    motion.leaves.push_back(moving);
  }
  return motion;
}

Scene movingBoxes() {
  Scene scene;
  const std::uint32_t drawable = *scene.assets.add(AssetKind::Drawable, "a box");
  const std::uint32_t state = *scene.assets.add(AssetKind::State, "a state");
  ObjectHierarchyBuilder builder;
  for (int row = 0; row < kSide; ++row) {
    builder.openNode();
    for (int column = 0; column < kSide; ++column) {
      const std::array corners = {Vec3(column, 0, row), Vec3(column + 0.5, 0.5, row + 0.5)};
      builder.addLeaf(boundsOf(corners, Vec3::Zero()));
      SceneLeaf leaf;
      leaf.drawable = drawable;
      leaf.state = state;
      leaf.graphLeaf = static_cast<std::uint32_t>(scene.leaves.size());
      leaf.localToWorld.topRightCorner<3, 1>() = Vec3(column, 0, row);
      scene.leaves.push_back(leaf);
    }
    builder.closeNode();
  }
  scene.hierarchy = builder.finish();
  const std::string encoded = motion::encodeMotion(upAndDown());
  scene.motion = std::vector<char>(encoded.begin(), encoded.end());
  return scene;
}

/// A tile that draws nothing, but knows where everything is that it is asked to draw.
class FakeTile {
 public:
  FakeTile(net::asio::io_context& io, std::string port, std::string name, std::chrono::milliseconds late)
      : late_(late) {
    net::asio::co_spawn(io, converse(std::move(port), std::move(name)), net::asio::detached);
  }
  void dawdle(std::uint64_t frame, std::chrono::milliseconds so) { slowFrame_ = frame, slowness_ = so; }

  double boundM = 0;  ///< how far a leaf may be from its place
  std::string fault;
  std::uint64_t checked = 0, frames = 0, firstFrame = 0;

 private:
  net::awaitable<void> pause(std::chrono::milliseconds so) {
    net::asio::steady_timer timer(co_await net::asio::this_coro::executor, so);
    co_await timer.async_wait(net::asio::use_awaitable);
  }

  net::awaitable<void> converse(std::string port, std::string name) {
    co_await pause(late_);
    const net::HostPort address{"127.0.0.1", port};
    auto connected = co_await net::connect(address, net::Milliseconds(5000));
    if (!connected) {
      fault = connected.error().text();
      co_return;
    }
    const std::shared_ptr<net::Connection> master = *connected;
    master->startWriter(net::Milliseconds(5000));
    proto::Hello hello;
    hello.tileName = name;
    hello.programVersion = "test";
    master->send(proto::encode(hello));
    auto expect = proto::Expect::WelcomeOrError;
    for (bool over = false; !over && fault.empty(); expect = proto::Expect::FromMaster) {
      auto message = co_await master->read(expect, net::Milliseconds(20'000));
      if (!message) {
        fault = message.error().text();
        break;
      }
      switch (message->type) {
        case proto::MessageType::Welcome:
          leafCount_ = proto::decodeWelcome(message->payload)->leafCount;
          list_ = proto::ListDecoder(leafCount_);
          records_.resize(leafCount_);
          places_.resize(leafCount_);
          break;
        case proto::MessageType::Leaves: {
          const auto leaves = proto::decodeLeaves(message->payload);
          for (const auto& leaf : leaves->leaves)
            records_[leaf.id] = places_[leaf.id] = leaf.localToWorld;
          break;
        }
        case proto::MessageType::Poses: {
          const auto poses = proto::decodePoses(message->payload);
          for (const auto& pose : poses->poses)
            place(pose);
          break;
        }
        case proto::MessageType::Frame: {
          const auto frame = proto::decodeFrame(message->payload);
          take(*frame);
          if (frame->frame == slowFrame_) co_await pause(slowness_);
          master->send(proto::encode(proto::Ready{frame->frame, 1, frame->listLeafCount}));
          break;
        }
        case proto::MessageType::Swap:
          if (proto::decodeSwap(message->payload)->frame == frame_)
            master->send(proto::encode(proto::Shown{.frame = frame_, .shownNs = 1, .picture = {}}));
          break;
        case proto::MessageType::Bye:
          master->send(proto::encode(proto::Bye{.reason = "bye"}));
          over = true;
          break;
        default:
          break;
      }
    }
    master->closeAfterSending();
  }

  void place(const proto::Pose& pose) {
    if (!records_[pose.id]) {
      fault = "a pose of a leaf without a record";
      return;
    }
    places_[pose.id] = pose.form == proto::PoseForm::Steps ? proto::fromSteps(*records_[pose.id], pose.steps)
                                                           : pose.localToWorld;
  }

  void take(const proto::Frame& frame) {
    if (frame.baseFrame == 0) list_.reset();
    if (!list_.decode(frame.toggles)) fault = "a delta is refused";
    frame_ = frame.frame;
    if (frames++ == 0) firstFrame = frame_;
    static const motion::Motion motion = upAndDown();
    forEachLeaf(list_.list(), [&](std::uint32_t leaf) {
      if (!places_[leaf]) {
        fault = "a leaf is listed that was not sent";
        return;
      }
      std::array<double, 4> up{};
      if (leaf % 3 == 0) motion::sample(motion.channels[leaf / 3], static_cast<double>(frame_ - 1) / 60, up);
      const Vec3 expected = Vec3(leaf % kSide, up[1], leaf / kSide);
      if ((places_[leaf]->topRightCorner<3, 1>() - expected).norm() > boundM + 1e-12)
        fault = "frame " + std::to_string(frame_) + ": leaf " + std::to_string(leaf) + " is elsewhere";
      ++checked;
    });
  }

  const std::chrono::milliseconds late_;
  std::uint32_t leafCount_ = 0;
  std::vector<std::optional<Mat4>> records_, places_;
  proto::ListDecoder list_{0};
  std::uint64_t frame_ = 0, slowFrame_ = 0;
  std::chrono::milliseconds slowness_{0};
};

class MotionLoop : public ::testing::Test {
 protected:
  RunReport run(MasterOptions options, std::chrono::milliseconds late, std::uint64_t slowFrame) {
    options.frames = kFrames;
    options.framesPerSecond = 60;
    options.tilesDeadline = std::chrono::milliseconds(300);
    options.frameDeadline = std::chrono::milliseconds(100);
    options.motion.animate = true;
    const auto setups = TileSetups::make(wall_);
    Master master(scene_, wall_, path_, *setups, options);
    const auto port = master.listen({"127.0.0.1", "0"});
    EXPECT_TRUE(port);
    net::asio::io_context io(1);
    for (const Tile& tile : wall_.tiles) {
      tiles_.push_back(std::make_unique<FakeTile>(io, std::to_string(*port), tile.name,
                                                  tiles_.empty() ? late : std::chrono::milliseconds(0)));
      tiles_.back()->boundM = options.motion.quantizeBoundM;
    }
    tiles_.back()->dawdle(slowFrame, std::chrono::milliseconds(300));
    std::thread thread([&io] { io.run(); });
    Master::Hooks hooks;
    hooks.whileWaitingForTiles = [] { return Status(Done{}); };
    auto report = master.run(hooks, true);
    thread.join();
    EXPECT_TRUE(report) << (report ? "" : report.error().text());
    for (const auto& tile : tiles_) {
      EXPECT_EQ(tile->fault, "");
      EXPECT_GT(tile->checked, 500U);
    }
    return report ? *std::move(report) : RunReport();
  }

  Scene scene_ = movingBoxes();
  Wall wall_ = *parseWall(R"({"grid": {"columns": 2, "rows": 2, "tile_px": [64, 48]}})", "test");
  // It sweeps over the boxes, so that leaves come into view all the time.
  CameraPath path_ = *parseCameraPath(R"({"space": "scene", "keyframes": [
      {"time_s": 0, "eye": [-1, 0.5, 0.7], "target": [-0.7, 0, 0]},
      {"time_s": 1, "eye": [1, 0.5, 0.7], "target": [0.7, 0, 0]}]})",
                                      "test");
  std::vector<std::unique_ptr<FakeTile>> tiles_;
};

TEST_F(MotionLoop, TilesKnowWhereEverythingIs) {
  const RunReport report = run({}, std::chrono::milliseconds(0), 0);
  EXPECT_GT(report.poseBytesPerFrame.percentile(50), 0);
}

TEST_F(MotionLoop, ALateTileAndOneThatFellBehindKnowToo) {
  const RunReport report = run({}, std::chrono::milliseconds(800), 20);
  EXPECT_GT(tiles_.front()->firstFrame, 1U);
  EXPECT_LT(tiles_.back()->frames, kFrames);
}

TEST_F(MotionLoop, StepsKeepTheirBoundAndAreSmaller) {
  const double exact = run({}, std::chrono::milliseconds(0), 0).poseBytesPerFrame.percentile(50);
  tiles_.clear();
  MasterOptions options;
  options.motion.quantizeBoundM = 0.002;
  const double steps = run(options, std::chrono::milliseconds(0), 0).poseBytesPerFrame.percentile(50);
  RecordProperty("bytes_exact", static_cast<int>(exact));
  RecordProperty("bytes_steps", static_cast<int>(steps));
  EXPECT_LT(steps, 0.4 * exact);
}

}  // namespace
}  // namespace tessera
