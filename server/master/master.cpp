#include "server/master/master.h"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "common/base/host.h"
#include "proto/codec.h"

namespace tessera {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMaxHandshakes = 256;
// A run without an end reports on its last two minutes at 60 Hz; what else it would keep grows for ever.
constexpr std::size_t kEndlessSamples = 8192;
// Room for more frames than this is taken when they come.
constexpr std::uint64_t kMostReservedFrames = 1 << 20;
// Together they leave a stopped run time to end its processes within two seconds.
constexpr std::chrono::milliseconds kLastSwapDeadline{400}, kGoodbyeDeadline{700};

double msSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

Master::Master(const Scene& scene, const Wall& wall, const CameraPath& path, const TileSetups& setups,
               const MasterOptions& options)
    : scene_(scene),
      wall_(wall),
      path_(path),
      options_(options),
      stereo_(stereoLayout(wall)),
      times_(path.sampleTimes(options.frames > 0 ? options.frames : options.loopFrames)),
      wakeWriters_([this] { roster_.flushAll(); }),
      work_(net::asio::make_work_guard(io_)),
      roster_(wall),
      pictures_(options.pictureFolder
                    ? std::make_unique<PictureWriter>(wall, *options.pictureFolder, options.pictureEvery)
                    : nullptr),
      context_{.wall = wall,
               .leafCount = static_cast<std::uint32_t>(scene.leaves.size()),
               .assets = scene.assets,
               .stream = options_.stream,
               .roster = roster_,
               .setups = setups,
               .inputs = inputs_,
               .pictures = pictures_.get(),
               .deadlines = {},
               .handshakes = 0} {
  trianglesBefore_.push_back(0);
  // Only where they are asked for: the rows of all leaves would come into memory.
  if (options.countTriangles) {
    for (const SceneLeaf& leaf : scene.leaves)
      trianglesBefore_.push_back(trianglesBefore_.back() + leaf.triangles);
  }
  newInputs_.reserve(InputQueue::kCapacity);
  mirrors_.reserve(wall.tiles.size());
  for (std::size_t i = 0; i < wall.tiles.size(); ++i)
    mirrors_.push_back(std::make_unique<TileMirror>(scene, options.stream));
  saidTooSmall_.assign(wall.tiles.size(), false);
}

Master::~Master() {
  stopNetwork();
}

void Master::stopNetwork() {
  io_.stop();
  if (network_.joinable()) network_.join();
}

void Master::stop() {
  roster_.stop();
}

Result<std::uint16_t> Master::listen(const net::HostPort& at) {
  auto acceptor = net::listen(io_, at);
  if (!acceptor) return acceptor.error();
  const std::uint16_t port = acceptor->local_endpoint().port();
  net::asio::co_spawn(io_, acceptTiles(std::move(*acceptor)), net::asio::detached);
  network_ = std::thread([this] { io_.run(); });
  return port;
}

net::awaitable<void> Master::acceptTiles(net::tcp::acceptor acceptor) {
  for (;;) {
    net::error_code ec;
    net::tcp::socket socket =
        co_await acceptor.async_accept(net::asio::redirect_error(net::asio::use_awaitable, ec));
    if (ec) {
      // Out of descriptors, say: existing tiles go on, and the next try may succeed.
      spdlog::warn("a connection could not be accepted: {}", ec.message());
      net::asio::steady_timer pause(io_, std::chrono::milliseconds(100));
      co_await pause.async_wait(net::asio::redirect_error(net::asio::use_awaitable, ec));
      continue;
    }
    if (context_.handshakes >= kMaxHandshakes)
      continue;  // the socket closes: a flood must not starve the tiles
    net::asio::co_spawn(io_, serveTile(std::make_shared<net::Connection>(std::move(socket)), context_),
                        [](const std::exception_ptr& e) {
                          if (e) spdlog::error("a tile's session ended by an exception");
                        });
  }
}

CameraPose Master::poseOf(std::uint64_t frame, const Hooks& hooks) {
  const Sphere& sphere = scene_.sphere();
  CameraPose pose = path_.poseAt(times_[(frame - 1) % times_.size()], sphere.center, sphere.radius);
  if (hooks.pose) hooks.pose(pose);
  if (!pose.hasHead || !wall_.observer) return pose;
  if (!screenNotBefore(wall_, pose.headM)) {
    lastHeadM_ = pose.headM;
    return pose;
  }
  // Somebody leans into a screen: the picture stays as it was before.
  pose.hasHead = lastHeadM_.has_value();
  pose.headM = lastHeadM_.value_or(wall_.observer->eyeM);
  return pose;
}

Status Master::waitForTiles(const Hooks& hooks, bool mayStartWithout) {
  const auto bound = roster_.waitAllBound(Clock::now() + options_.tilesDeadline, [&] {
    takeInputs(hooks);
    return hooks.whileWaitingForTiles();
  });
  if (!bound) return bound.error();
  if (*bound || roster_.stopping()) return Done{};
  std::string names;
  for (const std::string& name : roster_.unboundNames())
    names += (names.empty() ? "" : ", ") + name;
  const std::string what = "these tiles have not connected within the deadline: " + names;
  if (!mayStartWithout) return runtimeError("", what, "see their own messages above");
  spdlog::warn("{}; starting without them", what);
  return Done{};
}

Result<RunReport> Master::run(const Hooks& hooks, bool mayStartWithout) {
  auto motion = SceneMotion::make(scene_, options_.motion);
  if (!motion) return motion.error();
  motion_ = std::move(*motion);
  if (Status status = waitForTiles(hooks, mayStartWithout); !status) {
    sayGoodbye();
    stopNetwork();
    return status.error();
  }
  reserveReport();
  WallCuller culler(motion_ ? motion_->hierarchy() : scene_.hierarchy, wall_, options_.cull,
                    options_.planeSource);
  if (options_.stream.predictFrames > 0)
    predictor_.emplace(motion_ ? motion_->hierarchy() : scene_.hierarchy, wall_,
                       PredictorOptions{.horizonFrames = options_.stream.predictFrames});
  const Sphere& sphere = scene_.sphere();
  firstFrame_ = lastPaced_ = lastSwap_ = Clock::now();
  std::uint64_t frame = 0;
  WallView view;
  for (std::uint64_t next = 1; (options_.frames == 0 || next <= options_.frames) && !roster_.stopping();
       ++next) {
    pace(next);
    const std::int64_t startCpuNs = threadCpuNs();
    takeInputs(hooks);
    if (roster_.stopping()) break;
    auto start = Clock::now();
    const CameraPose pose = poseOf(next, hooks);
    if (motion_) {
      motion_->advance(next, wall_, pose, view);
    } else {
      viewInto(wall_, pose, sphere.center, sphere.radius, view);
    }
    culler.update(view);
    if (predictor_) predicted_ = &predictor_->predict(pose, sphere);
    report_.updateMs.add(msSince(start));
    start = Clock::now();
    const cull::Changes& changes = culler.cullChanges();
    report_.cullMs.add(msSince(start));
    if (frame > 0) endFrame(frame);
    frame = next;
    sendFrame(frame, view, culler, changes);
    report_.masterMs.add(static_cast<double>(threadCpuNs() - startCpuNs) / 1e6);
    if (options_.countTriangles) report_.trianglesPerFrame.add(static_cast<double>(countTriangles(culler)));
    if (hooks.eachFrame) hooks.eachFrame();
    if (hooks.progress) hooks.progress(frame, options_.frames);
  }
  report_.picked = cull::nameOf(culler.picked());
  if (frame > 0) endFrame(frame);
  report_.frames = frame;
  report_.seconds = msSince(firstFrame_) / 1000 - report_.firstFrameMs / 1000;
  if (frame > 0) {
    roster_.waitShown(frame,
                      Clock::now() + (roster_.stopping() ? kLastSwapDeadline : options_.frameDeadline));
  }
  sayGoodbye();
  stopNetwork();
  if (pictures_) {
    if (Status status = pictures_->finish(); !status) return status.error();
  }
  fillReport();
  return std::move(report_);
}

void Master::takeInputs(const Hooks& hooks) {
  inputs_.drainInto(newInputs_);
  for (const TileInput& one : newInputs_) {
    if (hooks.input) hooks.input(one.tile, one.input);
    if (one.input.kind != proto::InputKind::Quit) continue;
    spdlog::info("tile {} was asked to end the wall", roster_.nameOf(one.tile));
    stop();
  }
}

void Master::pace(std::uint64_t frame) {
  if (options_.framesPerSecond <= 0 || frame == 1) return;
  const auto period = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(1 / options_.framesPerSecond));
  // A wall that fell behind does not hurry to catch up.
  lastPaced_ = std::max(lastPaced_ + period, Clock::now() - period);
  std::this_thread::sleep_until(lastPaced_);
}

