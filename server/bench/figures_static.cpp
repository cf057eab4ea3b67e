// Figures of culling scenes that stand still.
#include <array>
#include <list>

#include "common/hierarchy/grid_frusta.h"
#include "server/bench/cull_table.h"
#include "server/bench/paper_figures.h"

namespace tessera::bench {

namespace {

using cull::Algorithm;
using cull::BoundsKind;

GridFrusta frustaFor(const Wall& wall) {
  return {static_cast<std::uint16_t>(wall.screens[0].columns),
          static_cast<std::uint16_t>(wall.screens[0].rows)};
}

void follow(const Walk& walk, GridFrusta& frusta, InterleavedCull& interleaved) {
  for (std::uint64_t frame = 0; frame < walk.frames(); ++frame) {
    const WallView view = walk.view(frame);
    frusta.update(view.screens[0], view.tiles);
    interleaved.frame(frusta);
  }
}

Json curvesOf(const InterleavedCull& interleaved, const Samples* base) {
  Json curves = Json::array();
  for (const auto& measured : interleaved.measured()) {
    Json curve = summaryOf(measured, base);
    curve["us_along_walk"] = smoothed(measured.us, 20);
    curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace

Result<Json> methodsFigure(PaperScenes& scenes) {
  const auto plant = scenes.powerPlant();
  if (!plant) return plant.error();
  const auto palace = scenes.fatehpur();
  if (!palace) return palace.error();
  const Wall wall = gridWall(4, 4);
  Json figure = {
      {"figure", "methods"}, {"wall", wall.source}, {"window_frames", 20}, {"scenes", Json::array()}};
  for (const Scene* scene : {*palace, *plant}) {
    std::vector<InterleavedCull::Candidate> candidates;
    for (const Algorithm algorithm :
         {Algorithm::Adaptive, Algorithm::Naive, Algorithm::Oh, Algorithm::Fh, Algorithm::AdaptiveListing}) {
      candidates.push_back(
          {std::string(cull::nameOf(algorithm)), &scene->hierarchy, {.algorithm = algorithm}});
    }
    const Walk walk(wall, orbitPath(), scene->sphere(), scenes.frames(4000));
    GridFrusta frusta = frustaFor(wall);
    InterleavedCull interleaved(candidates);
    follow(walk, frusta, interleaved);
    figure["scenes"].push_back({{"scene", scene == *plant ? "power plant" : "Fatehpur"},
                                {"leaves", scene->leaves.size()},
                                {"frames", walk.frames()},
                                {"camera_step", stepOf(walk)},
                                {"methods", curvesOf(interleaved, &interleaved.measured()[0].us)}});
  }
  return figure;
}

Result<Json> tilesFigure(PaperScenes& scenes) {
  const auto palace = scenes.fatehpur();
  if (!palace) return palace.error();
  constexpr std::array kSizes = {1, 2, 4, 8, 16, 32};
  std::list<Wall> walls;
  std::list<Walk> walks;
  std::list<GridFrusta> frusta;
  std::vector<InterleavedCull::Candidate> candidates;
  for (const int size : kSizes) {
    walls.push_back(gridWall(size, size));
    walks.emplace_back(walls.back(), flyPath(), (*palace)->sphere(), scenes.frames(11'000));
    frusta.push_back(frustaFor(walls.back()));
    candidates.push_back({walls.back().source, &(*palace)->hierarchy, {}});
  }
  InterleavedCull interleaved(candidates);
  for (std::uint64_t frame = 0; frame < walks.front().frames(); ++frame) {
    auto walk = walks.begin();
    auto tiles = frusta.begin();
    for (std::size_t i = 0; i < candidates.size(); ++i, ++walk, ++tiles) {
      const WallView view = walk->view(frame);
      tiles->update(view.screens[0], view.tiles);
      interleaved.run(i, *tiles);
    }
  }
  Json curves = curvesOf(interleaved, nullptr);
  for (std::size_t i = 0; i < kSizes.size(); ++i)
    curves[i]["tiles"] = kSizes[i] * kSizes[i];
  return Json{{"figure", "tiles"},
              {"scene", "Fatehpur"},
              {"frames", walks.front().frames()},
              {"window_frames", 20},
              {"camera_step", stepOf(walks.front())},
              {"walls", std::move(curves)}};
}

Result<Json> mtplFigure(PaperScenes& scenes) {
  Json figure = {{"figure", "mtpl"}, {"scene", "power plant, 1 M triangles"}, {"points", Json::array()}};
  const Wall wall = gridWall(1, 1);
  constexpr std::array<std::uint64_t, 7> kMost = {50, 100, 300, 1000, 3000, 10'000, 100'000};
  // One scene in memory at a time; the walk is the same, so times compare as far as the machine is steady.
  for (const std::uint64_t most : kMost) {
    const auto scene = scenes.powerPlantOf(most);
    if (!scene) return scene.error();
    std::vector<std::uint64_t> trianglesBefore = {0};
    for (const SceneLeaf& leaf : scene->leaves)
      trianglesBefore.push_back(trianglesBefore.back() + leaf.triangles);
    const Walk walk(wall, divePath(), scene->sphere(), scenes.frames(1000));
    GridFrusta frusta = frustaFor(wall);
    InterleavedCull interleaved(
        {{"oh", &scene->hierarchy, {.algorithm = Algorithm::Oh, .bounds = BoundsKind::Aabb}}});
    Samples triangles;
    std::vector<VisibleList> lists;
    for (std::uint64_t frame = 0; frame < walk.frames(); ++frame) {
      const WallView view = walk.view(frame);
      frusta.update(view.screens[0], view.tiles);
      double sum = 0;
      interleaved.run(0, frusta);
      interleaved.listsOf(0, lists);
      for (const LeafRange range : lists[0])
        sum += static_cast<double>(trianglesBefore[range.last] - trianglesBefore[range.first]);
      triangles.add(sum);
    }
    double mean = 0;
    for (const double value : triangles.values)
      mean += value / static_cast<double>(triangles.values.size());
    figure["points"].push_back({{"mtpl", most},
                                {"nodes", scene->hierarchy.nodeCount()},
                                {"leaves", scene->leaves.size()},
                                {"cull_us", spreadOf(interleaved.measured()[0].us)},
                                {"mean_triangles_drawn", mean},
                                {"camera_step", stepOf(walk)}});
  }
  return figure;
}

Result<Json> optimizationsFigure(PaperScenes& scenes) {
  const auto scene = scenes.powerPlantOf(100);
  if (!scene) return scene.error();
  using S = cull::Switches;
  struct Variant {
    const char* name;
    S switches;
  };
  const std::array variants = {
      Variant{"none", {.planeMasking = false}},
      Variant{"masking", {}},
      Variant{"coherency", {.planeMasking = false, .planeCoherency = true}},
      Variant{"octant", {.planeMasking = false, .octantTest = true}},
      Variant{"sign table", {.planeMasking = false, .signTable = true}},
      Variant{"sphere first", {.planeMasking = false, .sphereFirst = true}},
      Variant{"motion coherence", {.planeMasking = false, .motionCoherence = true}},
      Variant{"masking + octant", {.octantTest = true}},
      Variant{"masking + sign table", {.signTable = true}},
      Variant{"masking + coherency", {.planeCoherency = true}},
      Variant{"masking + motion coherence", {.motionCoherence = true}},
      Variant{"masking + octant + sign table + coherency",
              {.planeCoherency = true, .octantTest = true, .signTable = true}},
  };
  std::vector<InterleavedCull::Candidate> candidates;
  for (const Variant& variant : variants) {
    S switches = variant.switches;
    switches.firstLevel = false;  // one frustum: the wall is the tile
    candidates.push_back({variant.name,
                          &scene->hierarchy,
                          {.algorithm = Algorithm::Oh, .bounds = BoundsKind::Aabb, .switches = switches}});
  }
  const Wall wall = gridWall(1, 1);
  const Walk walk(wall, divePath(), scene->sphere(), scenes.frames(2000));
  GridFrusta frusta = frustaFor(wall);
  InterleavedCull interleaved(candidates);
  follow(walk, frusta, interleaved);
  return Json{{"figure", "optimizations"},
              {"scene", "power plant, 1 M triangles, BVH with MTPL 100"},
              {"nodes", scene->hierarchy.nodeCount()},
              {"frames", walk.frames()},
              {"window_frames", 20},
              {"camera_step", stepOf(walk)},
              {"variants", curvesOf(interleaved, &interleaved.measured()[0].us)}};
}

Result<Json> excessFigure(PaperScenes& scenes) {
  const auto plant = scenes.powerPlant();
  if (!plant) return plant.error();
  const auto palace = scenes.fatehpur();
  if (!palace) return palace.error();
  Json figure = {{"figure", "excess"}, {"tables", Json::array()}};
  for (const Scene* scene : {*plant, *palace}) {
    for (const CameraPath* path : {&orbitPath(), &flyPath()}) {
      for (const int size : {4, 8, 16}) {
        auto table = cullTable(*scene, gridWall(size, size), *path,
                               {.frames = scenes.frames(200),
                                .auditedFrames = 6,
                                .only = {"adaptive", "naive", "oh", "fh", "footprint obb ranges",
                                         "footprint obb no-refine", "auto obb diff"}});
        if (!table) return table.error();
        (*table)["scene"] = scene == *plant ? "power plant" : "Fatehpur";
        (*table)["walk"] = path == &flyPath() ? "fly" : "orbit";
        figure["tables"].push_back(std::move(*table));
      }
    }
  }
  return figure;
}

}  // namespace tessera::bench
