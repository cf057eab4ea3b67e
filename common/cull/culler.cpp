#include "common/cull/culler.h"

#include <cstdlib>
#include <utility>

#include "common/cull/bounds_view.h"
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
      return cullAdaptive<View>(context);  // wherever there is no grid
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

}  // namespace

Culler::Culler(const ObjectHierarchy& scene, const Options& options)
    : scene_(&scene), options_(options), workspace_(std::make_unique<Workspace>()) {
  if (!check(options)) std::abort();
}
Culler::~Culler() = default;
Culler::Culler(Culler&&) noexcept = default;
Culler& Culler::operator=(Culler&&) noexcept = default;

void Culler::cullByPlanes(const FrustumHierarchy& frusta) {
  Result& result = workspace_->result;
  result.lists.resize(frusta.tileCount());
  for (VisibleList& list : result.lists)
    list.clear();
  result.tests = {};
  if (!scene_->empty()) {
    const bool testsTiles = options_.algorithm == Algorithm::Naive || options_.algorithm == Algorithm::Oh;
    workspace_->tester.beginFrame(*scene_, frusta, options_.switches, testsTiles);
    runWithBounds({*scene_, frusta, options_, *workspace_});
    finishLists(*workspace_);
  }
  result.pairs = 0;
  for (const VisibleList& list : result.lists)
    result.pairs += leafCount(list);
}

const Result& Culler::cull(const FrustumHierarchy& frusta) {
  cullByPlanes(frusta);
  return workspace_->result;
}

const Changes& Culler::cullChanges(const FrustumHierarchy& frusta) {
  Workspace& work = *workspace_;
  std::swap(work.result.lists, work.listsBefore);
  if (work.listsBefore.size() != frusta.tileCount()) {
    work.listsBefore.assign(frusta.tileCount(), {});
  }
  cullByPlanes(frusta);
  Changes& changes = work.changes;
  changes.toggled.resize(frusta.tileCount());
  changes.leafCounts.resize(frusta.tileCount());
  for (std::uint32_t tile = 0; tile < frusta.tileCount(); ++tile) {
    symmetricDifferenceInto(work.listsBefore[tile], work.result.lists[tile], changes.toggled[tile]);
    changes.leafCounts[tile] = static_cast<std::uint32_t>(leafCount(work.result.lists[tile]));
  }
  changes.tests = work.result.tests;
  changes.pairs = work.result.pairs;
  return changes;
}

void Culler::listOf(std::uint32_t tile, VisibleList& out) const {
  out = workspace_->result.lists[tile];
}

}  // namespace tessera::cull
