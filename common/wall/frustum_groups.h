#pragma once

#include <cstdint>
#include <vector>

#include "common/wall/wall.h"

namespace tessera {

/// Tiles whose frusta are culled by one frustum hierarchy.
struct FrustumGroup {
  /// Of an even grid, a screen's; 0 where the frusta lie anyhow.
  int columns = 0, rows = 0;
  std::uint32_t screen = 0;  ///< of a grid
  bool touch = true;         ///< of a grid: neither gaps nor overlaps
  bool isAlone = false;      ///< a grid of one tile that need not fill its screen: its lattice is its frustum
  std::vector<std::uint32_t> tiles = {};  ///< of the wall, one for each frustum
  /// For each frustum: more tiles that show the same rectangle, to the other eye.
  std::vector<std::vector<std::uint32_t>> twins = {};
};

enum class Grouping {
  /// For cullers that are fast on grids and read no planes: every even grid of a screen is a group, and every
  /// other tile is a grid of its own.
  Grids,
  /// For cullers by planes: every even grid of at least 2 x 2 tiles that do not overlap is a group, and all
  /// other tiles together are one, under a hierarchy of their own.
  Hierarchies,
};

/// A wall's tiles in groups. A wall of one even grid is one group, either way.
[[nodiscard]] std::vector<FrustumGroup> frustumGroups(const Wall& wall, Grouping grouping);

}  // namespace tessera
