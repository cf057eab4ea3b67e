#include "client/tile_client.h"

#include <optional>

#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/offscreen_surface.h"
#include "client/tile_cache.h"
#include "client/tile_view.h"
#include "common/base/host.h"
#include "proto/codec.h"
#include "proto/list_codec.h"

namespace tessera {

namespace {

using net::awaitable;

constexpr net::Milliseconds kHandshakeDeadline{10'000};
constexpr net::Milliseconds kWriteDeadline{10'000};

/// One conversation with the master, from Welcome to the end.
class TileConversation {
 public:
  TileConversation(std::shared_ptr<net::Connection> master, proto::Welcome welcome, proto::SurfaceKind kind)
      : master_(std::move(master)),
        welcome_(std::move(welcome)),
        kind_(kind),
        cache_(kind != proto::SurfaceKind::None) {}

  Status openSurface() {
    if (kind_ == proto::SurfaceKind::None) return Done{};
    if (welcome_.widthPx > maxOffscreenSidePx() || welcome_.heightPx > maxOffscreenSidePx()) {
      return runtimeError("tile " + welcome_.tileName,
                          "is larger than OSMesa's " + std::to_string(maxOffscreenSidePx()) + " pixels",
                          "cut the wall into smaller tiles");
    }
    auto surface = makeOffscreenSurface(welcome_.widthPx, welcome_.heightPx);
    if (!surface) return surface.error();
    surface_ = std::move(*surface);
    if (Status status = surface_->makeCurrent(); !status) return status;
    view_.emplace(welcome_);
    return Done{};
  }

  awaitable<Status> run() {
    const net::Milliseconds idle{welcome_.idleTimeoutMs};
    while (!over_) {
      auto message = co_await master_->read(proto::Expect::FromMaster, idle);
      if (!message) co_return message.error();
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

 private:
  Status handle(const proto::Assets& message) { return cache_.add(message); }
  Status handle(const proto::Leaves& message) { return cache_.add(message, welcome_.leafCount); }

  Status handle(const proto::Frame& frame) {
    const std::string name = "frame " + std::to_string(frame.frame);
    if (frame.frame <= frame_) return runtimeError(name, "comes after frame " + std::to_string(frame_));
    // The list of the last frame is the only one that was acknowledged last.
    if (frame.baseFrame != 0 && frame.baseFrame != frame_)
      return runtimeError(name, "builds on a list that is not here");
    if (frame.baseFrame == 0) list_.clear();
    if (Status status = proto::applyListDeltaInto(list_, frame.toggles, welcome_.leafCount, nextList_);
        !status) {
      return status;
    }
    std::swap(list_, nextList_);
    if (leafCount(list_) != frame.listLeafCount) return runtimeError(name, "has a list of the wrong length");
    for (const LeafRange range : list_) {
      for (std::uint32_t leaf = range.first; leaf != range.last; ++leaf) {
        if (!cache_.has(leaf))
          return runtimeError(name, "lists leaf " + std::to_string(leaf) + ", which was not sent");
      }
    }
    frame_ = frame.frame;
    wantPicture_ = frame.wantPicture;
    const std::int64_t start = monotonicNs();
    if (view_) {
      if (frame.toggles.size() > 1) view_->setList(list_, cache_);
      view_->draw(frame);
      surface_->present();
    }
    const auto drawUs = static_cast<std::uint32_t>((monotonicNs() - start) / 1000);
    isReady_ = true;
    master_->send(proto::encode(proto::Ready{frame.frame, drawUs, frame.listLeafCount}));
    return Done{};
  }

  Status handle(const proto::Swap& swap) {
    if (!isReady_ || swap.frame != frame_) return Done{};  // of a frame that we never had
    isReady_ = false;
    ++framesShown_;
    proto::Shown shown{.frame = frame_, .shownNs = monotonicNs(), .picture = std::nullopt};
    std::vector<std::uint8_t> rgb;
    if (wantPicture_ && surface_ && welcome_.picture == proto::PictureFormat::RawRgb8) {
      rgb = surface_->readPicture();
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
  const proto::SurfaceKind kind_;
  std::unique_ptr<Surface> surface_;
  TileCache cache_;
  std::optional<TileView> view_;
  VisibleList list_, nextList_;
  std::uint64_t frame_ = 0, framesShown_ = 0;
  bool isReady_ = false, wantPicture_ = false, over_ = false;
};

/// Ends the connection, after what is queued, however the conversation ends: the io context runs until then.
struct Closer {
  std::shared_ptr<net::Connection> connection;
  ~Closer() { connection->closeAfterSending(); }
};

awaitable<Status> converse(const TileOptions& options) {
  auto connected = co_await net::connect(options.master, options.connectDeadline);
  if (!connected) co_return connected.error();
  const std::shared_ptr<net::Connection> master = *connected;
  const Closer closer{master};
  master->startWriter(kWriteDeadline);
  proto::Hello hello;
  hello.tileName = options.tileName;
  hello.programVersion = TESSERA_VERSION;
  hello.clockId = hostClockId();
  hello.surface = options.surface;
  hello.pid = static_cast<std::uint32_t>(::getpid());
  if (options.surface == proto::SurfaceKind::Offscreen) {
    hello.maxWidthPx = hello.maxHeightPx = static_cast<std::uint32_t>(maxOffscreenSidePx());
  }
  master->send(proto::encode(hello));
  auto reply = co_await master->read(proto::Expect::WelcomeOrError, kHandshakeDeadline);
  if (!reply) co_return reply.error();
  if (reply->type == proto::MessageType::Error) {
    const auto error = proto::decodeError(reply->payload);
    co_return runtimeError("master " + master->peer(), error ? error->text : error.error().what);
  }
  auto welcome = proto::decodeWelcome(reply->payload);
  if (!welcome) co_return welcome.error();
  TileConversation conversation(master, std::move(*welcome), options.surface);
  if (Status status = conversation.openSurface(); !status) {
    master->send(proto::encode(proto::ErrorMessage{proto::ErrorCode::Internal, status.error().text()}));
    co_return status;
  }
  co_return co_await conversation.run();
}

}  // namespace

Status runTile(const TileOptions& options) {
  net::asio::io_context io(1);
  Status outcome = runtimeError("", "the tile ended without a result");
  const auto conversation = [&]() -> awaitable<void> { outcome = co_await converse(options); };
  net::asio::co_spawn(io, conversation, [&outcome](const std::exception_ptr& exception) {
    if (!exception) return;
    try {
      std::rethrow_exception(exception);
    } catch (const std::exception& e) {
      outcome = runtimeError("", e.what());
    }
  });
  // Ends when the conversation is over and everything queued has been written.
  io.run();
  return outcome;
}

}  // namespace tessera
