#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>

#include "common/base/file.h"
#include "common/wall/wall_file.h"
#include "server/bench/candidates.h"
#include "server/bench/cull_table.h"
#include "server/bench/exponents.h"
#include "server/bench/fanout.h"
#include "server/bench/paper_figures.h"
#include "server/bench/targets.h"
#include "server/bench/wall_shapes.h"
#include "server/commands/commands.h"
#include "server/commands/inputs.h"

namespace tessera {

namespace {

struct PapersFlags {
  std::string out;
  std::vector<std::string> only;
  double frameScale = 1;
};

struct Figure {
  const char* name;
  Result<bench::Json> (*make)(bench::PaperScenes&);
};

constexpr std::array kFigures = {
    Figure{"methods", bench::methodsFigure},
    Figure{"tiles", bench::tilesFigure},
    Figure{"dynamic", bench::dynamicFigure},
    Figure{"million", bench::millionFigure},
    Figure{"regroup", bench::regroupFigure},
    Figure{"mtpl", bench::mtplFigure},
    Figure{"optimizations", bench::optimizationsFigure},
    Figure{"excess", bench::excessFigure},
    Figure{"bound", bench::boundFigure},
};

Status benchPapers(const PapersFlags& flags) {
  const std::filesystem::path folder = flags.out;
  std::error_code ec;
  std::filesystem::create_directories(folder, ec);
  if (ec) return inputError(flags.out, "cannot be made: " + ec.message(), "choose another --out");
  bench::PaperScenes scenes(folder, flags.frameScale);
  for (const Figure& figure : kFigures) {
    if (!flags.only.empty() &&
        std::find(flags.only.begin(), flags.only.end(), figure.name) == flags.only.end())
      continue;
    const auto json = figure.make(scenes);
    if (!json) return json.error();
    const std::filesystem::path file = folder / (std::string(figure.name) + ".json");
    if (Status status = writeFileAtomically(file, json->dump(1) + "\n"); !status) return status;
    std::printf("%s\n", file.c_str());
    std::fflush(stdout);
  }
  return Done{};
}

struct BenchCullFlags {
  InputFiles files;
  bench::CullTableOptions table;
  std::string json, exponents, out;
  std::uint64_t mostLeaves = 1'000'000;
};

Status writeJson(const std::string& file, const bench::Json& json) {
  return file.empty() ? Done{} : writeFileAtomically(file, json.dump(1) + "\n");
}

void printTable(const bench::Json& table) {
  std::printf("%-34s %10s %10s %10s %10s\n", "", "us", "ratio", "pairs", "excess %");
  for (const bench::Json& entry : table["candidates"]) {
    std::printf("%-34s %10.1f %10.3f %10.0f", entry["name"].get<std::string>().c_str(),
                entry["us"]["p50"].get<double>(), entry["time_ratio"]["p50"].get<double>(),
                entry["pairs_per_frame"].get<double>());
    if (entry.contains("excess_percent")) std::printf(" %10.2f", entry["excess_percent"].get<double>());
    std::printf("\n");
  }
}

void printExponents(const char* size, const bench::Json& exponents) {
  std::printf("us by %-28s", size);
  for (const bench::Json& point : exponents["methods"][0]["points"])
    std::printf(" %9llu", static_cast<unsigned long long>(point[size].get<std::uint64_t>()));
  std::printf(" %9s\n", "exponent");
  for (const bench::Json& method : exponents["methods"]) {
    std::printf("%-34s", method["name"].get<std::string>().c_str());
    for (const bench::Json& point : method["points"])
      std::printf(" %9.1f", point["us"]["p50"].get<double>());
    std::printf(" %9.3f\n", method["slope"].get<double>());
  }
}

/// A folder that is made where it is missing or, without a name, a temporary one that goes away with this.
class WorkFolder {
 public:
  explicit WorkFolder(std::string path) : path_(std::move(path)) {}
  ~WorkFolder() {
    std::error_code ec;
    if (isTemporary_) std::filesystem::remove_all(path_, ec);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  [[nodiscard]] Status make() {
    std::error_code ec;
    if (path_.empty()) {
      std::string name = (std::filesystem::temp_directory_path(ec) / "tessera-bench-XXXXXX").string();
      if (ec || !mkdtemp(name.data()))
        return runtimeError(name, "cannot be made", "give a folder with --out");
      path_ = name;
      isTemporary_ = true;
      return Done{};
    }
    std::filesystem::create_directories(path_, ec);
    if (ec) return inputError(path_.string(), "cannot be made: " + ec.message(), "choose another --out");
    return Done{};
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  bool isTemporary_ = false;
};

Status benchExponents(const BenchCullFlags& flags, const Wall& wall, const CameraPath& camera) {
  bench::Json json = {{"exponents", bench::Json::object()}};
  if (flags.exponents != "objects") {
    const auto scene = flags.files.readScene();
    if (!scene) return scene.error();
    const auto tiles = bench::tileExponents(*scene, camera, flags.table.frames, flags.table.frames);
    if (!tiles) return tiles.error();
    json["exponents"]["tiles"] = *tiles;
    printExponents("tiles", *tiles);
  }
  if (flags.exponents != "tiles") {
    WorkFolder folder(flags.out);
    if (Status status = folder.make(); !status) return status;
    bench::PaperScenes scenes(folder.path(), 1);
    const auto objects = bench::objectExponents(scenes, wall, camera, flags.table.frames, flags.mostLeaves);
    if (!objects) return objects.error();
    json["exponents"]["objects"] = *objects;
    printExponents("leaves", *objects);
  }
  return writeJson(flags.json, json);
}

Status benchCull(const BenchCullFlags& flags) {
  const auto specs = bench::selectCandidates(flags.table.only, flags.table.withHierarchies);
  if (!specs) return specs.error();  // before anything that takes long
  const auto wall = flags.files.readWall();
  if (!wall) return wall.error();
  const auto camera = flags.files.readCamera();
  if (!camera) return camera.error();
  const bool isFlat = wall->screens.size() == 1 &&
                      (!wall->observer || wall->observer->stereo == Stereo::None) &&
                      std::none_of(wall->tiles.begin(), wall->tiles.end(),
                                   [](const Tile& tile) { return tile.freeTurnRad != 0; });
  if (!isFlat)
    return inputError(flags.files.wall, "this wall is not one screen of upright tiles for one eye",
                      "tessera bench walls compares cullers on walls of every shape");
  if (!flags.exponents.empty()) return benchExponents(flags, *wall, *camera);
  const auto scene = flags.files.readScene();
  if (!scene) return scene.error();
  bench::CullTableOptions options = flags.table;
  options.up = flags.files.upAxis();
  const auto table = bench::cullTable(*scene, *wall, *camera, options);
  if (!table) return table.error();
  printTable(*table);
  return writeJson(flags.json, *table);
}

struct TargetsFlags {
  std::string out, json;
  bench::TargetsOptions options;
};

void printTargets(const bench::Json& targets) {
  for (const bench::Json& figure : targets["figures"]) {
    std::printf("%-84s %9.4f deg ", figure["name"].get<std::string>().c_str(),
                figure["camera_step"]["degrees_per_frame"].get<double>());
    for (const bench::Json& measured : figure["measured"])
      std::printf(" %9.4g", measured.get<double>());
    if (figure.contains("target")) {
      std::printf("   %s %g:", figure["bound"].get<std::string>().c_str(), figure["target"].get<double>());
      for (const bench::Json& met : figure["met"])
        std::printf(" %s", met.get<bool>() ? "met" : "missed");
    }
    std::printf("\n");
  }
}

Status benchTargets(const TargetsFlags& flags) {
  WorkFolder folder(flags.out);
  if (Status status = folder.make(); !status) return status;
  bench::PaperScenes scenes(folder.path(), 1);
  const auto targets = bench::measureTargets(scenes, flags.options);
  if (!targets) return targets.error();
  printTargets(*targets);
  return writeJson(flags.json, *targets);
}

void addTargetsCommand(CLI::App& bench, std::vector<Command>& commands) {
  CLI::App* app = bench.add_subcommand(
      "targets", "The figures that culling is held to, on scenes of our own, and whether they are met");
  auto flags = std::make_shared<TargetsFlags>();
  app->add_option("--out", flags->out, "Folder for the scenes; they are made where missing")->required();
  app->add_option("--runs", flags->options.runs, "So many times each")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{100}));
  app->add_option("--only", flags->options.only,
                  "These scenes alone: P (power plant), C1 (city of 100,000 leaves), C2 (of a million)")
      ->delimiter(',')
      ->check(CLI::IsMember({"P", "C1", "C2"}));
  app->add_option("--frame-scale", flags->options.frameScale,
                  "Measures this share of the frames of each walk; the camera is as fast as ever")
      ->capture_default_str()
      ->check(CLI::Range(0.0001, 1.0));
  app->add_option("--json", flags->json, "Write the figures to this file");
  commands.push_back({app, [flags] { return benchTargets(*flags); }});
}

struct WallsFlags {
  InputFiles files;
  std::vector<std::string> walls;
  std::string json;
  bench::WallShapesOptions options;
};

Status benchWalls(const WallsFlags& flags) {
  std::vector<Wall> walls;
  for (const std::string& file : flags.walls) {
    auto wall = readWallFile(file);
    if (!wall) return wall.error();
    walls.push_back(std::move(*wall));
  }
  const auto camera = flags.files.readCamera();
  if (!camera) return camera.error();
  const auto scene = flags.files.readScene();
  if (!scene) return scene.error();
  const bench::Json shapes = bench::wallShapes(*scene, walls, *camera, flags.options);
  for (const bench::Json& shape : shapes["walls"]) {
    std::printf("%s: %d tiles on %d screens in %d groups\n", shape["wall"].get<std::string>().c_str(),
                shape["tiles"].get<int>(), shape["screens"].get<int>(), shape["groups"].get<int>());
    for (const bench::Json& entry : shape["candidates"]) {
      std::printf("  %-16s %10.1f us %8.2f times as fast as tile by tile %10.0f pairs\n",
                  entry["name"].get<std::string>().c_str(), entry["us"]["p50"].get<double>(),
                  entry["time_of_tile_by_tile"]["p50"].get<double>(), entry["pairs_per_frame"].get<double>());
    }
  }
  return writeJson(flags.json, shapes);
}

void addWallsCommand(CLI::App& bench, std::vector<Command>& commands) {
  CLI::App* app = bench.add_subcommand(
      "walls", "Walls of every shape: culled as the master does, by one hierarchy, tile by tile, eye by eye");
  auto flags = std::make_shared<WallsFlags>();
  app->add_option("--wall", flags->walls, "Wall files")->required()->expected(1, 64);
  flags->files.addScene(*app);
  flags->files.addHierarchy(*app);
  flags->files.addCamera(*app);
  app->add_option("--frames", flags->options.frames, "Frames, evenly along the camera path")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{10'000'000}));
  app->add_option("--head-step", flags->options.headStepM,
                  "An observer's head moves by so many metres a frame; 0: not at all")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  app->add_option("--json", flags->json, "Write the figures to this file");
  commands.push_back({app, [flags] { return benchWalls(*flags); }});
}

