#include "common/cull/footprint/footprint_table.h"

#include <algorithm>
#include <array>
#include <cstring>

#include <tbb/parallel_for.h>

#include "common/cull/footprint/outline.h"
#include "common/cull/footprint/range_lists.h"

namespace tessera::cull {

namespace {

constexpr std::size_t kBatchBlocks = 32;

/// The columns that a footprint covers in a row.
ColumnSpan spanIn(int row, const TileCells& cells, const ColumnSpan* spans) {
  if (row < cells.firstRow || row > cells.lastRow || cells.firstColumn > cells.lastColumn) return {};
  if (spans) return spans[row - cells.firstRow];
  return {static_cast<std::uint8_t>(cells.firstColumn), static_cast<std::uint8_t>(cells.lastColumn)};
}

}  // namespace

void FootprintTable::reset(const BoxTree& tree, const GridCoordinates& grid) {
  leafCount_ = tree.leafCount();
  columns_ = grid.columns;
  rows_ = grid.rows;
  const std::size_t blocks = tree.leaves().size();
  rects_.assign(blocks * kLanes, kNoTiles);
  slots_.assign(blocks * kLanes, 0);
  chunks_.assign((blocks + kChunkBlocks - 1) / kChunkBlocks, {});
}

const ColumnSpan* FootprintTable::spansOf(std::uint32_t leaf) const {
  if (!(rects_[leaf] & kSpansFlag)) return nullptr;
  const Chunk& chunk = chunks_[leaf / (kChunkBlocks * kLanes)];
  return chunk.spans.data() + std::size_t{slots_[leaf]} * static_cast<std::size_t>(rows_);
}

/// Brings one chunk up to date.
class FootprintTable::Updater {
 public:
  Updater(FootprintTable& table, Chunk& chunk, const ObjectHierarchy& oh, const BoxTree& tree,
          const GridCoordinates& grid, bool refines)
      : table_(table), chunk_(chunk), outliner_(oh, tree, grid, refines) {}

  /// `rects` are what the kernel found for a block.
  void take(std::uint32_t block, BlockLanes lanes, TileRect* rects) {
    const std::size_t first = block * kLanes;
    TileRect* const now = table_.rects_.data() + first;
    for (std::size_t leaf = std::max<std::size_t>(first, table_.leafCount_); leaf < first + kLanes; ++leaf)
      rects[leaf - first] = kNoTiles;  // what fills up the last block
    // Those with spans are taken one by one, before their slots are used again.
    std::uint32_t done = 0;
    if (lanes.open | lanes.wide) {
      outliner_.finish(block, lanes, rects, [&](std::uint32_t lane, std::span<const ColumnSpan> spans) {
        takeRefined(static_cast<std::uint32_t>(first + lane), rects[lane], spans);
        done |= 1U << lane;
      });
    }
    if (done == 0 && std::memcmp(now, rects, kLanes * sizeof(TileRect)) == 0) return;
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      if (((done >> lane) & 1) || now[lane] == rects[lane]) continue;
      const auto leaf = static_cast<std::uint32_t>(first + lane);
      note(leaf);
      if (now[lane] & kSpansFlag) chunk_.freeSlots.push_back(table_.slots_[leaf]);
      now[lane] = rects[lane];
    }
    sortLast(block);
  }

 private:
  void takeRefined(std::uint32_t leaf, TileRect rect, std::span<const ColumnSpan> spans) {
    TileRect& now = table_.rects_[leaf];
    if (now == rect && std::equal(spans.begin(), spans.end(), table_.spansOf(leaf))) return;
    note(leaf);
    const auto rows = static_cast<std::size_t>(table_.rows_);
    if (!(now & kSpansFlag)) {
      if (chunk_.freeSlots.empty()) {
        chunk_.freeSlots.push_back(static_cast<std::uint32_t>(chunk_.spans.size() / rows));
        chunk_.spans.resize(chunk_.spans.size() + rows);
      }
      table_.slots_[leaf] = chunk_.freeSlots.back();
      chunk_.freeSlots.pop_back();
    }
    now = rect;
    std::copy(spans.begin(), spans.end(),
              chunk_.spans.begin() + static_cast<std::ptrdiff_t>(table_.slots_[leaf] * rows));
  }

  /// Keeps a footprint as it was.
  void note(std::uint32_t leaf) {
    const TileRect before = table_.rects_[leaf];
    chunk_.changed.push_back({leaf, before, static_cast<std::uint32_t>(chunk_.spansBefore.size())});
    if (!(before & kSpansFlag)) return;
    const TileCells cells = unpack(before);
    const ColumnSpan* spans = table_.spansOf(leaf);
    chunk_.spansBefore.insert(chunk_.spansBefore.end(), spans, spans + (cells.lastRow - cells.firstRow + 1));
  }

  /// Refined leaves of a block were noted before the others.
  void sortLast(std::uint32_t block) {
    auto from = chunk_.changed.end();
    while (from != chunk_.changed.begin() && std::prev(from)->leaf / kLanes == block)
      --from;
    std::sort(from, chunk_.changed.end(), [](const Changed& a, const Changed& b) { return a.leaf < b.leaf; });
  }

