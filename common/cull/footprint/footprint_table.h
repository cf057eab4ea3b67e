#pragma once

#include <cstdint>
#include <vector>

#include "common/cull/footprint/box_blocks.h"
#include "common/cull/footprint/kernels.h"
#include "common/cull/result.h"

namespace tessera::cull {

/// The footprints of all leaves of the last frame, one packed rectangle each (Algorithm::Table), and what the
/// next frame changes in them.
class FootprintTable {
 public:
  /// Forgets everything: all leaves are nowhere.
  void reset(const BoxTree& tree, const GridCoordinates& grid);
  /// Whether it holds that scene's leaves on that grid.
  [[nodiscard]] bool fits(const BoxTree& tree, const GridCoordinates& grid) const {
    return leafCount_ == tree.leafCount() && columns_ == grid.columns && rows_ == grid.rows;
  }

  /// Moves the table to this frame. `threads` >= 1.
  void update(const ObjectHierarchy& oh, const BoxTree& tree, const GridCoordinates& grid, bool refines,
              unsigned threads);

  /// Writes the lists out. `result.lists` has a list for each tile, all empty.
  void list(Result& result) const;
  /// One tile's list.
  void list(std::uint32_t tile, VisibleList& out) const;
  /// What the last update changed. `changes` has counts of the frame before, and empty lists.
  void changes(Changes& changes) const;

 private:
  /// A footprint that the last update changed, as it was.
  struct Changed {
    std::uint32_t leaf;
    TileRect before;
    std::uint32_t spansBefore;  ///< of the chunk's spansBefore, where `before` has spans
  };
  /// Blocks of leaves that one task looks after.
  struct Chunk {
    std::vector<Changed> changed;
    std::vector<ColumnSpan> spansBefore;
    std::vector<ColumnSpan> spans;         ///< slots of `rows` spans each
    std::vector<std::uint32_t> freeSlots;
    std::uint64_t blocks = 0;              ///< looked at in the last update
  };
  class Updater;

  [[nodiscard]] std::uint64_t blocksLookedAt() const;
  [[nodiscard]] const ColumnSpan* spansOf(std::uint32_t leaf) const;

  static constexpr std::size_t kChunkBlocks = 512;
  std::uint32_t leafCount_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<TileRect> rects_;      ///< by leaf, filled up to whole blocks
  std::vector<std::uint32_t> slots_;  ///< by leaf, of its chunk; of those with spans
  std::vector<Chunk> chunks_;
};

}  // namespace tessera::cull
