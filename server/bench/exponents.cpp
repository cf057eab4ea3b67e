#include "server/bench/exponents.h"

#include <array>
#include <cmath>
#include <list>

#include "common/hierarchy/grid_frusta.h"
#include "server/bench/candidates.h"

namespace tessera::bench {

namespace {

constexpr std::uint64_t kFewestTiles = 4, kMostTiles = 1024;

Result<std::vector<InterleavedCull::Candidate>> methodsOn(const Scene& scene) {
  const auto specs = selectCandidates({"table obb diff", "table obb ranges", "footprint obb ranges",
                                       "auto obb ranges", "auto obb diff", kOhName},
                                      false);
  if (!specs) return specs.error();
  std::vector<InterleavedCull::Candidate> methods;
  for (const CandidateSpec& spec : *specs) {
    methods.push_back(
        {.name = spec.name, .hierarchy = &scene.hierarchy, .options = spec.options, .output = spec.output});
  }
  return methods;
}

GridFrusta frustaFor(const Wall& wall) {
  return {static_cast<std::uint16_t>(wall.screens[0].columns),
          static_cast<std::uint16_t>(wall.screens[0].rows)};
}

/// Points of one method, in the order of the sizes.
Json methodJson(const std::string& name, const char* sizeName, const std::vector<double>& sizes,
                const std::vector<Json>& spreads, double fewest, double most) {
  Json method = {{"name", name}, {"points", Json::array()}};
  std::vector<double> x, y;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    method["points"].push_back({{sizeName, static_cast<std::uint64_t>(sizes[i])}, {"us", spreads[i]}});
    if (sizes[i] < fewest || sizes[i] > most) continue;
    x.push_back(sizes[i]);
    y.push_back(spreads[i]["p50"].get<double>());
  }
  method["slope"] = exponentOf(x, y);
  return method;
}

}  // namespace

double exponentOf(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  double sumX = 0, sumY = 0, sumXX = 0, sumXY = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double a = std::log(x[i]), b = std::log(y[i]);
    sumX += a, sumY += b, sumXX += a * a, sumXY += a * b;
  }
  const double spread = n * sumXX - sumX * sumX;
  return spread > 0 ? (n * sumXY - sumX * sumY) / spread : 0;
}

Result<Json> tileExponents(const Scene& scene, const CameraPath& path, std::uint64_t walkFrames,
                           std::uint64_t frames) {
  constexpr std::array kSides = {1, 2, 4, 8, 16, 32};
  std::list<Wall> walls;
  std::vector<Walk> walks;
  std::vector<GridFrusta> frusta;
  std::vector<InterleavedCull::Candidate> candidates;
  std::vector<double> tiles;
  const auto methods = methodsOn(scene);
  if (!methods) return methods.error();
  for (const int side : kSides) {
    walls.push_back(gridWall(side, side));
    walks.emplace_back(walls.back(), path, scene.sphere(), walkFrames);
    frusta.push_back(frustaFor(walls.back()));
    candidates.insert(candidates.end(), methods->begin(), methods->end());
    tiles.push_back(side * side);
  }
  InterleavedCull interleaved(candidates);
  for (std::uint64_t frame = 0; frame < frames; ++frame) {
    for (std::size_t i = 0; i < walks.size(); ++i) {
      const WallView view = walks[i].view(frame);
      frusta[i].update(view.screens[0], view.tiles);
    }
    for (const std::size_t at : interleaved.shuffled())
      interleaved.run(at, frusta[at / methods->size()]);
  }
  Json result = {{"scene", scene.source},    {"leaves", scene.leaves.size()},
                 {"frames", frames},         {"camera_step", stepOf(walks.front())},
                 {"fit_from", kFewestTiles}, {"fit_to", kMostTiles},
                 {"methods", Json::array()}};
  for (std::size_t m = 0; m < methods->size(); ++m) {
    std::vector<Json> spreads;
    for (std::size_t i = 0; i < walks.size(); ++i)
      spreads.push_back(spreadOf(interleaved.measured()[i * methods->size() + m].us));
    result["methods"].push_back(
        methodJson((*methods)[m].name, "tiles", tiles, spreads, kFewestTiles, kMostTiles));
  }
  return result;
}

Result<Json> objectExponents(PaperScenes& scenes, const Wall& wall, const CameraPath& path,
                             std::uint64_t frames, std::uint64_t mostLeaves) {
  std::vector<double> leaves;
  std::vector<std::string> names;
  std::vector<std::vector<Json>> spreads;  // by method
  Json steps;
  for (std::uint64_t count = 1000; count <= mostLeaves; count *= 10) {
    const auto scene = scenes.city(count);  // one in memory at a time
    if (!scene) return scene.error();
    const auto methods = methodsOn(*scene);
    if (!methods) return methods.error();
    InterleavedCull interleaved(*methods);
    const Walk walk(wall, path, scene->sphere(), frames);
    WallFrusta frusta(wall);
    for (std::uint64_t frame = 0; frame < frames; ++frame) {
      const WallView view = walk.view(frame);
      frusta.update(view);
      interleaved.frame(frusta.get());
    }
    leaves.push_back(static_cast<double>(count));
    spreads.resize(methods->size());
    names.clear();
    for (std::size_t m = 0; m < methods->size(); ++m) {
      names.push_back((*methods)[m].name);
      spreads[m].push_back(spreadOf(interleaved.measured()[m].us));
    }
    steps = stepOf(walk);
  }
  Json result = {{"scenes", "cities"},
                 {"wall", wall.source},
                 {"frames", frames},
                 {"camera_step", steps},
                 {"methods", Json::array()}};
  for (std::size_t m = 0; m < names.size(); ++m) {
    result["methods"].push_back(
        methodJson(names[m], "leaves", leaves, spreads[m], leaves.front(), leaves.back()));
  }
  return result;
}

}  // namespace tessera::bench
