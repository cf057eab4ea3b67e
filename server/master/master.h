#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "common/base/result.h"
#include "common/cull/options.h"
#include "common/hierarchy/tile_cone.h"
#include "common/net/connection.h"
#include "common/net/one_post.h"
#include "common/scene/scene.h"
#include "common/wall/camera_path.h"
#include "common/wall/wall.h"
#include "proto/codec.h"
#include "server/master/input_queue.h"
#include "server/master/picture_writer.h"
#include "server/master/predictor.h"
#include "server/master/run_report.h"
#include "server/master/scene_motion.h"
#include "server/master/tile_mirror.h"
#include "server/master/tile_roster.h"
#include "server/master/tile_session.h"
#include "server/master/wall_culler.h"

namespace tessera {

struct MasterOptions {
  cull::Options cull;
  PlaneSource planeSource = PlaneSource::Corners;
  std::uint64_t frames = 0;        ///< along the camera path; 0: over and over until stopped
  std::uint64_t loopFrames = 600;  ///< frames of one pass of the path when it runs over and over
  double framesPerSecond = 0;      ///< 0: as fast as the tiles are
  std::chrono::milliseconds tilesDeadline{30'000};  ///< for all tiles to connect
  std::chrono::milliseconds frameDeadline{
      10'000};  ///< for a frame's Ready; a tile that misses it is left behind
  std::optional<std::filesystem::path> pictureFolder;  ///< stitched pictures go there
  std::uint64_t pictureEvery = 1;                      ///< of the frames, every so-manieth
  MotionOptions motion;
  StreamOptions stream;
  bool countTriangles = false;  ///< for RunReport::frameLog; each frame's whole lists must be made for it
};

/// The master of one wall: listens for tiles and runs the frame loop.
///
///   update -> cull(k) -> wait for Ready(k-1) of all tiles -> Swap(k-1) -> encode and send frame k
///
/// so that culling overlaps the tiles' drawing. One thread runs the loop (the caller of run), one the
/// network; pictures are written by a third. A tile that is late or gone is not waited for again until it is
/// back. The loop's thread does not allocate in a frame in which no tile gets new geometry, once buffers have
/// grown to what the path needs.
class Master {
 public:
  /// `scene`, `wall`, `path` and `setups` (of the wall) outlive the master.
  Master(const Scene& scene, const Wall& wall, const CameraPath& path, const TileSetups& setups,
         const MasterOptions& options);
  ~Master();
  Master(const Master&) = delete;
  Master& operator=(const Master&) = delete;

  /// Opens the port and starts the network thread. Returns the port (of use where 0 was asked for).
  [[nodiscard]] Result<std::uint16_t> listen(const net::HostPort& at);

  struct Hooks {
    std::function<Status()> whileWaitingForTiles;  ///< called often; an error ends the run
    std::function<void()> eachFrame;               ///< called once a frame
    std::function<void(std::uint64_t done, std::uint64_t all)> progress;
    /// What a person did at the window of a tile (its index), on the thread of run(), before the frame's pose
    /// is asked for. Quit, which ends the run in order, is told of, too.
    std::function<void(std::uint32_t tile, const proto::Input& input)> input = {};
    /// Changes the pose that the path has for a frame: who steers by hand, or tracks a head.
    std::function<void(CameraPose& pose)> pose = {};
  };
  /// Runs until the frames are done or stop() was called. `mayStartWithout`: where tiles are missing at the
  /// deadline, start all the same (they may join later); else that is an error that names them.
  [[nodiscard]] Result<RunReport> run(const Hooks& hooks, bool mayStartWithout);

  /// From the thread of run() (a hook) or before it: what tiles show from the next frame on.
  void show(const Display& display) { display_ = display; }
  [[nodiscard]] const Display& display() const { return display_; }

  /// From any thread, also before run: ends it in order.
  void stop();

  [[nodiscard]] net::asio::io_context& io() { return io_; }

 private:
  [[nodiscard]] CameraPose poseOf(std::uint64_t frame, const Hooks& hooks);
  net::awaitable<void> acceptTiles(net::tcp::acceptor acceptor);
  [[nodiscard]] Status waitForTiles(const Hooks& hooks, bool mayStartWithout);
  void takeInputs(const Hooks& hooks);
  void reserveReport();
  void sendFrame(std::uint64_t frame, const WallView& view, const WallCuller& culler,
                 const cull::Changes& changes);
  [[nodiscard]] TileMirror::Sent sendTo(std::uint32_t tile, const TileRoster::Peer& peer, std::uint64_t frame,
                                        const WallView& view, const WallCuller& culler,
                                        const cull::Changes& changes);
  [[nodiscard]] const Frustum& eyeOf(std::uint32_t tile, const WallView& view) const;
  [[nodiscard]] std::uint64_t countTriangles(const WallCuller& culler);
  void noteCache(std::uint32_t tile, const TileMirror::Sent& sent);
  void endFrame(std::uint64_t frame);
  void pace(std::uint64_t frame);
  void broadcastSwap(std::uint64_t frame);
  void sayGoodbye();
  void stopNetwork();
  void fillReport();

  const Scene& scene_;
  const Wall& wall_;
  const CameraPath& path_;
  const MasterOptions options_;
  const proto::StereoLayout stereo_;
  Display display_;
  std::uint32_t skewUs_ = 0;
  std::optional<Vec3> lastHeadM_;  ///< the last one before all screens
  std::vector<double> times_;
  net::OnePost wakeWriters_;
  net::asio::io_context io_{1};
  net::asio::executor_work_guard<net::asio::io_context::executor_type> work_;
  TileRoster roster_;
  InputQueue inputs_;
  std::unique_ptr<PictureWriter> pictures_;
  SessionContext context_;
  std::unique_ptr<SceneMotion> motion_;  ///< while it runs; null: nothing moves
  std::vector<std::unique_ptr<TileMirror>> mirrors_;
  std::optional<Predictor> predictor_;
  const std::vector<VisibleList>* predicted_ = nullptr;  ///< by tile, of this frame; null: nothing is
  std::vector<bool> saidTooSmall_;                       ///< by tile: that its cache is
  std::vector<TileInput> newInputs_;
  proto::Encoder encoder_;
  VisibleList wholeList_;
  std::vector<TileRoster::Peer> peers_;  ///< who was sent the last frame
  RunReport report_;
  std::vector<std::uint64_t> trianglesBefore_;  ///< by leaf; one more than leaves
  std::chrono::steady_clock::time_point firstFrame_, lastPaced_, lastSwap_;
  std::thread network_;
};

}  // namespace tessera
