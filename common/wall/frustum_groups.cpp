#include "common/wall/frustum_groups.h"

#include <algorithm>
#include <cmath>

namespace tessera {

namespace {

constexpr double kTouching = 1e-9;

bool isEvenGrid(const Wall& wall, const Screen& screen, Grouping grouping) {
  if (screen.columns == 0) return false;
  if (grouping == Grouping::Grids) return true;
  // A hierarchy that bisects a grid would unfold all that lies in overlaps down to the leaves.
  if (screen.latticeWidth < 1 - kTouching || screen.latticeHeight < 1 - kTouching) return false;
  return wall.screens.size() == 1 || (screen.columns > 1 && screen.rows > 1);
}

bool showsTheSame(const Tile& a, const Tile& b) {
  return a.screen == b.screen && a.eye != b.eye && a.corners == b.corners;
}

void add(const Wall& wall, std::uint32_t tile, FrustumGroup& group) {
  for (std::size_t i = 0; i < group.tiles.size(); ++i) {
    if (!showsTheSame(wall.tiles[group.tiles[i]], wall.tiles[tile])) continue;
    group.twins[i].push_back(tile);
    return;
  }
  group.tiles.push_back(tile);
  group.twins.emplace_back();
}

}  // namespace

std::vector<FrustumGroup> frustumGroups(const Wall& wall, Grouping grouping) {
  std::vector<FrustumGroup> groups;
  FrustumGroup others;
  for (std::uint32_t s = 0; s < wall.screens.size(); ++s) {
    const Screen& screen = wall.screens[s];
    FrustumGroup grid{.columns = screen.columns, .rows = screen.rows, .screen = s};
    grid.touch =
        std::abs(screen.latticeWidth - 1) < kTouching && std::abs(screen.latticeHeight - 1) < kTouching;
    const bool isGrid = isEvenGrid(wall, screen, grouping);
    for (std::uint32_t t = screen.firstTile; t < screen.firstTile + screen.tileCount; ++t) {
      if (isGrid) {
        grid.tiles.push_back(t);
        grid.twins.emplace_back();
      } else {
        add(wall, t, others);
      }
    }
    if (isGrid) groups.push_back(std::move(grid));
  }
  if (others.tiles.empty()) return groups;
  if (grouping == Grouping::Hierarchies) {
    groups.push_back(std::move(others));
    return groups;
  }
  for (std::size_t i = 0; i < others.tiles.size(); ++i) {
    FrustumGroup alone{
        .columns = 1, .rows = 1, .screen = wall.tiles[others.tiles[i]].screen, .isAlone = true};
    alone.tiles.push_back(others.tiles[i]);
    alone.twins.push_back(others.twins[i]);
    groups.push_back(std::move(alone));
  }
  return groups;
}

}  // namespace tessera
