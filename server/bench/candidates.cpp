#include "server/bench/candidates.h"

#include <algorithm>
#include <utility>

namespace tessera::bench {

namespace {

using cull::Algorithm;
using cull::BoundsKind;
using cull::Reuse;
using Kind = CandidateSpec::Kind;

class SpecList {
 public:
  void add(std::string name, const cull::Options& options, Output output = Output::Ranges) {
    specs.push_back({.name = std::move(name), .options = options, .output = output});
    if (specs.back().options.threads == 0) specs.back().options.threads = 1;
  }
  void addOutputs(const std::string& name, const cull::Options& options,
                  std::initializer_list<Output> outputs) {
    for (const Output output : outputs)
      add(name + " " + std::string(nameOf(output)), options, output);
  }
  std::vector<CandidateSpec> specs;
};

void addPlaneCullers(SpecList& list) {
  list.add(kBaseName, {});
  for (const Algorithm algorithm :
       {Algorithm::Naive, Algorithm::Oh, Algorithm::Fh, Algorithm::AdaptiveListing}) {
    list.add(std::string(cull::nameOf(algorithm)) + " obb", {.algorithm = algorithm});
  }
  for (const BoundsKind bounds : {BoundsKind::Sphere, BoundsKind::Aabb, BoundsKind::AabbThenObb})
    list.add("adaptive " + std::string(cull::nameOf(bounds)), {.bounds = bounds});
  list.add("adaptive obb regroup", {.switches = {.regroup = true}});
}

void addGridCullers(SpecList& list) {
  const auto options = [](Algorithm algorithm, Reuse coherent, bool refine = true) {
    return cull::Options{.algorithm = algorithm, .switches = {.refine = refine, .coherent = coherent}};
  };
  constexpr auto kRanges = Output::Ranges, kIds = Output::Ids, kDiff = Output::Diff;
  list.addOutputs("footprint obb", options(Algorithm::Footprint, Reuse::Never), {kRanges, kIds, kDiff});
  list.addOutputs("footprint obb no-refine", options(Algorithm::Footprint, Reuse::Never, false), {kRanges});
  list.addOutputs("table obb", options(Algorithm::Table, Reuse::Never), {kRanges, kIds, kDiff});
  list.addOutputs("table obb no-refine", options(Algorithm::Table, Reuse::Never, false), {kRanges, kDiff});
  list.addOutputs("table obb coherent-always", options(Algorithm::Table, Reuse::Always), {kDiff});
  list.addOutputs("table obb coherent-measured", options(Algorithm::Table, Reuse::Measured), {kDiff});
  // The product's defaults, but for the threads of the first ones.
  list.addOutputs("auto obb", options(Algorithm::Auto, Reuse::Measured), {kRanges, kIds, kDiff});
  list.addOutputs("auto obb all-threads", options(Algorithm::Auto, Reuse::Measured), {kRanges, kDiff});
  for (CandidateSpec& spec : list.specs) {
    if (spec.name.starts_with("auto obb all-threads")) spec.options.threads = 0;
  }
}

std::vector<CandidateSpec> allCandidates(bool withHierarchies) {
  SpecList list;
  addPlaneCullers(list);
  if (withHierarchies) {
    for (const HierarchyKind kind :
         {HierarchyKind::Bvh, HierarchyKind::Octree, HierarchyKind::LooseOctree, HierarchyKind::Kd}) {
      list.add(std::string(kBaseName) + " " + std::string(nameOf(kind)), {});
      list.specs.back().hierarchy = kind;
    }
  }
  addGridCullers(list);
  for (const auto& [name, kind] :
       {std::pair{"osg full", Kind::OsgFull}, std::pair{"osg traversal-only", Kind::OsgTraversal},
        std::pair{kLinearName, Kind::LinearRead}}) {
    list.specs.push_back({.name = name, .kind = kind, .output = Output::Count});
  }
  return std::move(list.specs);
}

SpatialHierarchy spatial(const Scene& scene, HierarchyKind kind) {
  std::vector<Bounds> bounds;
  std::vector<std::uint64_t> triangles;
  for (std::uint32_t leaf = 0; leaf < scene.leaves.size(); ++leaf) {
    const std::uint32_t node = scene.hierarchy.nodeOfLeaf(leaf);
    bounds.push_back({scene.hierarchy.aabb(node), scene.hierarchy.obb(node), scene.hierarchy.sphere(node)});
    triangles.push_back(scene.leaves[leaf].triangles);
  }
  return buildSpatialHierarchy(kind, bounds, triangles, 0);
}

}  // namespace

Result<std::vector<CandidateSpec>> selectCandidates(const std::vector<std::string>& only,
                                                    bool withHierarchies) {
  std::vector<CandidateSpec> all = allCandidates(withHierarchies);
  if (only.empty()) return all;
  std::string names;
  for (const CandidateSpec& spec : all)
    names += (names.empty() ? "\"" : ", \"") + spec.name + "\"";
  for (const std::string& prefix : only) {
    const bool isKnown = std::any_of(all.begin(), all.end(), [&prefix](const CandidateSpec& spec) {
      return spec.name.starts_with(prefix);
    });
    if (!isKnown || prefix.empty())
      return inputError("--only", "no candidate's name begins with \"" + prefix + "\"", "there are " + names);
  }
  std::vector<CandidateSpec> chosen;
  for (CandidateSpec& spec : all) {
    const bool isAsked = std::any_of(only.begin(), only.end(), [&spec](const std::string& prefix) {
      return spec.name.starts_with(prefix);
    });
    if (isAsked || spec.name == kBaseName) chosen.push_back(std::move(spec));
  }
  return chosen;
}

Baseline CandidateSet::baselineOf(CandidateSpec::Kind kind, const Scene& scene) {
  if (kind == Kind::OsgFull) return {[this] { osg_->cullFull(); }, [this] { return osg_->fullPairs(); }};
  if (kind == Kind::OsgTraversal)
    return {[this] { osg_->cullTraversalOnly(); }, [this] { return osg_->traversalPairs(); }};
  return {[this, &scene] { linearSum_ = sumOfObbs(scene.hierarchy); }, [] { return 0; }};
}

void CandidateSet::toGraphIds(std::size_t candidate, std::vector<VisibleList>& lists) const {
  const SpatialHierarchy* spatial = spatial_[candidate];
  if (!spatial) return;
  std::vector<std::uint32_t> leaves;
  for (VisibleList& list : lists) {
    leaves.clear();
    forEachLeaf(list, [&](std::uint32_t leaf) { leaves.push_back(spatial->order[leaf]); });
    std::sort(leaves.begin(), leaves.end());
    list.clear();
    for (const std::uint32_t leaf : leaves)
      appendRange(list, {leaf, leaf + 1});
  }
}

Result<std::unique_ptr<CandidateSet>> CandidateSet::make(const Scene& scene, UpAxis up,
                                                         std::vector<CandidateSpec> specs) {
  std::unique_ptr<CandidateSet> set(new CandidateSet);
  set->specs_ = std::move(specs);
  for (const CandidateSpec& spec : set->specs_) {
    InterleavedCull::Candidate candidate = {
        .name = spec.name, .hierarchy = &scene.hierarchy, .options = spec.options, .output = spec.output};
    set->spatial_.push_back(nullptr);
    if (spec.hierarchy != HierarchyKind::Graph) {
      set->built_.push_back(spatial(scene, spec.hierarchy));
      set->spatial_.back() = &set->built_.back();
      candidate.hierarchy = &set->built_.back().hierarchy;
    }
    if (spec.kind == Kind::OsgFull || spec.kind == Kind::OsgTraversal) {
      if (!set->osg_) {
        auto osg = OsgCullBaseline::read(scene.source, up);
        if (!osg) return osg.error();
        set->osg_.emplace(std::move(*osg));
      }
    }
    if (spec.kind != Kind::Culler) candidate.baseline = set->baselineOf(spec.kind, scene);
    set->candidates_.push_back(std::move(candidate));
  }
  return set;
}

}  // namespace tessera::bench
