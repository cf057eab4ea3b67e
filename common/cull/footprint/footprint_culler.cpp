#include "common/cull/footprint/footprint_culler.h"

#include <algorithm>
#include <span>
#include <thread>
#include <utility>

#include "common/hierarchy/frustum_hierarchy.h"

namespace tessera::cull {

namespace {

/// Where the bound of a box at m = 4 zmin is more than that many tiles, double tells better.
constexpr double kMostErrorTiles = 1.0 / 64;
/// Leaves from which two threads beat one.
constexpr std::uint32_t kLeavesForThreads = 50'000;

/// So few that it is worth to look at them alone.
bool fewChanged(const ObjectHierarchy& oh) {
  return oh.changedLeaves().size() < oh.leafCount() / 4;
}

}  // namespace

BoxTree& SharedBoxes::upToDate() {
  const std::uint64_t revision = oh_->revision();
  if (isBuilt_ && revision_ == revision) return tree_;
  const std::span<const std::uint32_t> changed = oh_->changedLeaves();
  if (isBuilt_ && revision == revision_ + 1 && fewChanged(*oh_)) {
    tree_.refit(*oh_, changed);
  } else {
    tree_.build(*oh_, bounds_);
  }
  revision_ = revision;
  isBuilt_ = true;
  return tree_;
}

FootprintCuller::FootprintCuller(const ObjectHierarchy& oh, const Options& options,
                                 std::shared_ptr<SharedBoxes> boxes)
    : oh_(&oh),
      options_(options),
      boxes_(boxes ? std::move(boxes) : std::make_shared<SharedBoxes>(oh, options.bounds)) {}

bool FootprintCuller::suits(const FrustumHierarchy& frusta) {
  if (!frusta.grid()) return false;
  const GridCoordinates& grid = *frusta.grid();
  if (grid.columns > kMostCells || grid.rows > kMostCells) return false;
  const KernelFrame frame = KernelFrame::forLeaves(grid, 1);
  return 4 * std::max(frame.columnError, frame.rowError) < kMostErrorTiles;
}

BoxTree& FootprintCuller::prepare() {
  BoxTree& tree = boxes_->upToDate();
  const std::uint64_t revision = oh_->revision();
  if (hasTable_ && revision_ != revision) {
    if (revision == revision_ + 1 && fewChanged(*oh_)) {
      table_.expire(oh_->changedLeaves());
    } else {
      table_.expireAll();
    }
  }
  revision_ = revision;
  return tree;
}

unsigned FootprintCuller::threads() const {
  if (options_.threads == 1 || oh_->leafCount() < kLeavesForThreads) return 1;
  return options_.threads > 0 ? options_.threads : std::max(1U, std::thread::hardware_concurrency());
}

void FootprintCuller::listByTree(const GridCoordinates& grid, Result& result) {
  walk_.list(*oh_, prepare(), grid, options_.switches.refine, threads(), result);
}

void FootprintCuller::updateTable(const GridCoordinates& grid) {
  BoxTree& tree = prepare();
  if (!hasTable_ || !table_.fits(tree, grid)) table_.reset(tree, grid);
  hasTable_ = true;
  table_.update(*oh_, tree, grid, options_.switches.refine, options_.switches.coherent, threads());
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
