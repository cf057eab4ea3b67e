#include "common/cull/footprint/footprint_table.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <span>

#include <tbb/parallel_for.h>

#include "common/cull/footprint/outline.h"

namespace tessera::cull {

namespace {

constexpr std::size_t kBatchBlocks = 32;
/// Sums of turn and travel beyond which certificates are counted from anew: floats would lose what is added.
constexpr double kLongestDrift = 4;

KernelDrift roundedUp(const CameraDrift& drift) {
  const auto up = [](double x) { return static_cast<float>(x * (1 + 0x1p-22)); };
  return {up(drift.columns().turn), up(drift.columns().travel), up(drift.rows().turn),
          up(drift.rows().travel)};
}

bool bordersAreInPlace(const GridCoordinates& grid) {
  const double slack = double{kBorderSlack} / 2;
  return std::abs(grid.columnLow) < slack && std::abs(grid.columnHigh - 1) < slack &&
         std::abs(grid.rowLow) < slack && std::abs(grid.rowHigh - 1) < slack;
}

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
  certifies_ = false;
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
      : table_(table),
        chunk_(chunk),
        tree_(tree),
        kernels_(kernels()),
        frame_(KernelFrame::forLeaves(grid, tree.scale())),
        nodeFrame_(KernelFrame::forNodes(grid, tree.scale())),
        drift_(roundedUp(table.drift_)),
        refines_(refines),
        outliner_(oh, tree, grid, refines) {
    chunk_.changed.clear();
    chunk_.spansBefore.clear();
    chunk_.leaves = 0;
  }

  /// All leaves of some blocks.
  void update(std::size_t first, std::size_t end, bool certifies) {
    std::array<TileRect, kBatchBlocks * kLanes> rects;
    std::array<BlockLanes, kBatchBlocks> lanes;
    std::array<std::uint32_t, kLanes> ids;
    for (std::size_t count = 0; first < end; first += count) {
      count = std::min(kBatchBlocks, end - first);
      const OrientedBlock* blocks = tree_.leaves().data() + first;
      if (certifies) {
        kernels_.leavesCertified(frame_, blocks, count, rects.data(), lanes.data(), drift_,
                                 table_.expiries_.data() + first);
      } else {
        kernels_.leaves(frame_, blocks, count, rects.data(), lanes.data());
      }
      for (std::size_t b = 0; b < count; ++b) {
        const auto id = static_cast<std::uint32_t>((first + b) * kLanes);
        std::iota(ids.begin(), ids.end(), id);
        const std::size_t leaves = std::min<std::size_t>(kLanes, table_.leafCount_ - id);
        takeBlock({ids.data(), leaves}, lanes[b], rects.data() + b * kLanes);
        if (certifies) expireRefined(lanes[b], table_.expiries_[first + b]);
      }
    }
  }

  /// The same without certificates: blocks of which the boxes above them tell enough are not looked into.
  /// `first` is a multiple of kLanes.
  void updateByNodes(std::size_t first, std::size_t end) {
    const auto& level = tree_.levels().front();
    NodeFootprints found;
    for (; first < end; first += kLanes) {
      kernels_.nodes(nodeFrame_, level.blocks[first / kLanes], found);
      std::size_t pending = first;  // blocks from here on are to be looked into
      const std::size_t last = std::min(end, first + kLanes);
      for (std::size_t block = first; block < last; ++block) {
        const std::size_t lane = block - first;
        const bool isNowhere = found.rects[lane] == kNoTiles && !((found.unknown >> lane) & 1);
        if (!isNowhere && !((found.contained >> lane) & 1)) continue;
        update(pending, block, false);
        pending = block + 1;
        takeUniform(block, found.rects[lane]);
      }
      update(pending, last, false);
    }
  }

  /// Only what holds no longer, gathered from many blocks into full ones.
  void updateExpired(std::size_t first, std::size_t end) {
    std::array<std::uint16_t, kBatchBlocks> expired;
    for (std::size_t count = 0; first < end; first += count) {
      count = std::min(kBatchBlocks, end - first);
      kernels_.expired(table_.expiries_.data() + first, count, drift_, expired.data());
      std::size_t gone = 0;
      for (std::size_t b = 0; b < count; ++b)
        gone += static_cast<std::size_t>(std::popcount(expired[b]));
      // To gather a leaf costs about as much as to look at five that lie side by side.
      if (5 * gone > count * kLanes) {
        updatePending(1);
        for (std::size_t b = 0; b < count; ++b) {
          if (expired[b] != 0) update(first + b, first + b + 1, true);
        }
      } else {
        for (std::size_t b = 0; b < count; ++b)
          gather(first + b, expired[b]);
      }
    }
    updatePending(1);
  }

