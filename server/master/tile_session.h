#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "common/assets/asset_table.h"
#include "common/net/connection.h"
#include "common/wall/wall.h"
#include "server/master/input_queue.h"
#include "server/master/picture_writer.h"
#include "server/master/stream_options.h"
#include "server/master/tile_roster.h"
#include "server/master/tile_setup.h"

namespace tessera {

/// Deadlines of the conversation with a tile.
struct SessionDeadlines {
  net::Milliseconds hello{5'000};  ///< from connecting to the whole Hello
  net::Milliseconds idle{15'000};  ///< without a word from the tile; it is asked three times as often
  net::Milliseconds write{10'000};
};

/// What all sessions share. Everything it refers to outlives the network thread.
struct SessionContext {
  const Wall& wall;
  std::uint32_t leafCount = 0;
  const AssetTable& assets;
  const StreamOptions& stream;
  TileRoster& roster;
  const TileSetups& setups;
  InputQueue& inputs;
  PictureWriter* pictures = nullptr;  ///< null: none are wanted
  SessionDeadlines deadlines;
  int handshakes = 0;  ///< connections that have not said who they are; network thread only
};

/// Speaks with one connection from its Hello to its end: binds it to the tile it names, then hands what it
/// says to the roster and the pictures. A peer that breaks the protocol is told why and closed; nobody else
/// notices.
[[nodiscard]] net::awaitable<void> serveTile(std::shared_ptr<net::Connection> peer, SessionContext& context);

}  // namespace tessera
