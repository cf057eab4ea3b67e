#include "server/bench/cull_table.h"

#include <algorithm>
#include <list>
#include <string>

#include "common/hierarchy/grid_frusta.h"
#include "common/hierarchy/spatial_hierarchy.h"
#include "server/bench/audit.h"

namespace tessera::bench {

namespace {

using cull::Algorithm;
using cull::BoundsKind;
using Candidates = std::vector<InterleavedCull::Candidate>;

Candidates candidatesOn(const ObjectHierarchy& graph) {
  Candidates all;
  // The first is the base of the ratios.
  all.push_back({"adaptive obb", &graph, {}});
  for (const Algorithm algorithm :
       {Algorithm::Naive, Algorithm::Oh, Algorithm::Fh, Algorithm::AdaptiveListing}) {
    all.push_back({std::string(cull::nameOf(algorithm)) + " obb", &graph, {.algorithm = algorithm}});
  }
  for (const BoundsKind bounds : {BoundsKind::Sphere, BoundsKind::Aabb, BoundsKind::AabbThenObb})
    all.push_back({"adaptive " + std::string(cull::nameOf(bounds)), &graph, {.bounds = bounds}});
  all.push_back({"adaptive obb regroup", &graph, {.switches = {.regroup = true}}});
  return all;
}

ObjectHierarchy spatial(const Scene& scene, HierarchyKind kind) {
  std::vector<Bounds> bounds;
  std::vector<std::uint64_t> triangles;
  for (std::uint32_t leaf = 0; leaf < scene.leaves.size(); ++leaf) {
    const std::uint32_t node = scene.hierarchy.nodeOfLeaf(leaf);
    bounds.push_back({scene.hierarchy.aabb(node), scene.hierarchy.obb(node), scene.hierarchy.sphere(node)});
    triangles.push_back(scene.leaves[leaf].triangles);
  }
  return buildSpatialHierarchy(kind, bounds, triangles, 0).hierarchy;
}

double percentOver(double pairs, double exact) {
  return exact > 0 ? 100 * (pairs / exact - 1) : 0;
}

}  // namespace

Result<Json> cullTable(const Scene& scene, const Wall& wall, const CameraPath& path,
                       const CullTableOptions& options) {
  Candidates candidates = candidatesOn(scene.hierarchy);
  std::list<ObjectHierarchy> built;
  if (options.withHierarchies) {
    for (const HierarchyKind kind :
         {HierarchyKind::Bvh, HierarchyKind::Octree, HierarchyKind::LooseOctree, HierarchyKind::Kd}) {
      built.push_back(spatial(scene, kind));
      candidates.push_back({"adaptive obb " + std::string(nameOf(kind)), &built.back(), {}});
    }
  }
  const Walk walk(wall, path, scene.sphere(), options.frames);
  GridFrusta frusta(static_cast<std::uint16_t>(wall.columns), static_cast<std::uint16_t>(wall.rows));
  InterleavedCull interleaved(candidates);
  Samples frustaUs;
  Audit audit(scene);
  std::vector<double> auditedPairs(candidates.size(), 0);
  const std::uint64_t every = options.auditedFrames == 0
                                  ? options.frames + 1
                                  : std::max<std::uint64_t>(1, options.frames / options.auditedFrames);
  for (std::uint64_t frame = 0; frame < walk.frames(); ++frame) {
    const WallView view = walk.view(frame);
    frusta.update(view.wall, view.tiles);
    interleaved.frame(frusta);
    if ((frame + 1) % every != 0) continue;
    for (std::size_t i = 0; i < candidates.size(); ++i)
      auditedPairs[i] += interleaved.measured()[i].pairs.values.back();
    cull::Culler judged(scene.hierarchy, {});
    if (Status status = audit.add(frame, view, judged.cull(frusta)); !status) return status.error();
  }
  if (audit.drops() > 0)
    return runtimeError(scene.source, "a visible leaf is missing: " + audit.firstDrop(), "this is a bug");

  Json table = {{"scene", scene.source},
                {"leaves", scene.leaves.size()},
                {"wall", wall.source},
                {"tiles", wall.tiles.size()},
                {"frames", options.frames},
                {"camera_step", stepOf(walk)},
                {"audited_exact_pairs", audit.exactPairs()},
                {"audited_drops", audit.drops()},
                {"candidates", Json::array()}};
  const auto& measured = interleaved.measured();
  for (std::size_t i = 0; i < measured.size(); ++i) {
    Json entry = summaryOf(measured[i], &measured[0].us);
    if (audit.exactPairs() > 0)
      entry["excess_percent"] = percentOver(auditedPairs[i], static_cast<double>(audit.exactPairs()));
    table["candidates"].push_back(std::move(entry));
  }
  return table;
}

}  // namespace tessera::bench
