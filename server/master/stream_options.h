#pragma once

#include <cstdint>
#include <vector>

#include "proto/messages.h"

namespace tessera {

/// How geometry goes to tiles.
struct StreamOptions {
  proto::OnMiss onMiss = proto::OnMiss::Wait;
  /// Most bytes of assets that are sent to a tile in a frame, beside those that the frame waits for; at least
  /// one asset is.
  std::uint64_t uploadBytes = std::uint64_t{2} << 20;
  float uploadMs = 0;           ///< proto::Welcome::uploadMs
  unsigned predictFrames = 30;  ///< how far ahead geometry is sent; 0: none is
};

/// What a tile said of itself when it came.
struct TileFacts {
  std::uint64_t cacheBytes = 0;   ///< 0: no budget
  std::vector<bool> onDisk = {};  ///< by number of the asset; may be empty
};

}  // namespace tessera
