#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "common/base/result.h"
#include "common/wall/wall.h"
#include "proto/messages.h"

namespace tessera {

/// What each tile is told of its place on the wall and of its display, once, before its first frame.
class TileSetups {
 public:
  /// Reads the warps' files. Each mesh is as coarse as it may be without an error of more than
  /// kMostWarpErrorPx; a tracked observer's eye is taken where the wall file has it.
  [[nodiscard]] static Result<TileSetups> make(const Wall& wall);

  /// Refers to memory of this.
  [[nodiscard]] const proto::TileSetup& of(std::uint32_t tile) const { return setups_[tile]; }
  /// The largest error of a warp's mesh, in pixels; 0 without warps.
  [[nodiscard]] double warpErrorPx() const { return warpErrorPx_; }

  static constexpr double kMostWarpErrorPx = 0.1;

  TileSetups(const TileSetups&) = delete;
  TileSetups& operator=(const TileSetups&) = delete;
  TileSetups(TileSetups&&) = default;
  TileSetups& operator=(TileSetups&&) = default;
  ~TileSetups() = default;

 private:
  TileSetups() = default;
  Status addWarp(const Wall& wall, const Tile& tile, proto::TileSetup& setup);
  std::span<const std::byte> keep(std::vector<std::byte> bytes);

  std::vector<proto::TileSetup> setups_;
  std::deque<std::vector<std::byte>> kept_;
  double warpErrorPx_ = 0;
};

/// How the wall's stereo is told to tiles.
[[nodiscard]] proto::StereoLayout stereoLayout(const Wall& wall);

}  // namespace tessera
