#include "server/master/wall_culler.h"

#include <span>
#include <utility>

namespace tessera {

namespace {

std::span<const Frustum> pick(const std::vector<Frustum>& all, const std::vector<std::uint32_t>& which,
                              std::vector<Frustum>& into) {
  into.clear();
  for (const std::uint32_t tile : which)
    into.push_back(all[tile]);
  return into;
}

bool wantsFootprints(const cull::Options& options) {
  return options.algorithm == cull::Algorithm::Auto || options.algorithm == cull::Algorithm::Footprint ||
         options.algorithm == cull::Algorithm::Table;
}

/// By one eye: of tiles that show the same rectangle to one eye each, the one for this eye.
std::span<const Frustum> pickEye(const std::vector<Frustum>& all, const FrustumGroup& group,
                                 std::span<const TileEye> eyes, TileEye other, std::vector<Frustum>& into) {
  into.clear();
  for (std::size_t i = 0; i < group.tiles.size(); ++i) {
    std::uint32_t tile = group.tiles[i];
    for (const std::uint32_t twin : group.twins[i]) {
      if (eyes[tile] == other) tile = twin;
    }
    into.push_back(all[tile]);
  }
  return into;
}

}  // namespace

WallCuller::WallCuller(const ObjectHierarchy& scene, const Wall& wall, const cull::Options& options,
                       PlaneSource source) {
  places_.resize(wall.tiles.size());
  for (const Tile& tile : wall.tiles)
    eyes_.push_back(tile.eye);
  const bool byFootprints = wantsFootprints(options);
  eyesApart_ = byFootprints && wall.observer && wall.observer->stereo != Stereo::None;
  for (FrustumGroup& what : frustumGroups(wall, byFootprints ? Grouping::Grids : Grouping::Hierarchies)) {
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
                       .culler = groups_.empty() ? cull::Culler(scene, options)
                                                 : cull::Culler(scene, options, groups_.front().culler),
                       .rightGrid = {},
                       .rightCuller = {},
                       .tiles = {},
                       .left = {},
                       .right = {}});
    if (!eyesApart_) continue;
    Group& group = groups_.back();
    group.rightGrid = group.grid;
    group.rightCuller.emplace(scene, options, groups_.front().culler);
  }
  isPlain_ = !eyesApart_ && groups_.size() == 1 && groups_[0].what.tiles.size() == wall.tiles.size();
  result_.lists.resize(wall.tiles.size());
  changes_.toggled.resize(wall.tiles.size());
  changes_.leafCounts.resize(wall.tiles.size());
}

void WallCuller::update(const WallView& view) {
  for (Group& group : groups_)
    update(group, view);
}

void WallCuller::updateApart(Group& group, const WallView& view) {
  const auto update = [&](GridFrusta& grid, const cull::Culler& culler, const std::vector<Frustum>& all,
                          const std::vector<Frustum>& lattices, TileEye other, std::vector<Frustum>& into) {
    const auto tiles = pickEye(all, group.what, eyes_, other, into);
    const Frustum& lattice = group.what.isAlone ? tiles[0] : lattices[group.what.screen];
    grid.updateGrid(lattice, tiles);
    if (culler.readsPlanes(grid)) grid.updatePlanes(lattice, tiles);
  };
  update(*group.grid, group.culler, view.left, view.leftLattices, TileEye::Right, group.left);
  update(*group.rightGrid, *group.rightCuller, view.right, view.rightLattices, TileEye::Left, group.right);
}

void WallCuller::update(Group& group, const WallView& view) {
  if (eyesApart_) return updateApart(group, view);
  const std::span<const Frustum> tiles =
      isPlain_ ? std::span<const Frustum>(view.tiles) : pick(view.tiles, group.what.tiles, group.tiles);
  const bool isStereo = !view.left.empty();
  if (group.grid) {
    const bool isAlone = group.what.isAlone;
    group.grid->updateGrid(isAlone ? tiles[0] : view.lattices[group.what.screen], tiles);
    if (!isStereo && !group.culler.readsPlanes(*group.grid)) return;
    group.grid->updatePlanes(isAlone ? tiles[0] : view.screens[group.what.screen], tiles);
  } else {
    group.general.update(tiles);
  }
  if (!isStereo) return;
  const auto left = pickEye(view.left, group.what, eyes_, TileEye::Right, group.left);
  const auto right = pickEye(view.right, group.what, eyes_, TileEye::Left, group.right);
  if (group.grid) {
    group.grid->holdEyes(left, right);
  } else {
    group.general.holdEyes(left, right);
  }
}

void WallCuller::cullApart(Group& group) {
  const cull::Result& left = group.culler.cull(*group.grid);
  const cull::Result& right = group.rightCuller->cull(*group.rightGrid);
  result_.tests += left.tests;
  result_.tests += right.tests;
  const auto take = [&](std::uint32_t tile, std::size_t i) {
    switch (eyes_[tile]) {
      case TileEye::Left:
        result_.lists[tile] = left.lists[i];
        break;
      case TileEye::Right:
        result_.lists[tile] = right.lists[i];
        break;
      case TileEye::Both:
        result_.lists[tile] = unionOf(left.lists[i], right.lists[i]);
        break;
    }
  };
  for (std::size_t i = 0; i < group.what.tiles.size(); ++i) {
    take(group.what.tiles[i], i);
    for (const std::uint32_t twin : group.what.twins[i])
      take(twin, i);
  }
}

const cull::Result& WallCuller::cull() {
  if (isPlain_) return groups_[0].culler.cull(groups_[0].frusta());
  result_.tests = {};
  result_.pairs = 0;
  for (Group& group : groups_) {
    if (eyesApart_) {
      cullApart(group);
      continue;
    }
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
  if (eyesApart_) {
    listsBefore_.resize(result_.lists.size());
    std::swap(listsBefore_, result_.lists);
    cull();
    for (std::size_t tile = 0; tile < result_.lists.size(); ++tile) {
      symmetricDifferenceInto(listsBefore_[tile], result_.lists[tile], changes_.toggled[tile]);
      changes_.leafCounts[tile] = static_cast<std::uint32_t>(leafCount(result_.lists[tile]));
    }
    changes_.tests = result_.tests;
    changes_.pairs = result_.pairs;
    return changes_;
  }
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
  if (eyesApart_) {
    out = result_.lists[tile];
    return;
  }
  const Place& place = places_[tile];
  groups_[place.group].culler.listOf(place.frustum, out);
}

}  // namespace tessera
