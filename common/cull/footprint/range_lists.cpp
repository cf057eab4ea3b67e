#include "common/cull/footprint/range_lists.h"

namespace tessera::cull {

namespace {

constexpr std::size_t kFirstCapacity = 64;
constexpr LeafRange kNone = {0, UINT32_MAX};

}  // namespace

void RangeLists::begin(int columns, int rows) {
  columns_ = columns;
  pairs_ = 0;
  for (const std::uint32_t tile : touched_)
    tiles_[tile].last = tiles_[tile].ranges.data();
  touched_.clear();
  const std::size_t count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  for (std::size_t i = tiles_.size(); i < count; ++i) {
    Tile& tile = tiles_.emplace_back();
    tile.ranges.assign(kFirstCapacity, kNone);
    tile.last = tile.ranges.data();
    tile.limit = tile.ranges.data() + tile.ranges.size() - 1;
  }
  touched_.reserve(tiles_.size());
}

void RangeLists::grow(Tile& tile) {
  const auto at = tile.last - tile.ranges.data();
  tile.ranges.resize(2 * tile.ranges.size(), kNone);
  tile.last = tile.ranges.data() + at;
  tile.limit = tile.ranges.data() + tile.ranges.size() - 1;
}

}  // namespace tessera::cull
