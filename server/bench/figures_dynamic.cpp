// Figures of moving objects, of hierarchies made for the purpose, and of single tests.
#include <array>
#include <chrono>
#include <cmath>
#include <list>

#include <Eigen/Geometry>

#include "common/hierarchy/bounds_refit.h"
#include "common/hierarchy/grid_frusta.h"
#include "server/bench/paper_figures.h"
#include "server/bench/unbounded.h"

namespace tessera::bench {

namespace {

using Clock = std::chrono::steady_clock;

double usSince(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

/// A leaf swings and turns about its place by a few percent of the scene's size.
Mat4 swing(const Vec3& about, double sceneRadius, std::uint32_t leaf, std::uint64_t frame) {
  const double phase = 0.1 * static_cast<double>(frame) + leaf;
  const Mat3 turn = Eigen::AngleAxisd(0.3 * std::sin(phase), Vec3::UnitY()).toRotationMatrix();
  Mat4 map = Mat4::Identity();
  map.topLeftCorner<3, 3>() = turn;
  map.topRightCorner<3, 1>() =
      about - turn * about + 0.02 * sceneRadius * Vec3(std::sin(phase), 0, std::cos(phase));
  return map;
}

/// One of the paper's three ways with moving objects, on its own copy of the scene.
struct MovingScene {
  const char* name;
  ObjectHierarchy oh;
  BoundsRefit refit;
  cull::Culler culler;
  Samples updateUs, cullUs, pairs;

  MovingScene(const char* itsName, const ObjectHierarchy& from, BoxFit fit, cull::BoundsKind bounds)
      : name(itsName), oh(from), refit(oh, fit), culler(oh, {.bounds = bounds}) {}
};

}  // namespace

Result<Json> dynamicFigure(PaperScenes& scenes) {
  const auto plant = scenes.powerPlant();
  if (!plant) return plant.error();
  const Scene& scene = **plant;
  const Wall wall = gridWall(4, 4);
  Json figure = {
      {"figure", "dynamic"}, {"scene", "power plant"}, {"wall", wall.source}, {"points", Json::array()}};
  const auto leafCount = static_cast<std::uint32_t>(scene.leaves.size());
  for (std::uint32_t percent = 0; percent <= 100; percent += 10) {
    std::list<MovingScene> ways;
    ways.emplace_back("obb", scene.hierarchy, BoxFit::Pca, cull::BoundsKind::Obb);
    ways.emplace_back("aabb", scene.hierarchy, BoxFit::AxisAligned, cull::BoundsKind::Aabb);
    ways.emplace_back("hybrid", scene.hierarchy, BoxFit::AxisAligned, cull::BoundsKind::Hybrid);
    const Walk walk(wall, flyPath(), scene.sphere(), scenes.frames(200));
    GridFrusta frusta(4, 4);
    for (std::uint64_t frame = 0; frame < walk.frames(); ++frame) {
      const WallView view = walk.view(frame);
      frusta.update(view.screens[0], view.tiles);
      for (MovingScene& way : ways) {
        auto start = Clock::now();
        for (std::uint32_t leaf = 0; leaf < leafCount; ++leaf) {
          // Scattered evenly, as the paper's "different percentages of the scene".
          if ((leaf * 37u) % 100 >= percent) continue;
          const Vec3 about = scene.hierarchy.aabb(scene.hierarchy.nodeOfLeaf(leaf)).center();
          static_cast<void>(way.refit.move(leaf, swing(about, scene.sphere().radius, leaf, frame)));
        }
        static_cast<void>(way.refit.refit());
        way.updateUs.add(usSince(start));
        start = Clock::now();
        const cull::Result& result = way.culler.cull(frusta);
        way.cullUs.add(usSince(start));
        way.pairs.add(static_cast<double>(result.pairs));
      }
    }
    Json point = {{"moving_percent", percent}};
    for (const MovingScene& way : ways) {
      point[way.name] = {{"update_us", spreadOf(way.updateUs)},
                         {"cull_us", spreadOf(way.cullUs)},
                         {"pairs_per_frame", way.pairs.percentile(50)}};
    }
    figure["points"].push_back(std::move(point));
  }
  return figure;
}

namespace {

/// `count` boxes on a square of streets, under nodes of the same number of children each, neighbours
/// together.
ObjectHierarchy uniformHierarchy(std::uint32_t side, std::uint32_t branching) {
  ObjectHierarchyBuilder builder;
  const auto leaf = [&](std::uint32_t index) {  // along a Morton curve: any run of it is compact
    std::uint32_t x = 0, z = 0;
    for (std::uint32_t bit = 0; bit < 16; ++bit) {
      x |= ((index >> (2 * bit)) & 1u) << bit;
      z |= ((index >> (2 * bit + 1)) & 1u) << bit;
    }
    const double height = 0.3 + 0.1 * ((index * 2654435761u) >> 28);
    const Vec3 low(x, 0, z), high(x + 0.7, height, z + 0.7);
    builder.addLeaf(boundsOf(std::array{low, high}, Vec3::Zero()));
  };
  struct Range {
    std::uint32_t first, last;
    bool isClose = false;
  };
  std::vector<Range> stack = {{0, side * side}};
  while (!stack.empty()) {
    const Range range = stack.back();
    stack.pop_back();
    if (range.isClose) {
      builder.closeNode();
      continue;
    }
    const std::uint32_t count = range.last - range.first;
    if (count == 1) {
      leaf(range.first);
      continue;
    }
    builder.openNode();
    stack.push_back({0, 0, true});
    const std::uint32_t parts = std::min(branching, count);
    for (std::uint32_t part = parts; part-- > 0;) {
      const auto at = [&](std::uint64_t p) {
        return range.first + static_cast<std::uint32_t>(p * count / parts);
      };
      stack.push_back({at(part), at(part + 1)});
    }
  }
  return builder.finish();
}

}  // namespace

Result<Json> millionFigure(PaperScenes& scenes) {
  constexpr std::uint32_t kSide = 1024, kBranching = 8, kOneIn = 100;
  const ObjectHierarchy scene = uniformHierarchy(kSide, kBranching);
  const Wall wall = gridWall(4, 4);
  const Walk walk(wall, flyPath(), scene.sphere(0), scenes.frames(30));
  Json figure = {{"figure", "million"},
                 {"leaves", scene.leafCount()},
                 {"moving_leaves", scene.leafCount() / kOneIn},
                 {"camera_step", stepOf(walk)},
                 {"points", Json::array()}};
  for (const bool areNeighbours : {true, false}) {
    std::list<MovingScene> ways;
    ways.emplace_back("obb", scene, BoxFit::Pca, cull::BoundsKind::Obb);
    ways.emplace_back("hybrid", scene, BoxFit::AxisAligned, cull::BoundsKind::Hybrid);
    Json point = {{"movers", areNeighbours ? "neighbours" : "scattered"}};
    GridFrusta frusta(4, 4);
    for (MovingScene& way : ways) {
      Samples moveUs, refitUs;
      for (std::uint64_t frame = 0; frame < walk.frames(); ++frame) {
        auto start = Clock::now();
        for (std::uint32_t i = 0; i < scene.leafCount() / kOneIn; ++i) {
          const std::uint32_t leaf = areNeighbours ? i : i * kOneIn;
          const Vec3 about = scene.aabb(scene.nodeOfLeaf(leaf)).center();
          static_cast<void>(way.refit.move(leaf, swing(about, 10, leaf, frame)));
        }
        moveUs.add(usSince(start));
        start = Clock::now();
        static_cast<void>(way.refit.refit());
        refitUs.add(usSince(start));
        const WallView view = walk.view(frame);
        frusta.update(view.screens[0], view.tiles);
        start = Clock::now();
        way.pairs.add(static_cast<double>(way.culler.cull(frusta).pairs));
        way.cullUs.add(usSince(start));
      }
      point[way.name] = {{"move_us", spreadOf(moveUs)},
                         {"refit_us", spreadOf(refitUs)},
                         {"cull_us", spreadOf(way.cullUs)},
                         {"pairs_per_frame", way.pairs.percentile(50)}};
    }
    figure["points"].push_back(std::move(point));
  }
  return figure;
}

Result<Json> regroupFigure(PaperScenes& scenes) {
  constexpr std::uint32_t kSide = 128;
  Json figure = {{"figure", "regroup"}, {"leaves", kSide * kSide}, {"points", Json::array()}};
  for (const int size : {4, 16}) {
    const Wall wall = gridWall(size, size);
    for (const std::uint32_t branching : {2u, 4u, 8u, 16u, 32u, 64u, 128u, 256u, 1024u, 16384u}) {
      const ObjectHierarchy oh = uniformHierarchy(kSide, branching);
      InterleavedCull interleaved(
          {{"adaptive", &oh, {}},
           {"regroup from 2", &oh, {.switches = {.regroup = true, .regroupFrom = 2}}},
           {"regroup from 8", &oh, {.switches = {.regroup = true, .regroupFrom = 8}}},
           {"regroup from 32", &oh, {.switches = {.regroup = true, .regroupFrom = 32}}}});
      const Walk walk(wall, flyPath(), oh.sphere(0), scenes.frames(200));
      GridFrusta frusta(static_cast<std::uint16_t>(size), static_cast<std::uint16_t>(size));
      for (std::uint64_t frame = 0; frame < walk.frames(); ++frame) {
        const WallView view = walk.view(frame);
        frusta.update(view.screens[0], view.tiles);
        interleaved.frame(frusta);
      }
      Json point = {{"wall", wall.source}, {"branching", branching}, {"methods", Json::array()}};
      for (const auto& measured : interleaved.measured())
        point["methods"].push_back(summaryOf(measured, &interleaved.measured()[0].us));
      figure["points"].push_back(std::move(point));
    }
  }
  return figure;
}

namespace {

/// Microseconds for all nodes against all sides, and how many were outside.
template <class Relative, class GetBounds, class Classify>
std::pair<double, std::uint64_t> timeOf(const ObjectHierarchy& oh, const GridFrusta& frusta, GetBounds get,
                                        Classify classifyOne) {
  std::uint64_t outside = 0;
  const auto start = Clock::now();
  for (std::uint32_t node = 0; node < oh.nodeCount(); ++node) {
    const Relative bounds(get(node), frusta.eye());
    for (std::uint32_t p = 0; p < 4; ++p)
      outside += classifyOne(bounds, frusta.primary().planes[p]) == Side::Outside ? 1 : 0;
  }
  return {usSince(start), outside};
}

template <class Relative, class GetBounds>
Json boundCost(const char* name, const ObjectHierarchy& oh, const Walk& walk, GetBounds get) {
  Samples with, without;
  std::uint64_t outsideWith = 0, outsideWithout = 0;
  GridFrusta frusta(1, 1);
  for (std::uint64_t frame = 0; frame < walk.frames(); ++frame) {
    const WallView view = walk.view(frame);
    frusta.update(view.screens[0], view.tiles);
    const auto bounded = [&] {
      return timeOf<Relative>(oh, frusta, get, [](const auto& b, const auto& p) { return classify(b, p); });
    };
    const auto unbounded = [&] {
      return timeOf<Relative>(oh, frusta, get,
                              [](const auto& b, const auto& p) { return classifyUnbounded(b, p); });
    };
    const bool boundedFirst = frame % 2 == 0;
    if (!boundedFirst) {
      const auto [us, outside] = unbounded();
      without.add(us), outsideWithout += outside;
    }
    const auto [us, outside] = bounded();
    with.add(us), outsideWith += outside;
    if (boundedFirst) {
      const auto [plainUs, plainOutside] = unbounded();
      without.add(plainUs), outsideWithout += plainOutside;
    }
  }
  const double tests = 4.0 * oh.nodeCount();
  return {{"bounds", name},
          {"ns_per_test_with", with.percentile(50) * 1000 / tests},
          {"ns_per_test_without", without.percentile(50) * 1000 / tests},
          {"time_ratio", ratioOf(with, without)},
          {"outside_with", outsideWith},
          {"outside_without", outsideWithout}};
}

}  // namespace

Result<Json> boundFigure(PaperScenes& scenes) {
  const auto plant = scenes.powerPlant();
  if (!plant) return plant.error();
  const ObjectHierarchy& oh = (*plant)->hierarchy;
  const Wall wall = gridWall(1, 1);
  const Walk walk(wall, flyPath(), (*plant)->sphere(), scenes.frames(400));
  return Json{
      {"figure", "bound"},
      {"scene", "power plant"},
      {"kernels",
       {boundCost<RelativeSphere>("sphere", oh, walk,
                                  [&](std::uint32_t n) -> const Sphere& { return oh.sphere(n); }),
        boundCost<RelativeAabb>("aabb", oh, walk, [&](std::uint32_t n) -> const Aabb& { return oh.aabb(n); }),
        boundCost<RelativeObb>("obb", oh, walk, [&](std::uint32_t n) -> const Obb& { return oh.obb(n); })}}};
}

}  // namespace tessera::bench
