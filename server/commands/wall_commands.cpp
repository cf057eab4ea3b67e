#include <cstdio>
#include <memory>

#include <spdlog/spdlog.h>

#include "common/base/file.h"
#include "common/wall/import/wall_import.h"
#include "common/wall/wall_file.h"
#include "common/wall/wall_writer.h"
#include "server/commands/commands.h"

namespace tessera {

namespace {

struct MakeFlags {
  std::string grid, tile = "1920x1080", size, bezel, overlap, out;
  WallRequest request;
};

struct ImportFlags {
  std::string file, out;
};

/// Checks the text as any user's file and writes it, to standard output where no file is named.
Status deliver(const std::string& json, const std::string& out) {
  const Result<Wall> wall = parseWall(json, out.empty() ? "the new wall" : out);
  if (!wall) return wall.error();
  for (const std::string& warning : wall->warnings)
    spdlog::warn("{}", warning);
  if (out.empty()) {
    std::fputs(json.c_str(), stdout);
    return Done{};
  }
  if (Status status = writeFileAtomically(out, json); !status) return status;
  std::printf("wall:   %s\nfile:   %s\n", summaryOf(*wall).c_str(), out.c_str());
  return Done{};
}

Result<std::array<int, 2>> wholePair(const std::string& text, const char* what) {
  const auto pair = parsePair(text, what);
  if (!pair) return pair.error();
  const auto whole = [](double x) { return x == static_cast<double>(static_cast<int>(x)); };
  if ((*pair)[0] > 1e6 || (*pair)[1] > 1e6 || !whole((*pair)[0]) || !whole((*pair)[1]))
    return inputError(what, "\"" + text + "\" is no pair of whole numbers", "write it as 4x3");
  return std::array<int, 2>{static_cast<int>((*pair)[0]), static_cast<int>((*pair)[1])};
}

Status make(const MakeFlags& flags) {
  WallRequest request = flags.request;
  const auto grid = wholePair(flags.grid, "GRID");
  if (!grid) return grid.error();
  const auto tile = wholePair(flags.tile, "--tile");
  if (!tile) return tile.error();
  request.columns = (*grid)[0], request.rows = (*grid)[1];
  request.tileWidthPx = (*tile)[0], request.tileHeightPx = (*tile)[1];
  if (!flags.size.empty()) {
    const std::size_t x = flags.size.find('x');
    if (x == std::string::npos)
      return inputError("--size", "\"" + flags.size + "\" is no pair of lengths",
                        "write it as 1.21x0.68 (metres)");
    const auto width = parseLengthMm(flags.size.substr(0, x), "--size", 1000),
               height = parseLengthMm(flags.size.substr(x + 1), "--size", 1000);
    if (!width) return width.error();
    if (!height) return height.error();
    request.tileMm = {*width, *height};
  }
  if (!flags.bezel.empty()) {
    const auto bezel = parseLengthMm(flags.bezel, "--bezel", 1);
    if (!bezel) return bezel.error();
    request.bezelMm = *bezel;
    if (!request.tileMm)
      return inputError("--bezel", "a bezel in millimetres means nothing without the size of a panel",
                        "add --size, as --size 1.21x0.68");
  }
  if (!flags.overlap.empty()) {
    const auto overlap = wholePair(flags.overlap, "--overlap");
    if (!overlap) return overlap.error();
    request.overlapPx = {static_cast<double>((*overlap)[0]), static_cast<double>((*overlap)[1])};
  }
  return deliver(writeNewWall(request), flags.out);
}

Status import(const ImportFlags& flags) {
  const auto imported = importWall(flags.file);
  if (!imported) return imported.error();
  for (const std::string& warning : imported->warnings)
    spdlog::warn("{}: {}", flags.file, warning);
  return deliver(imported->json, flags.out);
}

}  // namespace

void addWallCommands(CLI::App& tessera, std::vector<Command>& commands) {
  CLI::App* wall = tessera.add_subcommand("wall", "Makes wall files");
  wall->require_subcommand(1);

  CLI::App* maker = wall->add_subcommand("make", "A new wall file: an even grid of tiles");
  auto flags = std::make_shared<MakeFlags>();
  maker->add_option("grid", flags->grid, "Columns and rows, as 4x3")->required();
  maker->add_option("--tile", flags->tile, "Pixels of a tile")->capture_default_str();
  maker->add_option("--size", flags->size, "Visible area of a panel, as 1.21x0.68 (metres) or 1210mmx680mm");
  maker->add_option("--bezel", flags->bezel, "Frame of a panel on every side, as 12mm");
  maker->add_flag("--compress", flags->request.compresses,
                  "Push the picture together over the bezels, not on behind them");
  maker->add_option("--overlap", flags->overlap,
                    "What projectors share with their neighbours in pixels, as 96x64");
  maker
      ->add_option("--rotation", flags->request.rotationDeg,
                   "Panels are mounted turned clockwise by so many degrees")
      ->check(CLI::IsMember({0, 90, 180, 270}));
  maker->add_option("--fov", flags->request.fovYDeg, "Vertical field of view in degrees")
      ->capture_default_str();
  maker->add_option("--name", flags->request.name, "What people call the wall");
  maker->add_option("--out", flags->out, "File to write; default: standard output");
  commands.push_back({maker, [flags] { return make(*flags); }});

  CLI::App* importer = wall->add_subcommand("import",
                                            "A wall file from another system's: Equalizer (.eqc), SGCT or "
                                            "Tide (JSON), DisplayCluster (XML), MPCDI");
  auto importFlags = std::make_shared<ImportFlags>();
  importer->add_option("file", importFlags->file, "The other system's file")->required();
  importer->add_option("--out", importFlags->out, "File to write; default: standard output");
  commands.push_back({importer, [importFlags] { return import(*importFlags); }});
}

}  // namespace tessera