 private:
  /// Leaves far apart are on their way from memory while others are waited for.
  void gather(std::size_t block, std::uint32_t lanes) {
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
      const auto id = static_cast<std::uint32_t>(block * kLanes) + lane;
      if (id >= table_.leafCount_) break;
      __builtin_prefetch(&tree_.leaf(id));
      __builtin_prefetch(&table_.rects_[id]);
      pending_[pendingCount_++] = id;
    }
    if (pendingCount_ + kLanes > pending_.size()) updatePending(kLanes);
  }

  /// Those that wait, as long as there are `least` of them.
  void updatePending(std::size_t least) {
    std::size_t done = 0;
    while (pendingCount_ - done >= least) {
      const std::size_t count = std::min(kLanes, pendingCount_ - done);
      updateGathered({pending_.data() + done, count});
      done += count;
    }
    std::copy(pending_.begin() + static_cast<std::ptrdiff_t>(done),
              pending_.begin() + static_cast<std::ptrdiff_t>(pendingCount_), pending_.begin());
    pendingCount_ -= done;
  }

  void updateGathered(std::span<const std::uint32_t> ids) {
    for (std::size_t lane = 0; lane < kLanes; ++lane)
      setLane(gathered_, lane, tree_.leaf(ids[std::min(lane, ids.size() - 1)]));
    std::array<TileRect, kLanes> rects;
    BlockLanes lanes;
    BlockExpiry expiry;
    kernels_.leavesCertified(frame_, &gathered_, 1, rects.data(), &lanes, drift_, &expiry);
    const std::uint32_t done = takeRefined(ids, lanes, rects.data());
    for (std::size_t lane = 0; lane < ids.size(); ++lane)
      takeUnrefined(ids[lane], rects[lane], (done >> lane) & 1);
    sortFrom(ids.front());
    expireRefined(lanes, expiry);
    for (std::size_t lane = 0; lane < ids.size(); ++lane) {
      BlockExpiry& to = table_.expiries_[ids[lane] / kLanes];
      const std::size_t place = ids[lane] % kLanes;
      to.columnUntil[place] = expiry.columnUntil[lane];
      to.rowUntil[place] = expiry.rowUntil[lane];
      to.reach[place] = expiry.reach[lane];
    }
    chunk_.leaves += ids.size();
  }

  /// A block whose leaves are all in one tile, or nowhere.
  void takeUniform(std::size_t block, TileRect rect) {
    const std::size_t first = block * kLanes;
    const TileRect* const now = table_.rects_.data() + first;
    const std::size_t count = std::min<std::size_t>(kLanes, table_.leafCount_ - first);
    if (std::all_of(now, now + count, [rect](TileRect r) { return r == rect; })) return;
    for (std::size_t lane = 0; lane < count; ++lane)
      takeUnrefined(static_cast<std::uint32_t>(first + lane), rect, false);
  }

  /// A block of consecutive leaves.
  void takeBlock(std::span<const std::uint32_t> ids, BlockLanes lanes, TileRect* rects) {
    chunk_.leaves += ids.size();
    const std::uint32_t done = takeRefined(ids, lanes, rects);
    TileRect* const now = table_.rects_.data() + ids.front();
    if (done == 0 && std::memcmp(now, rects, ids.size() * sizeof(TileRect)) == 0) return;
    for (std::size_t lane = 0; lane < ids.size(); ++lane)
      takeUnrefined(ids[lane], rects[lane], (done >> lane) & 1);
    sortFrom(ids.front());
  }

  /// Spans may change with the slightest motion, also where they are the whole rectangle now.
  void expireRefined(BlockLanes lanes, BlockExpiry& expiry) const {
    for (std::uint32_t left = refines_ ? lanes.wide : 0U; left != 0; left &= left - 1)
      expiry.columnUntil[std::countr_zero(left)] = -std::numeric_limits<float>::infinity();
  }

  /// Those with spans are taken one by one, before their slots are used again. A mask of them.
  std::uint32_t takeRefined(std::span<const std::uint32_t> ids, BlockLanes lanes, TileRect* rects) {
    std::uint32_t done = 0;
    if (lanes.open | lanes.wide) {
      outliner_.finish(ids, lanes, rects, [&](std::uint32_t lane, std::span<const ColumnSpan> spans) {
        takeSpans(ids[lane], rects[lane], spans);
        done |= 1U << lane;
      });
    }
    return done;
  }

