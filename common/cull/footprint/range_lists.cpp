#include "common/cull/footprint/range_lists.h"

namespace tessera::cull {

namespace {

constexpr std::size_t kFirstCapacity = 64;
constexpr LeafRange kNone = {0, UINT32_MAX};

}  // namespace

void RangeLists::begin(int columns, int rows) {
  columns_ = columns;
  tileCount_ = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  pairs_ = 0;
  if (tiles_.size() < tileCount_) tiles_.resize(tileCount_);
  for (std::size_t i = 0; i < tileCount_; ++i) {
    Tile& tile = tiles_[i];
    if (tile.ranges.empty()) tile.ranges.assign(kFirstCapacity, kNone);
    tile.last = tile.ranges.data();
    tile.limit = tile.ranges.data() + tile.ranges.size() - 1;
  }
}

void RangeLists::grow(Tile& tile) {
  const auto at = tile.last - tile.ranges.data();
  tile.ranges.resize(2 * tile.ranges.size(), kNone);
  tile.last = tile.ranges.data() + at;
  tile.limit = tile.ranges.data() + tile.ranges.size() - 1;
}

}  // namespace tessera::cull
