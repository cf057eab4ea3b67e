#pragma once

#include <cstdint>
#include <vector>

#include "common/wall/wall.h"

namespace tessera {

/// Tiles whose frusta are culled by one frustum hierarchy.
struct FrustumGroup {
  /// Of an even grid, a screen's; 0 where the frusta lie anyhow.
  int columns = 0, rows = 0;
  std::uint32_t screen = 0;               ///< of a grid
  bool touch = true;                      ///< of a grid: neither gaps nor overlaps
  std::vector<std::uint32_t> tiles = {};  ///< of the wall, one for each frustum
  /// For each frustum: more tiles that show the same rectangle, to the other eye.
  std::vector<std::vector<std::uint32_t>> twins = {};
};

/// A wall's tiles in groups: every even grid of at least 2 x 2 tiles is one, since grids are culled fastest;
/// all other tiles together are one. A wall of one even grid is one group.
[[nodiscard]] std::vector<FrustumGroup> frustumGroups(const Wall& wall);

}  // namespace tessera