  FootprintTable& table_;
  Chunk& chunk_;
  Outliner outliner_;
};

void FootprintTable::update(const ObjectHierarchy& oh, const BoxTree& tree, const GridCoordinates& grid,
                            bool refines, unsigned threads) {
  const KernelFrame frame = KernelFrame::forLeaves(grid, tree.scale());
  const Kernels& kernel = kernels();
  const std::size_t blocks = tree.leaves().size();
  const auto updateChunk = [&](std::size_t i) {
    Chunk& chunk = chunks_[i];
    chunk.changed.clear();
    chunk.spansBefore.clear();
    Updater updater(*this, chunk, oh, tree, grid, refines);
    const std::size_t end = std::min(blocks, (i + 1) * kChunkBlocks);
    std::array<TileRect, kBatchBlocks * kLanes> rects;
    std::array<BlockLanes, kBatchBlocks> lanes;
    for (std::size_t first = i * kChunkBlocks; first < end; first += kBatchBlocks) {
      const std::size_t count = std::min(kBatchBlocks, end - first);
      kernel.leaves(frame, tree.leaves().data() + first, count, rects.data(), lanes.data());
      for (std::size_t b = 0; b < count; ++b)
        updater.take(static_cast<std::uint32_t>(first + b), lanes[b], rects.data() + b * kLanes);
    }
    chunk.blocks = end - i * kChunkBlocks;
  };
  if (threads < 2 || chunks_.size() < 2) {
    for (std::size_t i = 0; i < chunks_.size(); ++i)
      updateChunk(i);
  } else {
    tbb::parallel_for(std::size_t{0}, chunks_.size(), updateChunk);
  }
}

void FootprintTable::list(Result& result) const {
  RangeLists lists(result.lists, columns_);
  for (std::uint32_t leaf = 0; leaf < leafCount_;) {
    const TileRect rect = rects_[leaf];
    std::uint32_t end = leaf + 1;
    if (rect & kSpansFlag) {
      const TileCells cells = unpack(rect);
      lists.add({leaf, end}, cells, {spansOf(leaf), static_cast<std::size_t>(cells.lastRow - cells.firstRow + 1)});
    } else {
      while (end < leafCount_ && rects_[end] == rect)
        ++end;
      if (rect != kNoTiles) lists.add({leaf, end}, unpack(rect));
    }
    leaf = end;
  }
  result.pairs = lists.pairs();
  result.tests.nodes = blocksLookedAt();
}

std::uint64_t FootprintTable::blocksLookedAt() const {
  std::uint64_t blocks = 0;
  for (const Chunk& chunk : chunks_)
    blocks += chunk.blocks;
  return blocks;
}

void FootprintTable::list(std::uint32_t tile, VisibleList& out) const {
  out.clear();
  const int row = static_cast<int>(tile) / columns_, column = static_cast<int>(tile) % columns_;
  for (std::uint32_t leaf = 0; leaf < leafCount_; ++leaf) {
    const ColumnSpan span = spanIn(row, unpack(rects_[leaf]), spansOf(leaf));
    if (span.first <= column && column <= span.last) appendRange(out, {leaf, leaf + 1});
  }
}

void FootprintTable::changes(Changes& changes) const {
  changes.tests.nodes = blocksLookedAt();
  for (const Chunk& chunk : chunks_) {
    for (const Changed& changed : chunk.changed) {
      const LeafRange leaf = {changed.leaf, changed.leaf + 1};
      const TileCells before = unpack(changed.before), now = unpack(rects_[changed.leaf]);
      const ColumnSpan* spansBefore =
          changed.before & kSpansFlag ? chunk.spansBefore.data() + changed.spansBefore : nullptr;
      const ColumnSpan* spansNow = spansOf(changed.leaf);
      const int firstRow = before.empty() ? now.firstRow : now.empty() ? before.firstRow : std::min(before.firstRow, now.firstRow);
      const int lastRow = std::max(before.lastRow, now.lastRow);
      for (int row = firstRow; row <= lastRow; ++row) {
        const ColumnSpan was = spanIn(row, before, spansBefore), is = spanIn(row, now, spansNow);
        if (was == is) continue;
        const int first = was.first > was.last ? is.first : is.first > is.last ? was.first : std::min(was.first, is.first);
        const int last = std::max(was.last, is.last);
        for (int column = first; column <= last; ++column) {
          const bool wasIn = was.first <= column && column <= was.last;
          const bool isIn = is.first <= column && column <= is.last;
          if (wasIn == isIn) continue;
          const auto tile = static_cast<std::size_t>(row * columns_ + column);
          appendRange(changes.toggled[tile], leaf);
          changes.leafCounts[tile] += isIn ? 1U : ~0U;
          changes.pairs += isIn ? 1U : ~std::uint64_t{0};
        }
      }
    }
  }
}

}  // namespace tessera::cull
