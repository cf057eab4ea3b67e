#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>

#include <nlohmann/json.hpp>

#include "common/base/file.h"
#include "common/cull/footprint/kernels.h"
#include "server/bench/audit.h"
#include "server/commands/commands.h"
#include "server/commands/inputs.h"
#include "server/commands/visible_lists_file.h"
#include "server/master/run_report.h"
#include "server/master/scene_motion.h"
#include "server/master/wall_culler.h"

namespace tessera {

namespace {

struct CullCommandFlags {
  InputFiles files;
  CullFlags cull;
  MotionFlags motion;
  std::uint64_t frames = 120;
  std::string lists, json;
  bool untiled = false, audit = false;
};

struct Measured {
  Samples frustaUs, cullUs, tests, pairs;
  cull::TestCounts counts;  ///< of all frames together
  std::uint64_t listHash = 0;
  std::optional<Audit> audit;
  std::string_view picked;  ///< what ran in the last frame

  void add(const cull::Result& result) {
    tests.add(static_cast<double>(result.tests.classifications()));
    pairs.add(static_cast<double>(result.pairs));
    counts += result.tests;
    listHash = cull::hashOf(result.lists, listHash);
  }
};

nlohmann::ordered_json countsPerFrame(const cull::TestCounts& counts, std::uint64_t frames) {
  const auto mean = [frames](std::uint64_t count) {
    return static_cast<double>(count) / static_cast<double>(frames);
  };
  return {{"sphere", mean(counts.sphere)},
          {"aabb", mean(counts.aabb)},
          {"obb", mean(counts.obb)},
          {"against_primary", mean(counts.primary)},
          {"against_bisections", mean(counts.bisection)},
          {"against_tiles", mean(counts.tile)},
          {"node_visits", mean(counts.nodes)},
          {"remembered", mean(counts.remembered)},
          {"octant_spared", mean(counts.octantSpared)},
          {"pseudo_groups", mean(counts.groups)}};
}

nlohmann::ordered_json spread(const Samples& samples) {
  return {{"p50", samples.percentile(50)}, {"p99", samples.percentile(99)}, {"max", samples.max()}};
}

std::string reportOf(const CullCommandFlags& flags, const Scene& scene, const Wall& wall,
                     const Measured& measured) {
  nlohmann::ordered_json report = {{"format", "tessera-cull"},
                                   {"version", 1},
                                   {"scene", scene.source},
                                   {"wall", wall.source},
                                   {"tiles", wall.tiles.size()},
                                   {"leaves", scene.leaves.size()},
                                   {"nodes", scene.hierarchy.nodeCount()},
                                   {"hierarchy", flags.files.hierarchy},
                                   {"mtpl", flags.files.maxTrianglesPerLeaf},
                                   {"algorithm", flags.cull.algorithm},
                                   {"picked", measured.picked},
                                   {"simd", cull::instructionSet()},
                                   {"bounds", flags.cull.bounds},
                                   {"switches", flags.cull.changedSwitches()},
                                   {"animate", flags.motion.options.animate},
                                   {"frames", flags.frames},
                                   {"frusta_us", spread(measured.frustaUs)},
                                   {"cull_us", spread(measured.cullUs)},
                                   {"tests_per_frame", spread(measured.tests)},
                                   {"pairs_per_frame", spread(measured.pairs)},
                                   {"tests_by_kind", countsPerFrame(measured.counts, flags.frames)},
                                   {"lists_hash", measured.listHash}};
  if (measured.audit) {
    const Audit::Verdict& verdict = measured.audit->verdicts()[0];
    report["audit"] = {{"pairs", verdict.pairs},
                       {"exact_pairs", verdict.exactPairs},
                       {"excess_percent", verdict.excessPercent()},
                       {"drops", verdict.drops},
                       {"exact_decisions", measured.audit->exactDecisions()}};
  }
  return report.dump(1) + "\n";
}

double usSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

Status cullScene(const CullCommandFlags& flags) {
  if (flags.audit && flags.motion.options.animate)
    return inputError("--audit", "judges a scene that stands still", "leave out --animate");
  const auto options = flags.cull.options();
  if (!options) return options.error();
  auto wall = flags.files.readWall();
  if (!wall) return wall.error();
  if (flags.untiled) *wall = wall->untiled();
  const auto camera = flags.files.readCamera();
  if (!camera) return camera.error();
  const auto scene = flags.files.readScene();
  if (!scene) return scene.error();

  std::optional<VisibleListsFile> lists;
  if (!flags.lists.empty()) {
    lists.emplace();
    if (Status status = lists->open(flags.lists, *scene, *wall); !status) return status;
  }
  const auto motion = SceneMotion::make(*scene, flags.motion.options);
  if (!motion) return motion.error();
  SceneMotion* const moving = motion->get();
  WallCuller culler(moving ? moving->hierarchy() : scene->hierarchy, *wall, *options,
                    flags.cull.planeSource());
  Measured measured;
  if (flags.audit) measured.audit.emplace(*scene);
  const Sphere& sphere = scene->sphere();
  std::uint64_t frame = 0;
  for (const double time : camera->sampleTimes(flags.frames)) {
    const CameraPose pose = camera->poseAt(time, sphere.center, sphere.radius);
    WallView view;
    if (moving) {
      moving->advance(frame + 1, *wall, pose, view);
    } else {
      viewInto(*wall, pose, sphere.center, sphere.radius, view);
    }
    auto start = std::chrono::steady_clock::now();
    culler.update(view);
    measured.frustaUs.add(usSince(start));
    start = std::chrono::steady_clock::now();
    const cull::Result& result = culler.cull();
    measured.cullUs.add(usSince(start));
    measured.add(result);
    measured.picked = cull::nameOf(culler.picked());
    if (lists) lists->add(frame, view, result);
    if (measured.audit) {
      if (moving) measured.audit->hide(moving->hierarchy().absentLeaves());
      if (Status status = measured.audit->add(frame, view, result); !status) return status;
    }
    ++frame;
  }
  if (lists) {
    if (Status status = lists->finish(); !status) return status;
  }
  std::printf("%llu frames, %s: %.1f us a frame (median), %.0f plane tests, %.0f leaf-tile pairs\n",
              static_cast<unsigned long long>(flags.frames), flags.cull.text().c_str(),
              measured.cullUs.percentile(50), measured.tests.percentile(50), measured.pairs.percentile(50));
  if (!flags.json.empty()) {
    Status status = writeFileAtomically(flags.json, reportOf(flags, *scene, *wall, measured));
    if (!status) return status;
  }
  if (!measured.audit) return Done{};
  const Audit::Verdict& verdict = measured.audit->verdicts()[0];
  std::printf("audit: %llu pairs listed, %llu of them exact, excess %.2f %%, %llu dropped\n",
              static_cast<unsigned long long>(verdict.pairs),
              static_cast<unsigned long long>(verdict.exactPairs), verdict.excessPercent(),
              static_cast<unsigned long long>(verdict.drops));
  if (verdict.drops == 0) return Done{};
  return runtimeError(flags.files.scene,
                      "a leaf that meets a tile is missing from its list: " + verdict.firstDrop,
                      "this is a bug: please report it with the scene, wall and camera");
}

}  // namespace

void addCullCommand(CLI::App& tessera, std::vector<Command>& commands) {
  CLI::App* app =
      tessera.add_subcommand("cull", "Culling without network or drawing: visible lists, counts, times");
  auto flags = std::make_shared<CullCommandFlags>();
  flags->files.addWall(*app);
  flags->files.addScene(*app);
  flags->files.addHierarchy(*app);
  flags->files.addCamera(*app);
  flags->cull.add(*app);
  flags->motion.add(*app);
  app->add_option("--frames", flags->frames, "Frames, evenly along the camera path")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{10'000'000}));
  app->add_option("--lists", flags->lists,
                  "Write every tile's frustum and visible list of every frame, as JSON Lines");
  app->add_option("--json", flags->json, "Write the counts and times to this file");
  app->add_flag("--audit", flags->audit,
                "Judge every list against the scene's triangles in exact arithmetic (slow)");
  app->add_flag("--untiled", flags->untiled, "The whole wall as one tile");
  commands.push_back({app, [flags] { return cullScene(*flags); }});
}

}  // namespace tessera
