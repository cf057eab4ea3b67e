#include "common/cull/footprint/footprint_culler.h"

#include <algorithm>
#include <span>
#include <thread>

#include "common/hierarchy/frustum_hierarchy.h"

namespace tessera::cull {

namespace {

/// Where the bound of a box at m = 4 zmin is more than that many tiles, double tells better.
constexpr double kMostErrorTiles = 1.0 / 64;
/// Leaves from which two threads beat one.
constexpr std::uint32_t kLeavesForThreads = 50'000;

}  // namespace

FootprintCuller::FootprintCuller(const ObjectHierarchy& oh, const Options& options)
    : oh_(&oh), options_(options) {}

bool FootprintCuller::suits(const FrustumHierarchy& frusta) {
  if (!frusta.grid()) return false;
  const GridCoordinates& grid = *frusta.grid();
  if (grid.columns > kMostCells || grid.rows > kMostCells) return false;
  const KernelFrame frame = KernelFrame::forLeaves(grid, 1);
  return 4 * std::max(frame.columnError, frame.rowError) < kMostErrorTiles;
}

void FootprintCuller::prepare() {
  const std::uint64_t revision = oh_->revision();
  if (isBuilt_ && revision_ == revision) return;
  const std::span<const std::uint32_t> changed = oh_->changedLeaves();
  if (isBuilt_ && revision == revision_ + 1 && changed.size() < oh_->leafCount() / 4) {
    tree_.refit(*oh_, changed);
    table_.expire(changed);
  } else {
    tree_.build(*oh_, options_.bounds);
    table_.expireAll();
  }
  revision_ = revision;
  isBuilt_ = true;
}

unsigned FootprintCuller::threads() const {
  if (options_.threads == 1 || oh_->leafCount() < kLeavesForThreads) return 1;
  return options_.threads > 0 ? options_.threads : std::max(1U, std::thread::hardware_concurrency());
}

void FootprintCuller::listByTree(const GridCoordinates& grid, Result& result) {
  prepare();
  walk_.list(*oh_, tree_, grid, options_.switches.refine, threads(), result);
}

void FootprintCuller::updateTable(const GridCoordinates& grid) {
  prepare();
  if (!hasTable_ || !table_.fits(tree_, grid)) table_.reset(tree_, grid);
  hasTable_ = true;
  table_.update(*oh_, tree_, grid, options_.switches.refine, options_.switches.coherent, threads());
}

void FootprintCuller::listByTable(const GridCoordinates& grid, Result& result) {
  updateTable(grid);
  table_.list(result);
}

void FootprintCuller::changesByTable(const GridCoordinates& grid, Changes& changes) {
  updateTable(grid);
  table_.changes(changes);
}

}  // namespace tessera::cull
