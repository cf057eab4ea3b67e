#include "server/master/wall_culler.h"

#include <span>

namespace tessera {

namespace {

std::span<const Frustum> pick(const std::vector<Frustum>& all, const std::vector<std::uint32_t>& which,
                              std::vector<Frustum>& into) {
  into.clear();
  for (const std::uint32_t tile : which)
    into.push_back(all[tile]);
  return into;
}

}  // namespace

WallCuller::WallCuller(const ObjectHierarchy& scene, const Wall& wall, const cull::Options& options,
                       PlaneSource source) {
  places_.resize(wall.tiles.size());
  for (FrustumGroup& what : frustumGroups(wall)) {
    const auto index = static_cast<std::uint32_t>(groups_.size());
    for (std::uint32_t i = 0; i < what.tiles.size(); ++i) {
      places_[what.tiles[i]] = {index, i};
      for (const std::uint32_t twin : what.twins[i])
        places_[twin] = {index, i};
    }
    std::optional<GridFrusta> grid;
    if (what.columns > 0) {
      grid.emplace(static_cast<std::uint16_t>(what.columns), static_cast<std::uint16_t>(what.rows), source,
                   what.touch ? GridFrusta::Neighbours::Touch : GridFrusta::Neighbours::GapOrOverlap);
    }
    groups_.push_back({.what = std::move(what),
                       .grid = std::move(grid),
                       .general = GeneralFrusta({.separateOverlaps = true, .source = source}),
                       .culler = cull::Culler(scene, options),
                       .tiles = {},
                       .left = {},
                       .right = {}});
  }
  isPlain_ = groups_.size() == 1 && groups_[0].what.tiles.size() == wall.tiles.size();
  result_.lists.resize(wall.tiles.size());
  changes_.toggled.resize(wall.tiles.size());
  changes_.leafCounts.resize(wall.tiles.size());
}

void WallCuller::update(const WallView& view) {
  for (Group& group : groups_)
    update(group, view);
}

void WallCuller::update(Group& group, const WallView& view) {
  const std::span<const Frustum> tiles =
      isPlain_ ? std::span<const Frustum>(view.tiles) : pick(view.tiles, group.what.tiles, group.tiles);
  const bool isStereo = !view.left.empty();
  if (group.grid) {
    group.grid->updateGrid(view.lattices[group.what.screen], tiles);
    if (!isStereo && !group.culler.readsPlanes(*group.grid)) return;
    group.grid->updatePlanes(view.screens[group.what.screen], tiles);
  } else {
    group.general.update(tiles);
  }
  if (!isStereo) return;
  const auto left = pick(view.left, group.what.tiles, group.left);
  const auto right = pick(view.right, group.what.tiles, group.right);
  if (group.grid) {
    group.grid->holdEyes(left, right);
  } else {
    group.general.holdEyes(left, right);
  }
}

const cull::Result& WallCuller::cull() {
  if (isPlain_) return groups_[0].culler.cull(groups_[0].frusta());
  result_.tests = {};
  result_.pairs = 0;
  for (Group& group : groups_) {
    const cull::Result& part = group.culler.cull(group.frusta());
    result_.tests += part.tests;
    for (std::size_t i = 0; i < group.what.tiles.size(); ++i) {
      result_.lists[group.what.tiles[i]] = part.lists[i];
      for (const std::uint32_t twin : group.what.twins[i])
        result_.lists[twin] = part.lists[i];
    }
  }
  for (const VisibleList& list : result_.lists)
    result_.pairs += leafCount(list);
  return result_;
}

const cull::Changes& WallCuller::cullChanges() {
  if (isPlain_) return groups_[0].culler.cullChanges(groups_[0].frusta());
  changes_.tests = {};
  changes_.pairs = 0;
  for (Group& group : groups_) {
    const cull::Changes& part = group.culler.cullChanges(group.frusta());
    changes_.tests += part.tests;
    const auto take = [&](std::uint32_t tile, std::size_t i) {
      changes_.toggled[tile] = part.toggled[i];
      changes_.leafCounts[tile] = part.leafCounts[i];
      changes_.pairs += part.leafCounts[i];
    };
    for (std::size_t i = 0; i < group.what.tiles.size(); ++i) {
      take(group.what.tiles[i], i);
      for (const std::uint32_t twin : group.what.twins[i])
        take(twin, i);
    }
  }
  return changes_;
}

void WallCuller::listOf(std::uint32_t tile, VisibleList& out) const {
  const Place& place = places_[tile];
  groups_[place.group].culler.listOf(place.frustum, out);
}

}  // namespace tessera
