#include "server/master/tile_session.h"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "proto/codec.h"
#include "proto/protocol_error.h"

namespace tessera {

namespace {

using net::awaitable;
using proto::ErrorCode;

constexpr std::uint32_t kMostHave = 1 << 22;

/// Counts the Input messages of one tile in each second.
class InputRate {
 public:
  /// False: it is more than a tile may send (PROTOCOL.md).
  [[nodiscard]] bool countOne() {
    const auto now = net::Clock::now();
    if (now - start_ >= std::chrono::seconds(1)) start_ = now, count_ = 0;
    return ++count_ <= kMostPerSecond;
  }

 private:
  static constexpr int kMostPerSecond = 1000;
  net::Clock::time_point start_ = net::Clock::now();
  int count_ = 0;
};

/// A tile's conversation after the handshake.
struct Talk {
  TileRoster::Binding binding;
  InputRate inputRate = {};
  bool left = false;  ///< it has ended, in order
};

void refuse(net::Connection& peer, ErrorCode code, const std::string& text) {
  spdlog::warn("{}: refused: {}", peer.peer(), text);
  peer.send(proto::encode(proto::ErrorMessage{code, text}));
  peer.closeAfterSending();
}

ErrorCode codeOf(const Error& error) {
  return proto::protocolErrorOf(error) == proto::ProtocolError::WrongVersion ? ErrorCode::VersionMismatch
                                                                             : ErrorCode::ProtocolViolation;
}

proto::Welcome welcomeFor(const SessionContext& context, const TileRoster::Binding& binding) {
  const Tile& tile = context.wall.tiles[binding.tile];
  proto::Welcome welcome;
  welcome.session = binding.session;
  welcome.wallName = context.wall.name.substr(0, proto::kMaxNameBytes);
  welcome.tileName = tile.name;
  welcome.widthPx = tile.widthPx;
  welcome.heightPx = tile.heightPx;
  welcome.xPx = tile.xPx;
  welcome.yPx = tile.yPx;
  welcome.wallWidthPx = tile.canvasWidthPx;
  welcome.wallHeightPx = tile.canvasHeightPx;
  welcome.idleTimeoutMs = static_cast<std::uint32_t>(context.deadlines.idle.count());
  welcome.leafCount = context.leafCount;
  welcome.picture = context.pictures ? proto::PictureFormat::RawRgb8 : proto::PictureFormat::None;
  welcome.onMiss = context.stream.onMiss;
  welcome.uploadMs = context.stream.uploadMs;
  welcome.backgroundRgb = {0.60F, 0.68F, 0.76F};
  return welcome;
}

/// What a tile has on its disk of this scene, as it tells after Hello.
awaitable<Result<std::shared_ptr<const TileFacts>>> readFacts(std::shared_ptr<net::Connection> peer,
                                                              proto::Hello hello, SessionContext& context) {
  auto facts = std::make_shared<TileFacts>();
  facts->cacheBytes = hello.cacheBytes;
  if (hello.haveCount > kMostHave)
    co_return runtimeError("", "has more on its disk than " + std::to_string(kMostHave) + " assets");
  if (hello.haveCount > 0) facts->onDisk.assign(context.assets.size(), false);
  for (std::uint32_t told = 0; told < hello.haveCount;) {
    auto message = co_await peer->read(proto::Expect::Have, context.deadlines.hello);
    if (!message) co_return message.error();
    const auto have = proto::decodeHave(message->payload);
    if (!have) co_return have.error();
    // Each but the last is full: else a peer could tell of one at a time, and hold its place for ever.
    if (have->ids.size() != std::min<std::size_t>(hello.haveCount - told, proto::kMaxAssetsPerMessage))
      co_return runtimeError("", "tells of other assets than it announced");
    told += static_cast<std::uint32_t>(have->ids.size());
    for (const proto::Sha256& id : have->ids) {
      if (const auto number = context.assets.numberOf(AssetId{id})) facts->onDisk[*number] = true;
    }
  }
  co_return std::shared_ptr<const TileFacts>(std::move(facts));
}

/// Asks the tile for a sign of life, so that both sides notice a dead link.
awaitable<void> keepAsking(std::weak_ptr<net::Connection> weak, net::Milliseconds every) {
  net::asio::steady_timer timer(co_await net::asio::this_coro::executor);
  for (std::uint64_t nonce = 1;; ++nonce) {
    timer.expires_after(every);
    net::error_code ec;
    co_await timer.async_wait(net::asio::redirect_error(net::asio::use_awaitable, ec));
    const auto peer = weak.lock();
    if (ec || !peer) co_return;
    peer->send(proto::encode(proto::Ping{nonce}));
  }
}

/// One message of a bound tile. An error ends the session.
Status handle(const net::Message& message, Talk& talk, SessionContext& context) {
  const TileRoster::Binding& binding = talk.binding;
  auto decoded = proto::decode(message.type, message.payload);
  if (!decoded) return decoded.error();
  if (const auto* ready = std::get_if<proto::Ready>(&*decoded)) {
    if (!context.roster.ready(binding, *ready))
      return runtimeError("", "acknowledges a frame that it was not sent");
  } else if (const auto* shown = std::get_if<proto::Shown>(&*decoded)) {
    if (!context.roster.mayShow(binding, shown->frame))
      return runtimeError("", "shows a frame that it did not acknowledge");
    if (shown->picture) {
      if (!context.pictures || !context.pictures->wants(shown->frame)) {
        return runtimeError("", "sends a picture that nobody asked for");
      }
      if (!context.pictures->add(binding.tile, shown->frame, *shown->picture)) {
        return runtimeError("", "sends a picture of the wrong size");
      }
    }
    (void)context.roster.shown(binding, *shown);
  } else if (const auto* lacks = std::get_if<proto::Lacks>(&*decoded)) {
    std::vector<std::uint32_t> numbers;
    for (const proto::Sha256& id : lacks->ids) {
      if (const auto number = context.assets.numberOf(AssetId{id})) numbers.push_back(*number);
    }
    context.roster.lacks(binding, numbers);
  } else if (const auto* input = std::get_if<proto::Input>(&*decoded)) {
    if (!talk.inputRate.countOne()) return runtimeError("", "sends more input than 1000 messages a second");
    context.inputs.add(binding.tile, *input);
  } else if (const auto* bye = std::get_if<proto::Bye>(&*decoded)) {
    context.roster.leaving(binding, *bye);
    talk.left = true;
  } else if (const auto* error = std::get_if<proto::ErrorMessage>(&*decoded)) {
    spdlog::error("tile {}: {}", context.roster.nameOf(binding.tile), error->text);
    talk.left = true;
  }
  return Done{};
}

awaitable<void> converse(std::shared_ptr<net::Connection> peer, TileRoster::Binding binding,
                         SessionContext& context) {
  const std::string name = context.roster.nameOf(binding.tile);
  for (Talk talk{.binding = binding}; !talk.left;) {
    auto message = co_await peer->read(proto::Expect::FromTile, context.deadlines.idle);
    Status status = message ? handle(*message, talk, context) : Status(message.error());
    if (!status) {
      const bool isViolation = !message.ok() ? proto::protocolErrorOf(message.error()).has_value() : true;
      spdlog::warn("tile {}: {}", name, status.error().text());
      if (isViolation) {
        peer->send(proto::encode(proto::ErrorMessage{ErrorCode::ProtocolViolation, status.error().what}));
        peer->closeAfterSending();
      } else {
        peer->close();
      }
      co_return;
    }
  }
  peer->closeAfterSending();
}

}  // namespace

awaitable<void> serveTile(std::shared_ptr<net::Connection> peer, SessionContext& context) {
  peer->startWriter(context.deadlines.write);
  ++context.handshakes;
  auto message = co_await peer->read(proto::Expect::Hello, context.deadlines.hello);
  --context.handshakes;
  if (!message) {
    refuse(*peer, codeOf(message.error()), message.error().what);
    co_return;
  }
  const auto hello = proto::decodeHello(message->payload);
  if (!hello) {
    refuse(*peer, ErrorCode::ProtocolViolation, hello.error().what);
    co_return;
  }
  const auto facts = co_await readFacts(peer, *hello, context);
  if (!facts) {
    refuse(*peer, codeOf(facts.error()), facts.error().what);
    co_return;
  }
  const auto bound = context.roster.bind(*hello, peer, *facts, [&](const TileRoster::Binding& binding) {
    peer->send(proto::encode(welcomeFor(context, binding)));
    peer->send(proto::encode(context.setups.of(binding.tile)));
  });
  if (const auto* refusal = std::get_if<TileRoster::Refusal>(&bound)) {
    switch (*refusal) {
      case TileRoster::Refusal::UnknownTile:
        refuse(
            *peer, ErrorCode::UnknownTile,
            "the wall has no tile named \"" + hello->tileName + "\"; its tiles are named in its wall file");
        break;
      case TileRoster::Refusal::TileTaken:
        refuse(*peer, ErrorCode::TileTaken,
               "the tile \"" + hello->tileName +
                   "\" is connected already; stop the other one or name another tile");
        break;
      case TileRoster::Refusal::ShuttingDown:
        refuse(*peer, ErrorCode::ShuttingDown, "the wall is shutting down");
        break;
    }
    co_return;
  }
  const auto binding = std::get<TileRoster::Binding>(bound);
  spdlog::debug("tile {} connected from {}", hello->tileName, peer->peer());
  net::asio::co_spawn(co_await net::asio::this_coro::executor, keepAsking(peer, context.deadlines.idle / 3),
                      net::asio::detached);
  co_await converse(peer, binding, context);
  context.roster.gone(binding);
  spdlog::debug("tile {} left", hello->tileName);
}

}  // namespace tessera