  void takeUnrefined(std::uint32_t leaf, TileRect rect, bool isDone) {
    TileRect& now = table_.rects_[leaf];
    if (isDone || now == rect) return;
    note(leaf);
    if (now & kSpansFlag) chunk_.freeSlots.push_back(table_.slots_[leaf]);
    now = rect;
  }

  void takeSpans(std::uint32_t leaf, TileRect rect, std::span<const ColumnSpan> spans) {
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

  /// Those with spans were noted before others between them.
  void sortFrom(std::uint32_t leaf) {
    auto from = chunk_.changed.end();
    while (from != chunk_.changed.begin() && std::prev(from)->leaf >= leaf)
      --from;
    const auto isBefore = [](const Changed& a, const Changed& b) { return a.leaf < b.leaf; };
    if (!std::is_sorted(from, chunk_.changed.end(), isBefore))
      std::sort(from, chunk_.changed.end(), isBefore);
  }

  FootprintTable& table_;
  Chunk& chunk_;
  const BoxTree& tree_;
  const Kernels& kernels_;
  KernelFrame frame_, nodeFrame_;
  KernelDrift drift_;
  bool refines_;
  Outliner outliner_;
  OrientedBlock gathered_;
  std::array<std::uint32_t, 128> pending_;
  std::size_t pendingCount_ = 0;
};

void ReuseJudge::certified(std::uint64_t looked, std::uint64_t all) {
  // Measured: a leaf that is fetched by itself costs about three that lie side by side; to check one that
  // holds, a sixteenth.
  if (3 * looked + all / 16 <= plainLooked_) {
    nextPause_ = kShortestPause;
  } else {
    pause_ = nextPause_;
    nextPause_ = std::min(2 * nextPause_, kLongestPause);
  }
}

void ReuseJudge::plain(std::uint64_t looked) {
  plainLooked_ = std::max<std::uint64_t>(looked, 1);
  pause_ -= pause_ > 0 ? 1 : 0;
}

void FootprintTable::expire(std::span<const std::uint32_t> leaves) {
  if (!certifies_) return;
  for (const std::uint32_t leaf : leaves)
    expiries_[leaf / kLanes].columnUntil[leaf % kLanes] = -std::numeric_limits<float>::infinity();
}

void FootprintTable::rebase() {
  const KernelDrift drift = roundedUp(drift_);
  for (BlockExpiry& block : expiries_) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const float reach = block.reach[lane], rounding = kCheckRounding * (reach + 1);
      block.columnUntil[lane] -= reach * drift.columnTurn + drift.columnTravel + rounding;
      block.rowUntil[lane] -= reach * drift.rowTurn + drift.rowTravel + rounding;
    }
  }
  drift_.rebase();
}

void FootprintTable::update(const ObjectHierarchy& oh, BoxTree& tree, const GridCoordinates& grid,
                            bool refines, Reuse reuse, unsigned threads) {
  const std::size_t blocks = tree.leaves().size();
  const bool mayHold = drift_.advance(grid, tree.scale()) && certifies_;
  const bool wanted = reuse == Reuse::Always || (reuse == Reuse::Measured && judge_.wants());
  const bool certifies = wanted && bordersAreInPlace(grid);
  const bool holds = mayHold && certifies;
  if (certifies) expiries_.resize(blocks);
  if (certifies) tree.keepSingles();
  if (!holds) drift_.rebase();
  const auto updateChunk = [&](std::size_t i) {
    Updater updater(*this, chunks_[i], oh, tree, grid, refines);
    const std::size_t first = i * kChunkBlocks, end = std::min(blocks, first + kChunkBlocks);
    if (holds) {
      updater.updateExpired(first, end);
    } else if (!certifies && !tree.levels().empty()) {
      updater.updateByNodes(first, end);
    } else {
      updater.update(first, end, certifies);
    }
  };
  if (threads < 2 || chunks_.size() < 2) {
    for (std::size_t i = 0; i < chunks_.size(); ++i)
      updateChunk(i);
  } else {
    tbb::parallel_for(std::size_t{0}, chunks_.size(), updateChunk);
  }
  if (holds) {
    judge_.certified(leavesLookedAt(), leafCount_);
    if (drift_.total() > kLongestDrift) rebase();
  } else if (!certifies) {
    judge_.plain(leavesLookedAt());
  }
  certifies_ = certifies;
}

