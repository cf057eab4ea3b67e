#pragma once

#include <chrono>
#include <string>

#include "common/base/result.h"
#include "common/net/connection.h"
#include "proto/messages.h"

namespace tessera {

struct TileOptions {
  net::HostPort master;
  std::string tileName;
  proto::SurfaceKind surface = proto::SurfaceKind::Offscreen;
  std::chrono::milliseconds connectDeadline{10'000};
};

/// Connects, draws what the master says until it says Bye, and leaves. An error names who failed and why.
[[nodiscard]] Status runTile(const TileOptions& options);

}  // namespace tessera
