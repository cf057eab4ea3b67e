#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>

#include <spdlog/spdlog.h>

#include "common/base/file.h"
#include "common/base/pixel_place.h"
#include "common/wall/grid_layout.h"
#include "common/wall/wall_picture.h"
#include "server/commands/commands.h"
#include "server/commands/inputs.h"
#include "server/commands/live_wall.h"
#include "server/commands/progress.h"
#include "server/commands/stop_signals.h"
#include "server/master/master.h"
#include "server/supervisor/tile_process.h"

namespace tessera {

namespace {

constexpr std::uint64_t kDefaultFrames = 120;

struct RunFlags {
  InputFiles files;
  CullFlags cull;
  StreamFlags stream;
  std::string cache, diskCache, cacheFolder;
  MotionFlags motion;
  std::optional<std::uint64_t> frames;
  std::uint64_t pictureEvery = 1;
  LiveFlags live;
  bool interactive = false;
  std::size_t tilesPerProcess = 1;
  std::string out, surface = "offscreen", window, json, frameLog;
  double framesPerSecond = 0, frameDeadlineS = 10, tilesDeadlineS = 30;
  bool untiled = false, noPictures = false, noVsync = false;
};

/// People steer in windows unless the frames are counted.
bool steers(const RunFlags& flags) {
  return flags.interactive || (flags.surface == "window" && !flags.frames);
}

MasterOptions masterOptions(const RunFlags& flags, const cull::Options& cullOptions) {
  MasterOptions options;
  options.cull = cullOptions;
  options.planeSource = flags.cull.planeSource();
  options.motion = flags.motion.options;
  options.frames = flags.frames.value_or(steers(flags) ? 0 : kDefaultFrames);
  options.framesPerSecond = flags.framesPerSecond;
  options.frameDeadline = std::chrono::milliseconds(static_cast<int>(flags.frameDeadlineS * 1000));
  options.tilesDeadline = std::chrono::milliseconds(static_cast<int>(flags.tilesDeadlineS * 1000));
  if (!flags.out.empty() && !flags.noPictures && flags.surface != "none") options.pictureFolder = flags.out;
  options.pictureEvery = flags.pictureEvery;
  options.countTriangles = !flags.frameLog.empty();
  options.stream = flags.stream.stream();
  return options;
}

void printSummary(const RunReport& report) {
  std::uint64_t missed = 0, listBytes = 0, geometryBytes = 0;
  for (const auto& tile : report.tiles) {
    missed += tile.counts.framesMissed;
    listBytes += tile.listBytes;
    geometryBytes += tile.geometryBytes;
  }
  std::printf(
      "%llu frames on %zu tiles, %.1f a second; %llu tile frames missed\n",
      static_cast<unsigned long long>(report.frames), report.tiles.size(),
      report.seconds > 0 && report.frames > 1 ? static_cast<double>(report.frames - 1) / report.seconds : 0.0,
      static_cast<unsigned long long>(missed));
  std::printf(
      "culling %.3f ms (median), %.0f leaf-tile pairs a frame; sent %.2f MB of geometry, %.1f KB of lists\n",
      report.cullMs.percentile(50), report.visibleLeavesPerFrame.percentile(50),
      static_cast<double>(geometryBytes) / 1e6, static_cast<double>(listBytes) / 1e3);
}

Status writeReport(const RunFlags& flags, const RunReport& report) {
  const std::string json = report.json();
  if (!flags.json.empty()) {
    if (Status status = writeFileAtomically(flags.json, json); !status) return status;
  }
  if (!flags.frameLog.empty()) {
    if (Status status = writeFileAtomically(flags.frameLog, report.frameLog()); !status) return status;
  }
  if (flags.out.empty()) return Done{};
  const std::filesystem::path folder = flags.out;
  if (Status status = writeFileAtomically(folder / "report.json", json); !status) return status;
  if (report.pictures > 0)
    std::printf("pictures: %s (%llu)\n", (folder / "frame-*.png").c_str(),
                static_cast<unsigned long long>(report.pictures));
  std::printf("report:   %s\n", (folder / "report.json").c_str());
  return Done{};
}

Status makeFolder(const std::string& folder) {
  if (folder.empty()) return Done{};
  std::error_code ec;
  std::filesystem::create_directories(folder, ec);
  if (ec) return inputError(folder, "cannot be made: " + ec.message(), "choose another --out");
  return Done{};
}

/// The wall as its operator sees it on a desktop: panels that are mounted turned draw what they show upright.
Wall asSeen(Wall wall) {
  for (Tile& tile : wall.tiles) {
    auto& blend = tile.output.blendPx;
    const Sides<double> seen =
        pictureSides(Sides<double>{blend[0], blend[1], blend[2], blend[3]}, (4 - tile.quarterTurns) % 4);
    blend = {seen.left, seen.right, seen.bottom, seen.top};
    if (tile.quarterTurns % 2 != 0) {
      std::swap(tile.widthPx, tile.heightPx);
      std::swap(tile.widthMm, tile.heightMm);
    }
    tile.quarterTurns = 0;
  }
  for (const Screen& screen : wall.screens)
    assignCanvases(screen, wall.tiles);
  return wall;
}

/// A tile's part of a rectangle that shows the whole wall, rounded so that neighbours meet.
PixelPlace partOf(const PixelPlace& whole, const WallPicture& picture, const PixelSize& size,
                  const Tile& tile, const PicturePlace& place) {
  const Vec2 end = place.corner + place.across * tile.widthPx + place.down * tile.heightPx;
  const Vec2 least = place.corner.cwiseMin(end), most = place.corner.cwiseMax(end);
  const auto across = [&](double x) {
    return static_cast<int>(std::lround(x * size.widthPx / picture.widthPx));
  };
  const auto down = [&](double y) {
    return static_cast<int>(std::lround(y * size.heightPx / picture.heightPx));
  };
  return {.xPx = whole.xPx + across(least.x()),
          .yPx = whole.yPx + down(least.y()),
          .size = PixelSize{across(most.x()) - across(least.x()), down(most.y()) - down(least.y())}};
}

/// The tiles check them.
void addCacheArguments(const RunFlags& flags, std::vector<std::vector<std::string>>& arguments) {
  for (auto& ofTile : arguments) {
    if (!flags.cache.empty()) ofTile.insert(ofTile.end(), {"--cache", flags.cache});
    if (!flags.diskCache.empty()) ofTile.insert(ofTile.end(), {"--disk-cache", flags.diskCache});
    if (!flags.cacheFolder.empty()) ofTile.insert(ofTile.end(), {"--cache-dir", flags.cacheFolder});
  }
}

/// What each tile is told of its window: its own place where the wall file has one; else they show the wall
/// together, in its shape.
Result<std::vector<std::vector<std::string>>> tileArguments(const RunFlags& flags, const Wall& wall) {
  std::vector<std::vector<std::string>> all(wall.tiles.size());
  if (flags.surface != "window") {
    if (!flags.window.empty() || flags.noVsync) {
      return inputError(flags.noVsync ? "--no-vsync" : "--window", "is for windows alone",
                        "leave it out, or add --surface window");
    }
    return all;
  }
  PixelPlace whole;
  if (!flags.window.empty()) {
    const auto place = parsePixelPlace("--window", flags.window);
    if (!place) return place.error();
    whole = *place;
  }
  const WallPicture picture = wallPicture(wall);
  const PixelSize size = whole.size.value_or(PixelSize{picture.widthPx, picture.heightPx});
  for (std::size_t i = 0; i < all.size(); ++i) {
    const TileOutput& output = wall.tiles[i].output;
    if (flags.noVsync) all[i].emplace_back("--no-vsync");
    if (flags.window.empty() && !output.monitor.empty()) {
      all[i].push_back("--monitor=" + output.monitor);
      continue;
    }
    if (flags.window.empty() && output.windowPx) {
      all[i].push_back("--window=" + std::to_string((*output.windowPx)[0]) + "," +
                       std::to_string((*output.windowPx)[1]));
      continue;
    }
    const PixelPlace part = partOf(whole, picture, size, wall.tiles[i], picture.tiles[i]);
    if (part.size->widthPx < 1 || part.size->heightPx < 1)
      return inputError("--window", "is too small for all tiles to be seen", "make it larger");
    // With the size a tile knows before it connects whether the desktop holds its window.
    all[i].push_back("--window=" + std::to_string(part.xPx) + "," + std::to_string(part.yPx) + "," +
                     textOf(*part.size));
    if (steers(flags)) all[i].emplace_back("--pointer");
  }
  return all;
}

/// `perProcess` 0: all in one. `arguments` are by tile; those of its first are a process's.
Status startTiles(TileProcesses& processes, const Wall& wall, std::size_t perProcess,
                  const std::vector<std::vector<std::string>>& arguments) {
  const std::size_t count = wall.tiles.size(), step = perProcess == 0 ? count : std::min(perProcess, count);
  for (std::size_t first = 0; first < count; first += step) {
    std::vector<std::string> names;
    for (std::size_t i = first; i < std::min(count, first + step); ++i)
      names.push_back(wall.tiles[i].name);
    if (Status status = processes.start(std::move(names), arguments[first]); !status) return status;
  }
  return Done{};
}

Status runWall(const RunFlags& flags) {
  if (flags.tilesPerProcess != 1 && flags.surface != "none") {
    return inputError("--tiles-per-process", "a process draws one tile",
                      "leave it out, or add --surface none");
  }
  const auto cullOptions = flags.cull.options();
  if (!cullOptions) return cullOptions.error();
  auto wall = flags.files.readWall();
  if (!wall) return wall.error();
  if (flags.untiled) *wall = wall->untiled();
  if (flags.surface == "window") *wall = asSeen(std::move(*wall));
  auto arguments = tileArguments(flags, *wall);
  if (!arguments) return arguments.error();
  addCacheArguments(flags, *arguments);
  const auto camera = flags.files.readCamera();
  if (!camera) return camera.error();
  const auto program = findTileProgram();
  if (!program) return program.error();
  if (Status status = makeFolder(flags.out); !status) return status;
  const auto scene = flags.files.readScene();
  if (!scene) return scene.error();

  const auto setups = TileSetups::make(*wall);
  if (!setups) return setups.error();
  const auto live = LiveWall::make(flags.live, *scene, *wall, *camera, steers(flags));
  if (!live) return live.error();
  const MasterOptions options = masterOptions(flags, *cullOptions);
  Master master(*scene, *wall, *camera, *setups, options);
  const StopSignals signals(master.io(), [&master] { master.stop(); });
  const auto port = master.listen({"127.0.0.1", "0"});
  if (!port) return port.error();
  TileProcesses tiles(master.io(),
                      {.program = *program,
                       .masterAddress = "127.0.0.1:" + std::to_string(*port),
                       .surface = flags.surface,
                       .singleThreadedDrawing = wall->tiles.size() >= std::thread::hardware_concurrency()});
  if (Status status = startTiles(tiles, *wall, flags.tilesPerProcess, *arguments); !status) return status;
  Progress progress("frames", options.frames);
  Master::Hooks hooks{.whileWaitingForTiles = [&tiles] { return tiles.check(false); },
                      .eachFrame =
                          [&tiles] {
                            if (Status status = tiles.check(true); !status)
                              spdlog::error("{}", status.error().text());
                          },
                      .progress = [&progress](std::uint64_t done, std::uint64_t) { progress.update(done); }};
  (*live)->hookInto(master, hooks);
  auto report = master.run(hooks, false);
  progress.finish();
  tiles.end(std::chrono::milliseconds(200));
  if (!report) {
    if (signals.wasStopped()) return runtimeError("", "stopped before the first frame");
    return report.error();
  }
  report->warpErrorPx = setups->warpErrorPx();
  nameMode(*report, flags.files, flags.cull);
  printSummary(*report);
  return writeReport(flags, *report);
}

}  // namespace

void addRunCommand(CLI::App& tessera, std::vector<Command>& commands) {
  CLI::App* app =
      tessera.add_subcommand("run", "A whole wall on this machine: a master and one process for each tile");
  auto flags = std::make_shared<RunFlags>();
  flags->files.addWall(*app);
  flags->files.addScene(*app);
  flags->files.addHierarchy(*app);
  flags->files.addCamera(*app);
  flags->cull.add(*app);
  flags->stream.add(*app);
  app->add_option("--cache", flags->cache,
                  "Memory for the geometry of each tile, such as 256MB; default: 1GB")
      ->group("Streaming");
  app->add_option("--disk-cache", flags->diskCache,
                  "Disk space for geometry that tiles have at the next start, such as 4GB; default: none")
      ->group("Streaming");
  app->add_option("--cache-dir", flags->cacheFolder, "Folder of the disk cache")->group("Streaming");
  flags->motion.add(*app);
  flags->live.add(*app);
  app->add_flag(
      "--interactive", flags->interactive,
      "Mouse, keyboard and gamepads at the windows move the camera; the keyframes of --camera are the views "
      "of the keys 1 to 9. As a matter of course with --surface window and without --frames");
  app->add_option(
         "--frames", flags->frames,
         "Frames to draw, evenly along the camera path; default: 120, or until Escape where people steer")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{10'000'000}));
  app->add_option("--out", flags->out,
                  "Folder for the stitched pictures and report.json; made where it is missing");
  app->add_option("--picture-every", flags->pictureEvery, "Write the picture of every so-manieth frame")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1'000'000'000}));
  app->add_flag("--no-pictures", flags->noPictures, "Write the report alone");
  app->add_option("--json", flags->json, "Write the report to this file");
  app->add_option("--frame-log", flags->frameLog,
                  "Write every frame's time, pairs and triangles to this file, as JSON Lines");
  app->add_option(
         "--surface", flags->surface,
         "Where tiles draw: offscreen (in memory, by OSMesa), window (on this desktop), egl (in memory, by "
         "the GPU), or none (all but the drawing)")
      ->capture_default_str()
      ->check(CLI::IsMember({"offscreen", "window", "egl", "none"}));
  app->add_option("--window", flags->window,
                  "With --surface window: place of the whole wall on the desktop, X,Y or X,Y,WxH; 0,0 in the "
                  "wall's size where nothing is said");
  app->add_flag("--no-vsync", flags->noVsync, "With --surface window: do not wait for the monitors");
  app->add_option("--tiles-per-process", flags->tilesPerProcess,
                  "With --surface none: so many tiles in each tile process; 0: all in one")
      ->capture_default_str();
  app->add_option("--fps", flags->framesPerSecond,
                  "At most so many frames a second; 0: as fast as the tiles are")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1000.0));
  app->add_option("--frame-deadline", flags->frameDeadlineS,
                  "Seconds after which a tile that has not drawn is left behind")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 3600.0));
  app->add_option("--tiles-deadline", flags->tilesDeadlineS, "Seconds for all tiles to connect")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 3600.0));
  app->add_flag("--untiled", flags->untiled,
                "The whole wall as one tile: with --algorithm none the reference picture");
  commands.push_back({app, [flags] { return runWall(*flags); }});
}

}  // namespace tessera
