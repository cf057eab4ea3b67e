#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/cull/footprint/box_blocks.h"
#include "common/cull/footprint/camera_drift.h"
#include "common/cull/footprint/kernels.h"
#include "common/cull/footprint/range_lists.h"
#include "common/cull/result.h"

namespace tessera::cull {

/// Tells whether reuse pays, for Reuse::Measured. It counts leaves, not time, so that runs repeat; the lists
/// are the same either way.
class ReuseJudge {
 public:
  /// Whether the next frame is to be certified.
  [[nodiscard]] bool wants() const { return plainLooked_ > 0 && pause_ == 0; }
  /// After a frame with certificates of the one before: how many of how many leaves were looked at.
  void certified(std::uint64_t looked, std::uint64_t all);
  /// After a frame without, by way of the boxes above the leaves.
  void plain(std::uint64_t looked);

 private:
  std::uint64_t plainLooked_ = 0;
  unsigned pause_ = 0, nextPause_ = kShortestPause;
  /// Frames without certificates, after one in which they did not pay: a first frame of them looks at every
  /// leaf.
  static constexpr unsigned kShortestPause = 32, kLongestPause = 512;
};

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

  /// Moves the table to this frame. `threads` >= 1. `reuse`: blocks whose footprints certainly hold are left
  /// as they are; the table is the same.
  void update(const ObjectHierarchy& oh, BoxTree& tree, const GridCoordinates& grid, bool refines,
              Reuse reuse, unsigned threads);
  /// The boxes of some leaves have changed, or of all: their footprints hold no longer.
  void expire(std::span<const std::uint32_t> leaves);
  void expireAll() { certifies_ = false; }

  /// Writes the lists out, and the counts of leaves looked at and of pairs.
  void list(Result& result);
  /// One tile's list.
  void list(std::uint32_t tile, VisibleList& out) const;
  /// What the last update changed. `changes` has the counts of the frame before, and lists that are empty but
  /// for those that the last call filled.
  void changes(Changes& changes);

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
    std::vector<ColumnSpan> spans;  ///< slots of `rows` spans each
    std::vector<std::uint32_t> freeSlots;
    std::uint64_t leaves = 0;  ///< looked at in the last update
  };
  class Updater;

  /// Counts the camera's drift from here.
  void rebase();
  [[nodiscard]] std::uint64_t leavesLookedAt() const;
  [[nodiscard]] const ColumnSpan* spansOf(std::uint32_t leaf) const;

  static constexpr std::size_t kChunkBlocks = 256;
  std::uint32_t leafCount_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<TileRect> rects_;       ///< by leaf, filled up to whole blocks
  std::vector<std::uint32_t> slots_;  ///< by leaf, of its chunk; of those with spans
  std::vector<Chunk> chunks_;
  RangeLists lists_, toggles_;

  std::vector<BlockExpiry> expiries_;
  CameraDrift drift_;
  ReuseJudge judge_;
  bool certifies_ = false;  ///< the expiries are of the last frame
};

}  // namespace tessera::cull
