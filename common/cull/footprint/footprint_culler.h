#pragma once

#include <cstdint>
#include <memory>

#include "common/cull/footprint/box_blocks.h"
#include "common/cull/footprint/footprint_table.h"
#include "common/cull/footprint/tree_walk.h"
#include "common/cull/options.h"
#include "common/cull/result.h"
#include "common/hierarchy/frustum_hierarchy.h"

namespace tessera::cull {

/// The boxes of a scene as footprints read them; several cullers of one scene may share them, one after the
/// other.
class SharedBoxes {
 public:
  SharedBoxes(const ObjectHierarchy& oh, BoundsKind bounds) : oh_(&oh), bounds_(bounds) {}
  /// As the hierarchy is now.
  BoxTree& upToDate();

 private:
  const ObjectHierarchy* oh_;
  BoundsKind bounds_;
  BoxTree tree_;
  std::uint64_t revision_ = 0;
  bool isBuilt_ = false;
};

/// Culls by footprints on a uniform grid of tiles: for a grid that one eye sees, the tiles that a box may
/// meet are an interval of columns times one of rows. Table and tree give the same lists.
class FootprintCuller {
 public:
  FootprintCuller(const ObjectHierarchy& oh, const Options& options, std::shared_ptr<SharedBoxes> boxes);
  [[nodiscard]] const std::shared_ptr<SharedBoxes>& boxes() const { return boxes_; }

  /// Whether footprints tell the tiles of these frusta: a grid of at most kMostCells columns and rows, and
  /// directions that floats tell apart well within a tile.
  [[nodiscard]] static bool suits(const FrustumHierarchy& frusta);

  /// Whole lists, by the tree or the table.
  void listByTree(const GridCoordinates& grid, Result& result);
  void listByTable(const GridCoordinates& grid, Result& result);

  /// By the table: what changed since the last call of changesByTable or listByTable.
  void changesByTable(const GridCoordinates& grid, Changes& changes);
  /// Of the table.
  void listOf(std::uint32_t tile, VisibleList& out) const { table_.list(tile, out); }
  /// Whether the table is of that grid.
  [[nodiscard]] bool tableFits(const GridCoordinates& grid) const {
    return hasTable_ && table_.fits(boxes_->upToDate(), grid);
  }

 private:
  BoxTree& prepare();
  void updateTable(const GridCoordinates& grid);
  [[nodiscard]] unsigned threads() const;

  const ObjectHierarchy* oh_;
  Options options_;
  std::shared_ptr<SharedBoxes> boxes_;
  std::uint64_t revision_ = 0;  ///< of the hierarchy that the table knows
  bool hasTable_ = false;
  FootprintTable table_;
  TreeWalk walk_;
};

}  // namespace tessera::cull
