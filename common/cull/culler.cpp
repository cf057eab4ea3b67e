#include "common/cull/culler.h"

#include <cstdlib>
#include <utility>

#include "common/cull/bounds_view.h"
#include "common/cull/footprint/footprint_culler.h"
#include "common/cull/methods/adaptive.h"
#include "common/cull/methods/adaptive_listing.h"
#include "common/cull/methods/fh.h"
#include "common/cull/methods/naive.h"
#include "common/cull/methods/oh.h"
#include "common/cull/workspace.h"

namespace tessera::cull {

namespace {

template <class View>
void run(const Context& context) {
  switch (context.options.algorithm) {
    case Algorithm::None:
      for (std::uint32_t tile = 0; tile < context.frusta.tileCount(); ++tile)
        context.emit(tile, 0);
      break;
    case Algorithm::Naive:
      return cullNaive<View>(context);
    case Algorithm::Oh:
      return cullOh<View>(context);
    case Algorithm::Fh:
      return cullFh<View>(context);
    case Algorithm::Adaptive:
      return cullAdaptive<View>(context);
    case Algorithm::AdaptiveListing:
      return cullAdaptiveListing<View>(context);
    case Algorithm::Footprint:
    case Algorithm::Table:
    case Algorithm::Auto:
      break;  // not by planes
  }
}

template <class View>
void runMaybeSphereFirst(const Context& context) {
  if (context.switches().sphereFirst) return run<FirstThen<SphereView, View>>(context);
  run<View>(context);
}

void runWithBounds(const Context& context) {
  switch (context.options.bounds) {
    case BoundsKind::Sphere:
      return run<SphereView>(context);
    case BoundsKind::Aabb:
      if (context.switches().signTable) return run<AabbCornersView>(context);
      return runMaybeSphereFirst<AabbView>(context);
    case BoundsKind::Obb:
      return runMaybeSphereFirst<ObbView>(context);
    case BoundsKind::Hybrid:
      return runMaybeSphereFirst<HybridView>(context);
    case BoundsKind::AabbThenObb:
      return run<FirstThen<AabbView, ObbView>>(context);
  }
}

/// Up to here changes come faster from a table of all leaves than from two frames' lists by the tree.
constexpr std::uint32_t kMostTableLeaves = 20'000;

/// Footprints are of boxes.
bool mayUseFootprints(const Options& options) {
  const bool isNamed = options.algorithm == Algorithm::Footprint || options.algorithm == Algorithm::Table ||
                       options.algorithm == Algorithm::Auto;
  return isNamed && !concernsPlanes(options.switches) && options.bounds != BoundsKind::Sphere &&
         options.bounds != BoundsKind::AabbThenObb;
}

}  // namespace

Culler::Culler(const ObjectHierarchy& scene, const Options& options)
    : Culler(scene, options, static_cast<const FootprintCuller*>(nullptr)) {}
Culler::Culler(const ObjectHierarchy& scene, const Options& options, const Culler& sharing)
    : Culler(scene, options, sharing.footprints_.get()) {
  if (sharing.scene_ != &scene || sharing.options_.bounds != options.bounds) std::abort();
}
Culler::Culler(const ObjectHierarchy& scene, const Options& options, const FootprintCuller* sharing)
    : scene_(&scene), options_(options), workspace_(std::make_unique<Workspace>()) {
  if (!check(options)) std::abort();
  if (mayUseFootprints(options))
    footprints_ = std::make_unique<FootprintCuller>(scene, options, sharing ? sharing->boxes() : nullptr);
}
Culler::~Culler() = default;
Culler::Culler(Culler&&) noexcept = default;
Culler& Culler::operator=(Culler&&) noexcept = default;

void Culler::pick(const FrustumHierarchy& frusta, bool forChanges) {
  picked_ = options_.algorithm;
  const bool wantsFootprints =
      picked_ == Algorithm::Footprint || picked_ == Algorithm::Table || picked_ == Algorithm::Auto;
  if (!wantsFootprints) return;
  if (readsPlanes(frusta)) {
    picked_ = Algorithm::Adaptive;
  } else if (picked_ == Algorithm::Auto) {
    // The table's own changes know nothing of absent leaves.
    const bool suitsTable = scene_->leafCount() <= kMostTableLeaves && scene_->absentLeaves().empty();
    picked_ = forChanges && suitsTable ? Algorithm::Table : Algorithm::Footprint;
  }
}

void Culler::cullByPlanes(const FrustumHierarchy& frusta) {
  if (scene_->empty()) return;
  Options options = options_;
  options.algorithm = picked_;
  const bool testsTiles = picked_ == Algorithm::Naive || picked_ == Algorithm::Oh;
  workspace_->tester.beginFrame(*scene_, frusta, options.switches, testsTiles);
  runWithBounds({*scene_, frusta, options, *workspace_});
  finishLists(*workspace_);
  for (const VisibleList& list : workspace_->result.lists)
    workspace_->result.pairs += leafCount(list);
}

/// Culls to `result`, by what was picked.
void Culler::listAll(const FrustumHierarchy& frusta) {
  Result& result = workspace_->result;
  result.lists.resize(frusta.tileCount());
  for (VisibleList& list : result.lists)
    list.clear();
  result.tests = {};
  result.pairs = 0;
  if (picked_ == Algorithm::Table) {
    footprints_->listByTable(*frusta.grid(), result);
  } else if (picked_ == Algorithm::Footprint) {
    footprints_->listByTree(*frusta.grid(), result);
  } else {
    cullByPlanes(frusta);
  }
  takeAbsentOut();
  workspace_->tileCount = frusta.tileCount();
  workspace_->holdsLists = true;
  workspace_->holdsTable = picked_ == Algorithm::Table;
}

/// Absent leaves keep their bounds, so that all algorithms list them as if they were there.
void Culler::takeAbsentOut() {
  Workspace& work = *workspace_;
  work.isThinned = !scene_->absentLeaves().empty();
  if (!work.isThinned) return;
  work.result.pairs = 0;
  for (VisibleList& list : work.result.lists) {
    differenceInto(list, scene_->absentLeaves(), work.thinned);
    std::swap(list, work.thinned);
    work.result.pairs += leafCount(list);
  }
}

bool Culler::readsPlanes(const FrustumHierarchy& frusta) const {
  return !footprints_ || scene_->empty() || !FootprintCuller::suits(frusta);
}

const Result& Culler::cull(const FrustumHierarchy& frusta) {
  pick(frusta, false);
  listAll(frusta);
  return workspace_->result;
}

/// Makes `listsBefore` of what the last call left, whichever form that has.
void Culler::listBeforeFrom(const FrustumHierarchy& frusta) {
  Workspace& work = *workspace_;
  if (work.tileCount != frusta.tileCount()) {
    work.listsBefore.assign(frusta.tileCount(), {});
  } else if (work.holdsLists) {
    std::swap(work.result.lists, work.listsBefore);
  } else {
    work.listsBefore.resize(frusta.tileCount());
    for (std::uint32_t tile = 0; tile < frusta.tileCount(); ++tile)
      footprints_->listOf(tile, work.listsBefore[tile]);
  }
}

const Changes& Culler::cullChanges(const FrustumHierarchy& frusta) {
  Workspace& work = *workspace_;
  Changes& changes = work.changes;
  pick(frusta, true);
  changes.tests = {};
  changes.toggled.resize(frusta.tileCount());
  changes.leafCounts.resize(frusta.tileCount());
  const bool isNew = work.tileCount != frusta.tileCount();
  const bool thins = work.isThinned || !scene_->absentLeaves().empty();
  if (picked_ == Algorithm::Table && !thins && footprints_->tableFits(*frusta.grid()) && !isNew &&
      work.holdsTable) {
    if (work.holdsLists) {
      for (std::uint32_t tile = 0; tile < frusta.tileCount(); ++tile)
        changes.leafCounts[tile] = static_cast<std::uint32_t>(leafCount(work.result.lists[tile]));
      changes.pairs = work.result.pairs;
    }
    if (!work.togglesAreTables) {
      for (VisibleList& list : changes.toggled)
        list.clear();
    }
    footprints_->changesByTable(*frusta.grid(), changes);
    work.togglesAreTables = true;
    work.holdsLists = false;
    return changes;
  }
  work.togglesAreTables = false;
  listBeforeFrom(frusta);
  listAll(frusta);
  for (std::uint32_t tile = 0; tile < frusta.tileCount(); ++tile) {
    symmetricDifferenceInto(work.listsBefore[tile], work.result.lists[tile], changes.toggled[tile]);
    changes.leafCounts[tile] = static_cast<std::uint32_t>(leafCount(work.result.lists[tile]));
  }
  changes.tests = work.result.tests;
  changes.pairs = work.result.pairs;
  return changes;
}

void Culler::listOf(std::uint32_t tile, VisibleList& out) const {
  if (workspace_->holdsLists) {
    out = workspace_->result.lists[tile];
  } else {
    footprints_->listOf(tile, out);
  }
}

}  // namespace tessera::cull
