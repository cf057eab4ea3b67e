#include "client/tile_client.h"

#include <algorithm>
#include <memory>
#include <optional>

#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/leaf_box.h"
#include "client/tile_cache.h"
#include "client/tile_view.h"
#include "common/base/host.h"
#include "proto/codec.h"
#include "proto/list_coder.h"

namespace tessera {

namespace {

using net::awaitable;

constexpr net::Milliseconds kHandshakeDeadline{10'000};
constexpr net::Milliseconds kWriteDeadline{10'000};
constexpr std::size_t kMostHave = 1 << 22;                // a master takes no more
constexpr std::chrono::microseconds kPollPeriod{16'667};  // 60 Hz

/// One conversation with the master, from Welcome to the end.
class TileConversation {
 public:
  /// `surfaces` is null where nothing is drawn.
  TileConversation(net::asio::io_context& io, std::shared_ptr<net::Connection> master, proto::Welcome welcome,
                   const TileOptions& options)
      : master_(std::move(master)),
        welcome_(std::move(welcome)),
        surfaces_(options.surfaces),
        nextPoll_(io),
        cache_({.decodes = options.surfaces != nullptr,
                .budgetBytes = options.cacheBytes > 0 ? options.cacheBytes : LeafCache::kNoBudget,
                .disk = options.disk}) {
    cache_.setUploadMs(welcome_.uploadMs);
  }

  Status openSurface() {
    if (!surfaces_) return Done{};
    const PixelSize picture{welcome_.widthPx, welcome_.heightPx};
    const int maxSidePx = surfaces_->maxSidePx();
    if (maxSidePx > 0 && (picture.widthPx > maxSidePx || picture.heightPx > maxSidePx)) {
      return runtimeError("tile " + welcome_.tileName,
                          "is larger than the " + std::to_string(maxSidePx) + " pixels that can be drawn",
                          "cut the wall into smaller tiles");
    }
    auto surface = surfaces_->make({.tileName = welcome_.tileName, .picture = picture});
    if (!surface) return surface.error();
    surface_ = std::move(*surface);
    if (Status status = surface_->makeCurrent(); !status) return status;
    view_.emplace(welcome_, surface_->drawnSize());
    return Done{};
  }

  [[nodiscard]] const std::shared_ptr<net::Connection>& master() const { return master_; }

  awaitable<Status> run() {
    const net::Milliseconds idle{welcome_.idleTimeoutMs};
    while (!over_) {
      auto message = co_await master_->read(proto::Expect::FromMaster, idle);
      if (!message) co_return message.error();
      bytesReceived_ += proto::kHeaderBytes + message->payload.size();
      auto decoded = proto::decode(message->type, message->payload);
      Status status = decoded ? std::visit([this](const auto& m) { return handle(m); }, *decoded)
                              : Status(decoded.error());
      if (!status) {
        master_->send(
            proto::encode(proto::ErrorMessage{proto::ErrorCode::ProtocolViolation, status.error().text()}));
        co_return status;
      }
    }
    co_return Done{};
  }

  [[nodiscard]] bool hasWindow() const { return surface_ && surface_->hasEvents(); }

  /// Answers the window system and tells the master what was done at the window, until stopWatching().
  awaitable<void> watchWindow() {
    std::vector<proto::Input> inputs;
    while (!stopped_) {
      inputs.clear();
      surface_->poll(inputs);
      for (const proto::Input& input : inputs)
        master_->send(proto::encode(input));
      nextPoll_.expires_after(kPollPeriod);
      net::error_code ec;
      co_await nextPoll_.async_wait(net::asio::redirect_error(net::asio::use_awaitable, ec));
    }
  }

  void stopWatching() {
    stopped_ = true;
    nextPoll_.cancel();
  }

 private:
  static std::string nameOf(const proto::Frame& frame) { return "frame " + std::to_string(frame.frame); }

  Status handle(const proto::Assets& message) {
    if (Status status = cache_.add(message); !status) return status;
    sayWhatIsLacked();
    return Done{};
  }
  Status handle(const proto::Keep& message) { return cache_.keep(message, welcome_.leafCount); }
  Status handle(const proto::Leaves& message) { return cache_.add(message, welcome_.leafCount); }

  Status handle(const proto::Poses& message) { return cache_.add(message); }

  Status handle(const proto::TileSetup& setup) {
    if (hasSetup_ || frame_ != 0)
      return runtimeError("TileSetup", hasSetup_ ? "comes a second time" : "comes after a frame");
    hasSetup_ = true;
    return view_ ? view_->configure(setup) : Done{};
  }

  Status handle(const proto::Frame& frame) {
    if (frame.frame <= frame_)
      return runtimeError(nameOf(frame), "comes after frame " + std::to_string(frame_));
    // The list of the last frame is the only one that was acknowledged last.
    if (frame.baseFrame != 0 && frame.baseFrame != frame_)
      return runtimeError(nameOf(frame), "builds on a list that is not here");
    const bool isWhole = frame.baseFrame == 0;
    if (isWhole) {
      listBefore_ = list_.list();
      list_.reset();
    }
    if (Status status = list_.decode(frame.toggles); !status) return status;
    if (leafCount(list_.list()) != frame.listLeafCount)
      return runtimeError(nameOf(frame), "has a list of the wrong length");
    // What was listed before has a record.
    if (isWhole) symmetricDifferenceInto(listBefore_, list_.list(), changed_);
    const VisibleList& changed = isWhole ? changed_ : list_.toggled();
    for (const LeafRange range : changed) {
      for (std::uint32_t leaf = range.first; leaf != range.last; ++leaf) {
        if (!cache_.has(leaf))
          return runtimeError(nameOf(frame), "lists leaf " + std::to_string(leaf) + ", which was not sent");
        noteMissing(leaf);
      }
    }
    frame_ = frame.frame;
    wantPicture_ = frame.wantPicture;
    const std::int64_t start = monotonicNs();
    if (Status status = cache_.prepare(); !status) return status;
    const std::size_t missed = missing_.size();
    std::erase_if(missing_, [this](std::uint32_t leaf) { return cache_.isComplete(leaf); });
    const bool hasNewList = isWhole || !frame.toggles.empty() || missing_.size() != missed;
    cache_.show(changed);
    if (view_) {
      if (hasNewList) view_->setList(list_.list(), cache_, welcome_.onMiss == proto::OnMiss::Box);
      if (Status status = view_->draw(frame, factsOf(frame)); !status) return status;
      surface_->finish();
    }
    const auto drawUs = static_cast<std::uint32_t>((monotonicNs() - start) / 1000);
    isReady_ = true;
    master_->send(proto::encode(proto::Ready{.frame = frame.frame,
                                             .drawUs = drawUs,
                                             .leafCount = frame.listLeafCount,
                                             .missingLeaves = static_cast<std::uint32_t>(missing_.size()),
                                             .missingPx = missingPixels(frame)}));
    return Done{};
  }

  /// Leaf is in the list now, or not any more.
  void noteMissing(std::uint32_t leaf) {
    if (cache_.isComplete(leaf)) return;
    if (containsLeaf(list_.list(), leaf)) {
      missing_.push_back(leaf);
    } else {
      std::erase(missing_, leaf);
    }
  }

  [[nodiscard]] std::uint64_t missingPixels(const proto::Frame& frame) {
    std::uint64_t px = 0;
    for (const std::uint32_t leaf : missing_)
      px += pixelsOf(*cache_.find(leaf), frame, welcome_.widthPx, welcome_.heightPx);
    return std::min(
        px, static_cast<std::uint64_t>(welcome_.widthPx) * static_cast<std::uint64_t>(welcome_.heightPx));
  }

  void sayWhatIsLacked() {
    const std::vector<proto::Sha256> ids = cache_.takeLacked();
    for (std::size_t first = 0; first < ids.size(); first += proto::kMaxLacks) {
      const std::size_t count = std::min(proto::kMaxLacks, ids.size() - first);
      const auto begin = ids.begin() + static_cast<std::ptrdiff_t>(first);
      master_->send(proto::encode(proto::Lacks{{begin, begin + static_cast<std::ptrdiff_t>(count)}}));
    }
  }

  [[nodiscard]] OverlayFacts factsOf(const proto::Frame& frame) const {
    if (!frame.overlay) return {};
    return {.tileName = welcome_.tileName,
            .framesPerS = rate_.framesPerS(),
            .drawnLeaves = frame.listLeafCount,
            .bytesReceived = bytesReceived_,
            .keptLeaves = cache_.leafCount(),
            .keptAssets = cache_.assetCount(),
            .skewUs = frame.skewUs};
  }

  Status handle(const proto::Swap& swap) {
    if (!isReady_ || swap.frame != frame_) return Done{};  // of a frame that we never had
    isReady_ = false;
    ++framesShown_;
    proto::Shown shown{.frame = frame_, .shownNs = 0, .picture = std::nullopt};
    std::vector<std::uint8_t> rgb;
    const bool sendsPicture = wantPicture_ && surface_ && welcome_.picture == proto::PictureFormat::RawRgb8;
    // Once presented, the picture of a window is the window system's.
    if (sendsPicture) rgb = surface_->readPicture();
    if (surface_) surface_->present();
    shown.shownNs = monotonicNs();
    rate_.shown(shown.shownNs);
    if (sendsPicture) {
      rgb = resampled(std::move(rgb), surface_->drawnSize(), {welcome_.widthPx, welcome_.heightPx});
      shown.picture = proto::Picture{welcome_.widthPx, welcome_.heightPx, proto::PictureFormat::RawRgb8,
                                     std::as_bytes(std::span(rgb))};
    }
    master_->send(proto::encode(shown));
    return Done{};
  }

  Status handle(const proto::Ping& ping) {
    master_->send(proto::encode(proto::Pong{ping.nonce}));
    return Done{};
  }

  Status handle(const proto::Bye&) {
    master_->send(proto::encode(
        proto::Bye{.reason = "bye", .peakResidentBytes = peakResidentBytes(), .framesShown = framesShown_}));
    over_ = true;
    return Done{};
  }

  Status handle(const proto::ErrorMessage& error) {
    return runtimeError("master " + master_->peer(), error.text);
  }

  // The connection lets no other type through.
  template <class Other>
  Status handle(const Other&) {
    return runtimeError("master " + master_->peer(), "says what only tiles say");
  }

  std::shared_ptr<net::Connection> master_;
  const proto::Welcome welcome_;
  SurfaceMaker* const surfaces_;
  std::unique_ptr<Surface> surface_;
  net::asio::steady_timer nextPoll_;
  bool stopped_ = false;
  TileCache cache_;
  std::optional<TileView> view_;
  proto::ListDecoder list_{welcome_.leafCount};
  VisibleList listBefore_, changed_;    ///< of frames that bring the whole list
  std::vector<std::uint32_t> missing_;  ///< in the list and not complete
  FrameRate rate_;
  std::uint64_t frame_ = 0, framesShown_ = 0, bytesReceived_ = 0;
  bool hasSetup_ = false;
  bool isReady_ = false, wantPicture_ = false, over_ = false;
};

/// The tiles of one process.
class TileGroup {
 public:
  explicit TileGroup(const TileOptions& options) : options_(options) {}

  Status run() {
    spawn(joinAll());
    // Ends when all conversations are over and everything queued has been written.
    io_.run();
    return outcome_;
  }

 private:
  /// One after the other: the tiles of a large wall shall not all come upon the master at once.
  awaitable<void> joinAll() {
    for (const std::string& name : options_.tileNames) {
      auto connected = co_await net::connect(options_.master, options_.connectDeadline);
      if (!connected) co_return fail(connected.error());
      if (!outcome_) co_return (*connected)->close();
      connections_.push_back(*connected);
      auto tile = co_await join(*connected, name);
      if (!tile) co_return fail(tile.error());
      if ((*tile)->hasWindow()) spawn(watch(*tile));
      spawn(converse(std::move(*tile)));
    }
  }

  [[nodiscard]] std::vector<proto::Sha256> whatTheDiskHas() const {
    std::vector<proto::Sha256> ids;
    if (!options_.disk) return ids;
    for (const DiskStore::Content& content : options_.disk->contents()) {
      if (ids.size() == kMostHave) break;
      ids.push_back(content.id.bytes);
    }
    return ids;
  }

  awaitable<Result<std::shared_ptr<TileConversation>>> join(std::shared_ptr<net::Connection> master,
                                                            std::string name) {
    master->startWriter(kWriteDeadline);
    proto::Hello hello;
    hello.tileName = name;
    hello.programVersion = TESSERA_VERSION;
    hello.clockId = hostClockId();
    hello.surface = options_.surface;
    hello.pid = static_cast<std::uint32_t>(::getpid());
    if (options_.surfaces)
      hello.maxWidthPx = hello.maxHeightPx = static_cast<std::uint32_t>(options_.surfaces->maxSidePx());
    hello.cacheBytes = options_.cacheBytes;
    const std::vector<proto::Sha256> have = whatTheDiskHas();
    hello.haveCount = static_cast<std::uint32_t>(have.size());
    master->send(proto::encode(hello));
    for (std::size_t first = 0; first < have.size(); first += proto::kMaxAssetsPerMessage) {
      const auto begin = have.begin() + static_cast<std::ptrdiff_t>(first);
      const std::size_t count = std::min(proto::kMaxAssetsPerMessage, have.size() - first);
      master->send(proto::encode(proto::Have{{begin, begin + static_cast<std::ptrdiff_t>(count)}}));
    }
    auto reply = co_await master->read(proto::Expect::WelcomeOrError, kHandshakeDeadline);
    if (!reply) co_return reply.error();
    if (reply->type == proto::MessageType::Error) {
      const auto error = proto::decodeError(reply->payload);
      co_return runtimeError("master " + master->peer(), error ? error->text : error.error().what);
    }
    auto welcome = proto::decodeWelcome(reply->payload);
    if (!welcome) co_return welcome.error();
    auto tile = std::make_shared<TileConversation>(io_, master, std::move(*welcome), options_);
    if (Status status = tile->openSurface(); !status) {
      master->send(proto::encode(proto::ErrorMessage{proto::ErrorCode::Internal, status.error().text()}));
      co_return status.error();
    }
    co_return tile;
  }

  awaitable<void> watch(std::shared_ptr<TileConversation> tile) { co_await tile->watchWindow(); }

  awaitable<void> converse(std::shared_ptr<TileConversation> tile) {
    const Status status = co_await tile->run();
    tile->stopWatching();
    if (!status) co_return fail(status.error());
    tile->master()->closeAfterSending();
  }

  void spawn(awaitable<void> work) {
    net::asio::co_spawn(io_, std::move(work), [this](const std::exception_ptr& exception) {
      if (!exception) return;
      try {
        std::rethrow_exception(exception);
      } catch (const std::exception& e) {
        fail(runtimeError("", e.what()));
      }
    });
  }

  /// Ends all connections, after what is queued; the first error is the one that is told.
  void fail(const Error& error) {
    if (!outcome_) return;
    outcome_ = error;
    for (const auto& connection : connections_)
      connection->closeAfterSending();
  }

  const TileOptions& options_;
  Status outcome_ = Done{};
  net::asio::io_context io_{1};
  std::vector<std::shared_ptr<net::Connection>> connections_;
};

}  // namespace

Status runTiles(const TileOptions& options) {
  Status status = TileGroup(options).run();
  if (!options.disk) return status;
  // What the disk cannot take now is sent again next time.
  if (const Status published = options.disk->publish(); !published)
    spdlog::warn("{}", published.error().text());
  options.disk->evict();
  return status;
}

}  // namespace tessera
