// The figures that culling is held to, by scene.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/hierarchy/bounds_refit.h"
#include "common/hierarchy/grid_frusta.h"
#include "proto/list_codec.h"
#include "proto/list_coder.h"
#include "server/bench/candidates.h"
#include "server/bench/cull_table.h"
#include "server/bench/exponents.h"
#include "server/bench/list_entropy.h"
#include "server/bench/targets.h"
#include "server/bench/unbounded.h"

namespace tessera::bench {

namespace {

using Bound = TargetFigure::Bound;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kJumpingFrames = 60, kFastFrames = 200, kLoopFrames = 4000, kLongLoopFrames = 20'000;
constexpr double kSlowStepDeg = 0.04;

double usSince(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

/// A walk of so many frames, of which a share is measured.
struct Course {
  const char* name;
  const CameraPath* path;
  int side;  ///< of the wall, in tiles
  std::uint64_t walkFrames;
  double frameScale;

  [[nodiscard]] std::uint64_t frames() const {
    const auto scaled = static_cast<std::uint64_t>(std::ceil(frameScale * static_cast<double>(walkFrames)));
    return std::clamp<std::uint64_t>(scaled, std::min<std::uint64_t>(4, walkFrames), walkFrames);
  }
};

/// As many frames as make the camera turn by so many degrees a frame.
std::uint64_t framesAt(double stepDeg, const Scene& scene, const CameraPath& path) {
  constexpr std::uint64_t kProbe = 1000;
  const Wall wall = gridWall(1, 1);
  const double degrees = Walk(wall, path, scene.sphere(), kProbe).step().degrees;
  return static_cast<std::uint64_t>(std::llround(static_cast<double>(kProbe) * degrees / stepDeg));
}

/// Candidates interleaved along a course.
class Race {
 public:
  static Result<Race> run(const Scene& scene, const Course& course, const std::vector<std::string>& names) {
    auto specs = selectCandidates(names, false);
    if (!specs) return specs.error();
    const auto set = CandidateSet::make(scene, UpAxis::Auto, std::move(*specs));
    if (!set) return set.error();
    Race race;
    race.course_ = course;
    const Wall wall = gridWall(course.side, course.side);
    const Walk walk(wall, *course.path, scene.sphere(), course.walkFrames);
    race.step_ = walk.step();
    const auto side = static_cast<std::uint16_t>(course.side);
    GridFrusta frusta(side, side);
    InterleavedCull interleaved((*set)->candidates());
    for (std::uint64_t frame = 0; frame < course.frames(); ++frame) {
      const WallView view = walk.view(frame);
      frusta.update(view.screens[0], view.tiles);
      (*set)->setView(view);
      interleaved.frame(frusta);
    }
    race.measured_ = interleaved.measured();
    return race;
  }

  /// Time of one candidate over that of another, median frame by frame.
  [[nodiscard]] TargetFigure ratio(const std::string& slower, const std::string& faster) const {
    return {.name = std::string(course_.name) + ": " + slower + " / " + faster,
            .measured = ratioOf(of(slower).us, of(faster).us)["p50"].get<double>(),
            .step = step_,
            .frames = course_.frames()};
  }
  [[nodiscard]] TargetFigure atLeast(double target, const std::string& slower,
                                     const std::string& faster) const {
    TargetFigure figure = ratio(slower, faster);
    figure.target = target;
    return figure;
  }
  [[nodiscard]] TargetFigure atMost(double target, const std::string& one, const std::string& other) const {
    TargetFigure figure = atLeast(target, one, other);
    figure.bound = Bound::AtMost;
    return figure;
  }

 private:
  Race() = default;
  [[nodiscard]] const InterleavedCull::Measured& of(const std::string& name) const {
    return *std::find_if(measured_.begin(), measured_.end(),
                         [&name](const auto& measured) { return measured.name == name; });
  }
  Course course_ = {};
  Walk::Step step_;
  std::vector<InterleavedCull::Measured> measured_;
};

/// Appends the figures of a race, or passes its error on.
template <class Figures>
Status collect(const Result<Race>& race, TargetFigures& out, Figures figures) {
  if (!race) return race.error();
  for (TargetFigure& figure : figures(*race))
    out.push_back(std::move(figure));
  return Done{};
}

/// Pairs that only the bound of rounding keeps, in percent of all: leaves' boxes against tiles' planes.
TargetFigure boundExcess(const Scene& scene, const Course& course) {
  const Wall wall = gridWall(course.side, course.side);
  const Walk walk(wall, *course.path, scene.sphere(), course.walkFrames);
  const auto side = static_cast<std::uint16_t>(course.side);
  GridFrusta frusta(side, side);
  std::uint64_t with = 0, without = 0;
  for (std::uint64_t frame = 0; frame < course.frames(); ++frame) {
    const WallView view = walk.view(frame);
    frusta.update(view.screens[0], view.tiles);
    for (std::uint32_t leaf = 0; leaf < scene.leaves.size(); ++leaf) {
      const RelativeObb box(scene.hierarchy.obb(scene.hierarchy.nodeOfLeaf(leaf)), frusta.eye());
      for (std::uint32_t tile = 0; tile < frusta.tileCount(); ++tile) {
        const FrustumPlanes& planes = frusta.tile(tile);
        const auto all = std::span(planes.planes).first(planes.count);
        with += std::none_of(all.begin(), all.end(),
                             [&](const BoundedPlane& p) { return classify(box, p) == Side::Outside; });
        without += std::none_of(all.begin(), all.end(), [&](const BoundedPlane& p) {
          return classifyUnbounded(box, p) == Side::Outside;
        });
      }
    }
  }
  const double percent = 100 * (static_cast<double>(with) / static_cast<double>(without) - 1);
  return {.name = std::string(course.name) + ": excess from the error bound, %",
          .measured = without > 0 ? percent : 0,
          .target = 0.01,
          .bound = Bound::AtMost,
          .step = walk.step(),
          .frames = course.frames()};
}

/// Bytes of list deltas over the entropy of their runs: as they are sent, and as plain numbers of variable
/// length. The first frame, which sends whole lists, is left out.
TargetFigures deltaOverEntropy(const Scene& scene, const Course& course) {
  const Wall wall = gridWall(course.side, course.side);
  const Walk walk(wall, *course.path, scene.sphere(), course.walkFrames);
  const auto side = static_cast<std::uint16_t>(course.side);
  GridFrusta frusta(side, side);
  cull::Culler culler(scene.hierarchy, {.algorithm = cull::Algorithm::Auto});
  std::vector<proto::ListEncoder> encoders(wall.tiles.size(),
                                           proto::ListEncoder(scene.hierarchy.leafCount()));
  std::vector<std::byte> encoded;
  ListEntropy entropy;
  std::uint64_t codedBytes = 0, plainBytes = 0, runs = 0;
  double encodeUs = 0;
  for (std::uint64_t frame = 0; frame < course.frames(); ++frame) {
    const WallView view = walk.view(frame);
    frusta.update(view.screens[0], view.tiles);
    const cull::Changes& changes = culler.cullChanges(frusta);
    for (std::size_t tile = 0; tile < encoders.size(); ++tile) {
      const VisibleList& toggled = changes.toggled[tile];
      const auto start = Clock::now();
      encoders[tile].encode(toggled, encoded);
      const double us = usSince(start);
      if (frame == 0) continue;
      encodeUs += us;
      codedBytes += encoded.size();
      runs += toggled.size();
      entropy.add(toggled);
      proto::encodeToggles(toggled, encoded);
      plainBytes += encoded.size();
    }
  }
  const auto figure = [&](const char* what, double measured) {
    return TargetFigure{.name = std::string(course.name) + ": " + what,
                        .measured = measured,
                        .bound = Bound::AtMost,
                        .step = walk.step(),
                        .frames = course.frames()};
  };
  const auto overEntropy = [&entropy](std::uint64_t bytes) {
    return entropy.bytes() > 0 ? static_cast<double>(bytes) / entropy.bytes() : 0;
  };
  TargetFigures figures = {
      figure("list delta / entropy of its runs", overEntropy(codedBytes)),
      figure("the same in plain numbers", overEntropy(plainBytes)),
      figure("ns to encode a run", runs > 0 ? 1000 * encodeUs / static_cast<double>(runs) : 0)};
  figures[0].target = 1.2;
  return figures;
}

/// One leaf in a hundred moves by up to a thousandth of the scene's radius, neighbours or scattered ones.
Result<TargetFigures> refitFigures(const Scene& scene, const Course& course, bool areNeighbours) {
  constexpr std::uint32_t kOneIn = 100;
  const Wall wall = gridWall(course.side, course.side);
  const Walk walk(wall, *course.path, scene.sphere(), course.walkFrames);
  const auto side = static_cast<std::uint16_t>(course.side);
  GridFrusta frusta(side, side);
  ObjectHierarchy moving = scene.hierarchy;
  BoundsRefit refit(moving, BoxFit::AxisAligned);
  const cull::Options options = {.algorithm = cull::Algorithm::Auto, .threads = 1};
  cull::Culler movingCuller(moving, options), stillCuller(scene.hierarchy, options);
  Samples moveUs, refitUs, withUpkeepUs, stillUs;
  const std::uint32_t leaves = moving.leafCount();
  for (std::uint64_t frame = 0; frame < course.frames(); ++frame) {
    Mat4 map = Mat4::Identity();
    const double phase = 0.1 * static_cast<double>(frame), reach = 0.001 * scene.sphere().radius;
    map.topRightCorner<3, 1>() = reach * Vec3(std::sin(phase), 0, std::cos(phase));
    auto start = Clock::now();
    for (std::uint32_t i = 0; i < leaves / kOneIn; ++i)
      static_cast<void>(refit.move(areNeighbours ? leaves / 2 + i : i * kOneIn, map));
    moveUs.add(usSince(start));
    start = Clock::now();
    static_cast<void>(refit.refit());
    refitUs.add(usSince(start));
    const WallView view = walk.view(frame);
    frusta.update(view.screens[0], view.tiles);
    start = Clock::now();
    static_cast<void>(stillCuller.cull(frusta));
    stillUs.add(usSince(start));
    start = Clock::now();
    static_cast<void>(movingCuller.cull(frusta));
    withUpkeepUs.add(refitUs.values.back() + usSince(start) - stillUs.values.back());
  }
  if (refit.refusedMoves() > 0) return runtimeError(scene.source, "has leaves that cannot be moved");
  const std::string name =
      std::string(course.name) + ": refit of 1 % movers, " + (areNeighbours ? "neighbours" : "scattered");
  const auto overCull = [&](const char* what, const Samples& us) {
    return TargetFigure{.name = name + what + " / one cull",
                        .measured = ratioOf(us, stillUs)["p50"].get<double>(),
                        .bound = Bound::AtMost,
                        .step = walk.step(),
                        .frames = course.frames()};
  };
  TargetFigures figures = {overCull("", refitUs), overCull(", with what the culler recomputes", withUpkeepUs),
                           overCull(", moving the leaves before it", moveUs)};
  figures[0].target = 0.25;
  return figures;
}

Result<TargetFigures> exponentFigures(const Scene& scene, const Course& course) {
  const auto exponents = tileExponents(scene, *course.path, course.walkFrames, course.frames());
  if (!exponents) return exponents.error();
  const Json& step = (*exponents)["camera_step"];
  TargetFigures figures;
  for (const Json& method : (*exponents)["methods"]) {
    const auto name = method["name"].get<std::string>();
    TargetFigure figure = {
        .name = std::string(course.name) + ": exponent of time in 4 to 1024 tiles, " + name,
        .measured = method["slope"].get<double>(),
        .bound = Bound::AtMost,
        .step = {step["degrees_per_frame"].get<double>(), step["scene_radii_per_frame"].get<double>()},
        .frames = course.frames()};
    if (name == "table obb diff") figure.target = 0.02;
    if (name == "footprint obb ranges") figure.target = 0.15;
    figures.push_back(std::move(figure));
  }
  return figures;
}

/// What refining the footprints' rectangles is worth and costs.
Result<TargetFigures> excessFigures(const Scene& scene, const Course& course) {
  const auto table = cullTable(scene, gridWall(course.side, course.side), *course.path,
                               {.frames = course.walkFrames,
                                .firstFrames = course.frames(),
                                .auditedFrames = 6,
                                .withHierarchies = false,
                                .only = {"footprint obb", "table obb"}});
  if (!table) return table.error();
  const auto entry = [&table](const std::string& name) -> const Json& {
    const Json& all = (*table)["candidates"];
    return *std::find_if(all.begin(), all.end(), [&name](const Json& one) { return one["name"] == name; });
  };
  const Json& step = (*table)["camera_step"];
  TargetFigures figures;
  for (const std::string method : {"footprint obb", "table obb"}) {
    const Json &refined = entry(method + " ranges"), &plain = entry(method + " no-refine ranges");
    TargetFigure figure = {
        .name = std::string(course.name) + ": excess against triangles, " + method + ", %",
        .measured = refined["excess_percent"].get<double>(),
        .target = 15,
        .bound = Bound::AtMost,
        .step = {step["degrees_per_frame"].get<double>(), step["scene_radii_per_frame"].get<double>()},
        .frames = course.frames()};
    figures.push_back(figure);
    figure.name = std::string(course.name) + ": excess without refinement, " + method + ", %";
    figure.measured = plain["excess_percent"].get<double>();
    figure.target.reset();
    figures.push_back(figure);
    figure.name = std::string(course.name) + ": time with / without refinement, " + method;
    figure.measured = refined["time_ratio"]["p50"].get<double>() / plain["time_ratio"]["p50"].get<double>();
    figure.target = 1.3;
    figures.push_back(figure);
  }
  return figures;
}

void addAll(const TargetFigures& more, TargetFigures& out) {
  out.insert(out.end(), more.begin(), more.end());
}

Status append(const Result<TargetFigures>& more, TargetFigures& out) {
  if (!more) return more.error();
  addAll(*more, out);
  return Done{};
}

}  // namespace

Result<TargetFigures> powerPlantTargets(const Scene& scene, double frameScale) {
  const CameraPath& fly = flyPath();
  const std::uint64_t slowFrames = framesAt(kSlowStepDeg, scene, fly);
  TargetFigures figures;
  figures.push_back(boundExcess(scene, {"P fly 8x8", &fly, 8, kJumpingFrames, frameScale}));
  const auto race = [&](const Course& course, const std::vector<std::string>& names, auto pick) {
    return collect(Race::run(scene, course, names), figures, pick);
  };
  Status status =
      race({"P fly 8x8", &fly, 8, kLoopFrames, frameScale},
           {kOhName, "auto obb diff", "table obb", "footprint obb"}, [](const Race& r) {
             return TargetFigures{
                 r.atLeast(10, kBaseName, "auto obb diff"), r.atLeast(100, kOhName, "auto obb diff"),
                 r.ratio(kBaseName, "table obb diff"),      r.ratio(kBaseName, "table obb ranges"),
                 r.ratio(kBaseName, "footprint obb diff"),  r.ratio(kBaseName, "footprint obb ranges")};
           });
  if (!status) return status.error();
  status = race({"P fly 16x16", &fly, 16, kLoopFrames, frameScale}, {"table obb", "auto obb diff"},
                [](const Race& r) {
                  return TargetFigures{r.atLeast(25, kBaseName, "table obb diff"),
                                       r.ratio(kBaseName, "table obb coherent-measured diff"),
                                       r.ratio(kBaseName, "auto obb diff")};
                });
  if (!status) return status.error();
  status = race({"P fly 8x8", &fly, 8, kFastFrames, frameScale},
                {"osg", "footprint obb ids", "table obb ids", "auto obb ids"}, [](const Race& r) {
                  return TargetFigures{r.atLeast(100, "osg traversal-only", "auto obb ids"),
                                       r.ratio("osg traversal-only", "footprint obb ids"),
                                       r.ratio("osg traversal-only", "table obb ids"),
                                       r.ratio("osg full", "auto obb ids")};
                });
  if (!status) return status.error();
  status = append(exponentFigures(scene, {"P fly", &fly, 0, kFastFrames, frameScale}), figures);
  if (!status) return status.error();
  const auto reuse = [](double always, double measured) {
    return [always, measured](const Race& r) {
      TargetFigure kept = r.ratio("table obb diff", "table obb coherent-always diff");
      TargetFigure chosen = r.ratio("table obb diff", "table obb coherent-measured diff");
      if (always > 0) kept.target = always;
      if (measured > 0) chosen.target = measured;
      return TargetFigures{kept, chosen};
    };
  };
  status = race({"P fly 8x8 slowly", &fly, 8, slowFrames, frameScale}, {"table obb"}, reuse(6, 0));
  if (!status) return status.error();
  status = race({"P fly 8x8 fast", &fly, 8, kFastFrames, frameScale}, {"table obb"}, reuse(0, 0.95));
  if (!status) return status.error();
  status = append(excessFigures(scene, {"P fly 16x16", &fly, 16, kFastFrames, frameScale}), figures);
  if (!status) return status.error();
  for (const auto& [name, tiles] : {std::pair{"P fly 4x4", 4}, {"P fly 8x8", 8}, {"P fly 16x16", 16}})
    addAll(deltaOverEntropy(scene, {name, &fly, tiles, kLoopFrames, frameScale}), figures);
  return figures;
}

Result<TargetFigures> cityTargets(const Scene& scene, double frameScale) {
  TargetFigures figures;
  figures.push_back(boundExcess(scene, {"C1 fly 4x4", &flyPath(), 4, kJumpingFrames, frameScale}));
  for (const auto& [name, path] :
       {std::pair{"C1 fly 4x4, jumping", &flyPath()}, std::pair{"C1 all 4x4, jumping", &orbitPath()}}) {
    Status status = collect(Race::run(scene, {name, path, 4, kJumpingFrames, frameScale},
                                      {kOhName, "footprint obb ranges", "table obb ranges", "auto obb ranges",
                                       "auto obb all-threads ranges"}),
                            figures, [](const Race& r) {
                              return TargetFigures{r.atLeast(8, kOhName, "auto obb ranges"),
                                                   r.atLeast(4, kBaseName, "auto obb ranges"),
                                                   r.ratio(kBaseName, "footprint obb ranges"),
                                                   r.ratio(kBaseName, "table obb ranges"),
                                                   r.ratio(kBaseName, "auto obb all-threads ranges")};
                            });
    if (!status) return status.error();
  }
  for (const auto& [name, tiles] : {std::pair{"C1 fly 4x4", 4}, {"C1 fly 8x8", 8}})
    addAll(deltaOverEntropy(scene, {name, &flyPath(), tiles, kLongLoopFrames, frameScale}), figures);
  for (const bool areNeighbours : {true, false}) {
    Status status = append(
        refitFigures(scene, {"C1 fly 4x4", &flyPath(), 4, kFastFrames, frameScale}, areNeighbours), figures);
    if (!status) return status.error();
  }
  return figures;
}

Result<TargetFigures> millionTargets(const Scene& scene, double frameScale) {
  TargetFigures figures;
  for (const auto& [name, path] :
       {std::pair{"C2 fly 4x4, jumping", &flyPath()}, std::pair{"C2 all 4x4, jumping", &orbitPath()}}) {
    Status status = collect(
        Race::run(scene, {name, path, 4, kJumpingFrames, frameScale},
                  {"footprint obb ranges", "auto obb ranges", "auto obb all-threads ranges", kLinearName}),
        figures, [](const Race& r) {
          return TargetFigures{
              r.atMost(0.12, "auto obb ranges", kLinearName), r.ratio("footprint obb ranges", kLinearName),
              r.ratio("auto obb all-threads ranges", kLinearName), r.ratio(kBaseName, "auto obb ranges")};
        });
    if (!status) return status.error();
  }
  return figures;
}

}  // namespace tessera::bench