void Master::reserveReport() {
  report_.tiles.resize(wall_.tiles.size());
  if (options_.frames > 0) return report_.expect(std::min(options_.frames, kMostReservedFrames));
  report_.keepLast(kEndlessSamples);
  roster_.keepLast(kEndlessSamples);
}

void Master::sendFrame(std::uint64_t frame, const WallView& view, const WallCuller& culler,
                       const cull::Changes& changes) {
  std::uint64_t listBytes = 0, geometryBytes = 0, poseBytes = 0;
  const auto start = Clock::now();
  // Who is ready for this frame has shown the one before the last.
  if (display_.overlay && frame > 2) skewUs_ = roster_.skewUs(frame - 2);
  roster_.startFrame(frame, peers_);
  for (std::uint32_t tile = 0; tile < roster_.tileCount(); ++tile) {
    if (!peers_[tile].connection) continue;
    const TileMirror::Sent sent = sendTo(tile, peers_[tile], frame, view, culler, changes);
    listBytes += sent.listBytes;
    geometryBytes += sent.assetBytes;
    poseBytes += sent.poseBytes;
    RunReport::TileEntry& entry = report_.tiles[tile];
    entry.visibleLeaves.add(changes.leafCounts[tile]);
    entry.cacheHits += sent.hits;
    entry.cacheMisses += sent.misses;
    entry.cacheEvictions += sent.evictions;
    entry.diskHits += sent.diskHits;
    entry.predictedBytes += sent.predictedBytes;
    noteCache(tile, sent);
  }
  report_.encodeMs.add(msSince(start));
  const auto sendStart = Clock::now();
  wakeWriters_.post(io_);
  report_.sendMs.add(msSince(sendStart));
  report_.listBytesPerFrame.add(static_cast<double>(listBytes));
  report_.poseBytesPerFrame.add(static_cast<double>(poseBytes));
  report_.geometryBytesPerFrame.add(static_cast<double>(geometryBytes));
  report_.visibleLeavesPerFrame.add(static_cast<double>(changes.pairs));
}