void FootprintTable::list(Result& result) {
  lists_.begin(columns_, rows_);
  const Kernels& kernel = kernels();
  const std::size_t blocks = rects_.size() / kLanes;
  std::array<std::uint16_t, kBatchBlocks> starts;
  LeafRange run = {0, 0};
  TileRect rect = kNoTiles;
  const auto listRun = [&] {
    if (rect == kNoTiles) return;
    if (rect & kSpansFlag) {
      const TileCells cells = unpack(rect);
      const auto rows = static_cast<std::size_t>(cells.lastRow - cells.firstRow + 1);
      for (std::uint32_t leaf = run.first; leaf != run.last; ++leaf)
        lists_.add({leaf, leaf + 1}, cells, {spansOf(leaf), rows});
    } else {
      lists_.add(run, rect);
    }
  };
  for (std::size_t first = 0; first < blocks; first += kBatchBlocks) {
    const std::size_t count = std::min(kBatchBlocks, blocks - first);
    kernel.runs(rects_.data() + first * kLanes, count, starts.data());
    for (std::size_t b = 0; b < count; ++b) {
      for (std::uint32_t left = starts[b]; left != 0; left &= left - 1) {
        const auto leaf = static_cast<std::uint32_t>((first + b) * kLanes) +
                          static_cast<std::uint32_t>(std::countr_zero(left));
        if (rects_[leaf] == rect) continue;  // goes on from the block before
        run.last = leaf;
        listRun();
        run.first = leaf;
        rect = rects_[leaf];
      }
    }
  }
  run.last = leafCount_;
  listRun();
  for (std::size_t tile = 0; tile < result.lists.size(); ++tile) {
    const std::span<const LeafRange> list = lists_.list(tile);
    result.lists[tile].assign(list.begin(), list.end());
  }
  result.pairs = lists_.pairs();
  result.tests.nodes = leavesLookedAt();
}

std::uint64_t FootprintTable::leavesLookedAt() const {
  std::uint64_t leaves = 0;
  for (const Chunk& chunk : chunks_)
    leaves += chunk.leaves;
  return leaves;
}

void FootprintTable::list(std::uint32_t tile, VisibleList& out) const {
  out.clear();
  const int row = static_cast<int>(tile) / columns_, column = static_cast<int>(tile) % columns_;
  for (std::uint32_t leaf = 0; leaf < leafCount_; ++leaf) {
    const ColumnSpan span = spanIn(row, unpack(rects_[leaf]), spansOf(leaf));
    if (span.first <= column && column <= span.last) appendRange(out, {leaf, leaf + 1});
  }
}

void FootprintTable::changes(Changes& changes) {
  for (const std::uint32_t tile : toggles_.touched()) {
    if (tile < changes.toggled.size()) changes.toggled[tile].clear();
  }
  toggles_.begin(columns_, rows_);
  changes.tests.nodes = leavesLookedAt();
  for (const Chunk& chunk : chunks_) {
    for (const Changed& changed : chunk.changed) {
      const LeafRange leaf = {changed.leaf, changed.leaf + 1};
      const TileCells before = unpack(changed.before), now = unpack(rects_[changed.leaf]);
      const ColumnSpan* spansBefore =
          changed.before & kSpansFlag ? chunk.spansBefore.data() + changed.spansBefore : nullptr;
      const ColumnSpan* spansNow = spansOf(changed.leaf);
      const int firstRow = before.empty() ? now.firstRow
                           : now.empty()  ? before.firstRow
                                          : std::min(before.firstRow, now.firstRow);
      const int lastRow = std::max(before.lastRow, now.lastRow);
      for (int row = firstRow; row <= lastRow; ++row) {
        const ColumnSpan was = spanIn(row, before, spansBefore), is = spanIn(row, now, spansNow);
        if (was == is) continue;
        const int first = was.first > was.last ? is.first
                          : is.first > is.last ? was.first
                                               : std::min(was.first, is.first);
        const int last = std::max(was.last, is.last);
        for (int column = first; column <= last; ++column) {
          const bool wasIn = was.first <= column && column <= was.last;
          const bool isIn = is.first <= column && column <= is.last;
          if (wasIn == isIn) continue;
          const auto tile = static_cast<std::size_t>(row * columns_ + column);
          toggles_.add(leaf, tile);
          changes.leafCounts[tile] += isIn ? 1U : ~0U;
          changes.pairs += isIn ? 1U : ~std::uint64_t{0};
        }
      }
    }
  }
  for (const std::uint32_t tile : toggles_.touched()) {
    const std::span<const LeafRange> list = toggles_.list(tile);
    changes.toggled[tile].assign(list.begin(), list.end());
  }
}

}  // namespace tessera::cull
