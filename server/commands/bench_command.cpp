#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>

#include "common/base/file.h"
#include "server/bench/cull_table.h"
#include "server/bench/paper_figures.h"
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
  std::string json;
};

Status benchCull(const BenchCullFlags& flags) {
  const auto wall = flags.files.readWall();
  if (!wall) return wall.error();
  const auto camera = flags.files.readCamera();
  if (!camera) return camera.error();
  const auto scene = flags.files.readScene();
  if (!scene) return scene.error();
  const auto table = bench::cullTable(*scene, *wall, *camera, flags.table);
  if (!table) return table.error();
  std::printf("%-28s %10s %10s %10s %10s\n", "", "us", "ratio", "pairs", "excess %");
  for (const bench::Json& entry : (*table)["candidates"]) {
    std::printf("%-28s %10.1f %10.2f %10.0f %10.2f\n", entry["name"].get<std::string>().c_str(),
                entry["us"]["p50"].get<double>(), entry["time_ratio"]["p50"].get<double>(),
                entry["pairs_per_frame"].get<double>(), entry.value("excess_percent", 0.0));
  }
  if (flags.json.empty()) return Done{};
  return writeFileAtomically(flags.json, table->dump(1) + "\n");
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

  CLI::App* cull = bench->add_subcommand("cull", "Every algorithm, bound and hierarchy along one walk");
  auto cullFlags = std::make_shared<BenchCullFlags>();
  cullFlags->files.addWall(*cull);
  cullFlags->files.addScene(*cull);
  cullFlags->files.addHierarchy(*cull);
  cullFlags->files.addCamera(*cull);
  cull->add_option("--frames", cullFlags->table.frames, "Frames, evenly along the camera path")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{10'000'000}));
  cull->add_option("--audited-frames", cullFlags->table.auditedFrames,
                   "So many of them are judged in exact arithmetic for the excess")
      ->capture_default_str();
  cull->add_flag("!--no-hierarchies", cullFlags->table.withHierarchies, "Leave out the spatial hierarchies");
  cull->add_option("--json", cullFlags->json, "Write the figures to this file");
  commands.push_back({cull, [cullFlags] { return benchCull(*cullFlags); }});
}

}  // namespace tessera
