#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/surface.h"
#include "common/assets/disk_store.h"
#include "common/base/result.h"
#include "common/net/connection.h"
#include "proto/messages.h"

namespace tessera {

struct TileOptions {
  net::HostPort master;
  std::vector<std::string> tileNames;  ///< several only where nothing is drawn
  proto::SurfaceKind surface = proto::SurfaceKind::Offscreen;
  SurfaceMaker* surfaces = nullptr;  ///< of that kind; null where nothing is drawn
  std::chrono::milliseconds connectDeadline{10'000};
  std::uint64_t cacheBytes = std::uint64_t{1} << 30;  ///< budget of each tile; 0: none
  std::shared_ptr<DiskStore> disk = nullptr;          ///< survives restarts; null: none
};

/// Connects, draws what the master says until it says Bye, and leaves. An error names who failed and why.
/// Several tiles have a connection each and share this thread; where one fails all leave, so that whoever
/// started the process sees it end.
[[nodiscard]] Status runTiles(const TileOptions& options);

}  // namespace tessera