struct FanoutFlags {
  bench::FanoutOptions options;
  std::uint64_t megabytes = 500;
  std::string json;
};

Status benchFanout(const FanoutFlags& flags) {
  bench::FanoutOptions options = flags.options;
  options.bytes = flags.megabytes * 1'000'000;
  const auto fanout = bench::measureFanout(options);
  if (!fanout) return fanout.error();
  std::printf("%-38s %12s %10s %16s %10s\n", "", "MB/s in sum", "of bare", "MB/processor s", "of bare");
  for (const bench::Json& kind : (*fanout)["kinds"]) {
    std::printf("%-38s %12.0f %10.3f %16.0f %10.3f\n", kind["name"].get<std::string>().c_str(),
                kind["median_mb_per_s"].get<double>(), kind["of_bare"].get<double>(),
                kind["median_mb_per_processor_s"].get<double>(),
                kind["of_bare_by_processor_time"].get<double>());
  }
  return writeJson(flags.json, *fanout);
}

void addFanoutCommand(CLI::App& bench, std::vector<Command>& commands) {
  CLI::App* app = bench.add_subcommand(
      "fanout",
      "The same assets to many receivers over loopback: as messages, dropped or checked, beside bare TCP");
  auto flags = std::make_shared<FanoutFlags>();
  app->add_option("--tiles", flags->options.receivers, "Receivers, a process each")
      ->capture_default_str()
      ->check(CLI::Range(1U, 256U));
  app->add_option("--megabytes", flags->megabytes, "What each receives")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{4}, std::uint64_t{100'000}));
  app->add_option("--runs", flags->options.runs, "So many times each, in turn")
      ->capture_default_str()
      ->check(CLI::Range(1U, 100U));
  app->add_option("--json", flags->json, "Write the figures to this file");
  commands.push_back({app, [flags] { return benchFanout(*flags); }});
}

void addCullTableCommand(CLI::App& bench, std::vector<Command>& commands) {
  CLI::App* cull = bench.add_subcommand(
      "cull",
      "Every algorithm, bound, hierarchy and form of output along one walk, beside OpenSceneGraph's own "
      "culling; fails where a visible leaf is dropped or lists differ that must be equal");
  auto flags = std::make_shared<BenchCullFlags>();
  flags->files.addWall(*cull);
  flags->files.addScene(*cull);
  flags->files.addHierarchy(*cull);
  flags->files.addCamera(*cull);
  cull->add_option("--frames", flags->table.frames, "Frames, evenly along the camera path")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{10'000'000}));
  cull->add_option("--audited-frames", flags->table.auditedFrames,
                   "So many of them are judged in exact arithmetic, every candidate's lists, for drops and "
                   "excess; 0: none")
      ->capture_default_str();
  cull->add_flag("!--no-hierarchies", flags->table.withHierarchies, "Leave out the spatial hierarchies");
  cull->add_option("--only", flags->table.only,
                   "Only candidates whose names begin with one of these, as \"table,auto obb diff,osg\"; "
                   "\"adaptive obb\", the base of the ratios, is always there")
      ->delimiter(',');
  cull->add_option(
          "--exponents", flags->exponents,
          "Instead of the table: the exponents with which time grows by tiles (the scene on grids of 1x1 to "
          "32x32, whatever --wall has), by objects (cities of 1000 leaves and more on the wall, whatever "
          "--scene holds) or both")
      ->check(CLI::IsMember({"tiles", "objects", "both"}));
  cull->add_option("--most-leaves", flags->mostLeaves, "--exponents objects: the largest city")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{1000}, std::uint64_t{100'000'000}));
  cull->add_option("--out", flags->out,
                   "--exponents objects: folder that keeps the cities; default: a temporary one");
  cull->add_option("--json", flags->json, "Write the figures to this file");
  commands.push_back({cull, [flags] { return benchCull(*flags); }});
}

}  // namespace

void addBenchCommands(CLI::App& tessera, std::vector<Command>& commands) {
  CLI::App* bench =
      tessera.add_subcommand("bench", "Measurements; each compares its candidates interleaved in one run");
  bench->require_subcommand(1);

  CLI::App* papers =
      bench->add_subcommand("papers", "The figures of the papers, with our scenes and machine");
  auto papersFlags = std::make_shared<PapersFlags>();
  papers->add_option("--out", papersFlags->out, "Folder for a JSON file for each figure; made where missing")
      ->required();
  std::vector<std::string> names;
  for (const Figure& figure : kFigures)
    names.emplace_back(figure.name);
  papers->add_option("--only", papersFlags->only, "These figures alone")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  papers
      ->add_option("--frame-scale", papersFlags->frameScale,
                   "Shortens the walks to this share of their frames")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 1.0));
  commands.push_back({papers, [papersFlags] { return benchPapers(*papersFlags); }});

  addCullTableCommand(*bench, commands);
  addTargetsCommand(*bench, commands);
  addWallsCommand(*bench, commands);
  addFanoutCommand(*bench, commands);
}

}  // namespace tessera