TileMirror::Sent Master::sendTo(std::uint32_t tile, const TileRoster::Peer& peer, std::uint64_t frame,
                                const WallView& view, const WallCuller& culler,
                                const cull::Changes& changes) {
  TileMirror& mirror = *mirrors_[tile];
  mirror.follow(peer.session, *peer.facts);
  mirror.resend(peer.lacked);
  mirror.acknowledge(peer.acknowledged);
  TileMirror::FrameOrder order{.frame = frame,
                               .frustum = drawnFrustum(wall_.tiles[tile], eyeOf(tile, view)),
                               .axes = drawnAxes(wall_.tiles[tile], view.axes[wall_.tiles[tile].screen]),
                               .toggled = &changes.toggled[tile],
                               .baseFrame = frame - 1,
                               .leafCount = changes.leafCounts[tile],
                               .predicted = predicted_ ? &(*predicted_)[tile] : nullptr,
                               .wantPicture = pictures_ && pictures_->wants(frame),
                               .stereo = stereo_,
                               .motion = motion_.get(),
                               .display = display_,
                               .skewUs = display_.overlay && frame > 1 ? skewUs_ : 0};
  if (stereo_ != proto::StereoLayout::None) {
    const Frustum right = drawnFrustum(wall_.tiles[tile], view.right[tile]);
    order.rightEye = proto::RightEye{right.eye, right.corners};
  }
  if (!mirror.keepsUpWith(frame)) {
    culler.listOf(tile, wholeList_);
    order.toggled = &wholeList_;
    order.baseFrame = 0;
  }
  return mirror.send(*peer.connection, encoder_, order);
}

