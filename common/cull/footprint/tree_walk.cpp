#include "common/cull/footprint/tree_walk.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include <tbb/parallel_for.h>

#include "common/cull/footprint/outline.h"

namespace tessera::cull {

namespace {

/// A single tree's walk, in the order of the leaves.
class Walk {
 public:
  Walk(const ObjectHierarchy& oh, const BoxTree& tree, const GridCoordinates& grid, bool refines,
       RangeLists& lists)
      : tree_(tree),
        kernels_(kernels()),
        leafFrame_(KernelFrame::forLeaves(grid, tree.scale())),
        nodeFrame_(KernelFrame::forNodes(grid, tree.scale())),
        outliner_(oh, tree, grid, refines),
        lists_(lists) {
    lists_.begin(grid.columns, grid.rows);
  }

  /// The nodes of one block of a level; at most 8 levels deep.
  void openNodes(std::size_t level, std::uint32_t block) {
    ++blocks_;
    NodeFootprints found;
    kernels_.nodes(nodeFrame_, tree_.levels()[level].blocks[block], found);
    const std::uint32_t first = static_cast<std::uint32_t>(block * kLanes);
    const std::uint32_t end = std::min<std::uint32_t>(kLanes, tree_.levels()[level].nodeCount - first);
    for (std::uint32_t lane = 0; lane < end; ++lane) {
      const std::uint32_t bit = 1U << lane;
      if (found.contained & bit) {
        lists_.add(leavesBelow(level, first + lane), found.rects[lane]);
      } else if (found.rects[lane] != kNoTiles || (found.unknown & bit)) {
        if (level == 0) prefetch(first + lane + 1);
        open(level, first + lane);
      }
    }
  }
  /// What is below a node of a level.
  void open(std::size_t level, std::uint32_t node) {
    if (level > 0) {
      openNodes(level - 1, node);
    } else {
      openLeaves(node);
    }
  }
  void openLeaves(std::uint32_t block) {
    ++blocks_;
    TileRect rects[kLanes];
    BlockLanes lanes;
    kernels_.leaves(leafFrame_, &tree_.leaves()[block], 1, rects, &lanes);
    const std::uint32_t first = static_cast<std::uint32_t>(block * kLanes);
    const std::uint32_t count = std::min<std::uint32_t>(kLanes, tree_.leafCount() - first);
    std::array<std::uint32_t, kLanes> ids;
    std::iota(ids.begin(), ids.end(), first);
    std::uint32_t next = 0;
    std::uint16_t runs = 0;
    kernels_.runs(rects, 1, &runs);
    const std::uint32_t starts = runs | std::uint32_t{lanes.open} | std::uint32_t{lanes.open} << 1;
    const auto listUpTo = [&](std::uint32_t lane) {
      while (next < lane) {
        const std::uint32_t later = (starts | 1U << lane) & ~((2U << next) - 1);
        const std::uint32_t end = std::min(static_cast<std::uint32_t>(std::countr_zero(later)), lane);
        if (rects[next] != kNoTiles) lists_.add({first + next, first + end}, rects[next]);
        next = end;
      }
    };
    outliner_.finish({ids.data(), count}, lanes, rects,
                     [&](std::uint32_t lane, std::span<const ColumnSpan> spans) {
                       listUpTo(lane);
                       lists_.add({first + lane, first + lane + 1}, unpack(rects[lane]), spans);
                       next = lane + 1;
                     });
    listUpTo(count);
  }

  [[nodiscard]] std::uint64_t blocks() const { return blocks_; }

 private:
  /// A block of leaves is a thousand bytes from anywhere: fetched while the one before is looked at.
  void prefetch(std::uint32_t block) const {
    if (block >= tree_.leaves().size()) return;
    const auto* bytes = reinterpret_cast<const char*>(&tree_.leaves()[block]);
    for (std::size_t line = 0; line < sizeof(OrientedBlock); line += 64)
      __builtin_prefetch(bytes + line);
  }
  [[nodiscard]] LeafRange leavesBelow(std::size_t level, std::uint32_t node) const {
    std::uint64_t leaves = kLanes;
    for (std::size_t i = 0; i < level; ++i)
      leaves *= kLanes;
    return {static_cast<std::uint32_t>(node * leaves),
            static_cast<std::uint32_t>(std::min<std::uint64_t>((node + 1) * leaves, tree_.leafCount()))};
  }

  const BoxTree& tree_;
  const Kernels& kernels_;
  KernelFrame leafFrame_, nodeFrame_;
  Outliner outliner_;
  RangeLists& lists_;
  std::uint64_t blocks_ = 0;
};

/// Appends a list whose leaves come after all of `list`, or replaces that.
void append(VisibleList& list, std::span<const LeafRange> more, bool replaces) {
  if (replaces) {
    list.assign(more.begin(), more.end());
  } else if (!more.empty()) {
    appendRange(list, more.front());
    list.insert(list.end(), more.begin() + 1, more.end());
  }
}

}  // namespace

void TreeWalk::list(const ObjectHierarchy& oh, const BoxTree& tree, const GridCoordinates& grid, bool refines,
                    unsigned threads, Result& result) {
  const auto& levels = tree.levels();
  // A level with enough nodes to share out evenly.
  std::size_t level = levels.size();
  while (level > 0 && levels[level - 1].nodeCount < 16 * threads)
    --level;
  const bool isOne = threads < 2 || level == 0;
  const std::size_t blocks = isOne ? 1 : levels[level - 1].blocks.size();
  const std::size_t partCount = isOne ? 1 : std::min<std::size_t>(blocks, 8 * threads);
  if (parts_.size() < partCount) parts_.resize(partCount);
  const auto walkPart = [&](std::size_t i) {
    Walk walk(oh, tree, grid, refines, parts_[i].lists);
    if (levels.empty()) {
      walk.openLeaves(0);
    } else if (isOne) {
      walk.openNodes(levels.size() - 1, 0);
    } else {
      for (std::size_t block = blocks * i / partCount; block < blocks * (i + 1) / partCount; ++block)
        walk.openNodes(level - 1, static_cast<std::uint32_t>(block));
    }
    parts_[i].blocks = walk.blocks();
  };
  if (isOne) {
    walkPart(0);
  } else {
    tbb::parallel_for(std::size_t{0}, partCount, walkPart);
  }
  result.pairs = result.tests.nodes = 0;
  for (std::size_t i = 0; i < partCount; ++i) {
    const Part& part = parts_[i];
    result.pairs += part.lists.pairs();
    result.tests.nodes += part.blocks;
    for (std::size_t tile = 0; tile < result.lists.size(); ++tile)
      append(result.lists[tile], part.lists.list(tile), i == 0);
  }
}

}  // namespace tessera::cull