void Master::noteCache(std::uint32_t tile, const TileMirror::Sent& sent) {
  if (!sent.isCacheTooSmall || saidTooSmall_[tile]) return;
  saidTooSmall_[tile] = true;
  spdlog::warn(
      "the cache of tile {} ({} MB) holds less than one frame needs: {} leaves are left out; give it "
      "more with --cache",
      roster_.nameOf(tile), peers_[tile].facts->cacheBytes >> 20, sent.incomplete);
}

std::uint64_t Master::countTriangles(const WallCuller& culler) {
  std::uint64_t triangles = 0;
  for (std::uint32_t tile = 0; tile < roster_.tileCount(); ++tile) {
    culler.listOf(tile, wholeList_);
    for (const LeafRange range : wholeList_)
      triangles += trianglesBefore_[range.last] - trianglesBefore_[range.first];
  }
  return triangles;
}

/// The frustum that the tile draws, or draws first.
const Frustum& Master::eyeOf(std::uint32_t tile, const WallView& view) const {
  if (view.left.empty()) return view.tiles[tile];
  return wall_.tiles[tile].eye == TileEye::Right ? view.right[tile] : view.left[tile];
}

void Master::endFrame(std::uint64_t frame) {
  const auto start = Clock::now();
  for (const std::uint32_t tile : roster_.waitReady(frame, start + options_.frameDeadline)) {
    if (roster_.stopping()) break;
    spdlog::warn("tile {} has not drawn frame {} within {} ms and is left behind until it has",
                 roster_.nameOf(tile), frame, options_.frameDeadline.count());
    roster_.frameMissed(tile);
  }
  report_.tileWaitMs.add(msSince(start));
  if (frame == 1) report_.firstFrameMs = msSince(firstFrame_);
  const auto swapStart = Clock::now();
  broadcastSwap(frame);
  report_.swapMs.add(msSince(swapStart));
  report_.frameMs.add(msSince(lastSwap_));
  lastSwap_ = Clock::now();
  // All that acknowledged this frame had shown the one before.
  if (pictures_ && frame > 1) pictures_->complete(frame - 1);
}

void Master::broadcastSwap(std::uint64_t frame) {
  const std::span<const std::byte> message = encoder_.encode(proto::Swap{frame});
  for (const TileRoster::Peer& peer : peers_) {
    if (peer.connection) peer.connection->queue(message);
  }
  wakeWriters_.post(io_);
}

void Master::sayGoodbye() {
  const proto::Bytes bytes =
      proto::encode(proto::Bye{.reason = "the run is over", .peakResidentBytes = 0, .framesShown = 0});
  for (std::uint32_t tile = 0; tile < roster_.tileCount(); ++tile) {
    if (const auto peer = roster_.peer(tile).connection) peer->send(std::span<const std::byte>(bytes));
  }
  roster_.waitEmpty(Clock::now() + kGoodbyeDeadline);
}

void Master::fillReport() {
  report_.scene = scene_.source;
  report_.motion = options_.motion;
  report_.wall = wall_.source;
  report_.algorithm = cull::nameOf(options_.cull.algorithm);
  report_.bounds = cull::nameOf(options_.cull.bounds);
  report_.leaves = scene_.leaves.size();
  report_.triangles = scene_.triangleCount();
  report_.assets = scene_.assets.size();
  report_.assetBytes = scene_.assets.bytes();
  std::vector<std::vector<ShownTime>> shown;
  for (std::uint32_t tile = 0; tile < roster_.tileCount(); ++tile) {
    RunReport::TileEntry& entry = report_.tiles[tile];
    entry.name = roster_.nameOf(tile);
    entry.counts = roster_.counts(tile);
    entry.listBytes = mirrors_[tile]->traffic().listBytes;
    entry.geometryBytes = mirrors_[tile]->traffic().geometryBytes;
    shown.push_back(roster_.shownTimes(tile));
  }
  report_.framesIncomplete = roster_.framesIncomplete();
  report_.stream = options_.stream;
  addSwapSkew(report_, shown);
  if (pictures_) {
    report_.pictures = pictures_->written();
    report_.incompletePictures = pictures_->incomplete();
  }
}

}  // namespace tessera
