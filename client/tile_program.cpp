#include "client/tile_program.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "client/tile_client.h"
#include "common/assets/store_folder.h"
#include "common/base/log.h"

namespace tessera {

namespace {

using proto::SurfaceKind;

/// A tile that dies loses the pack that it is writing.
constexpr std::uint64_t kDiskPackBytes = std::uint64_t{8} << 20;

struct Flags {
  std::string address, window;
  TileOptions tile;
  SurfaceOptions surface;
  double connectS = 10;
  int eglDevice = 0;
  std::uint64_t diskBytes = 0;
  std::string cacheFolder;
};

int fail(const Error& error) {
  std::fprintf(stderr, "tessera-tile: error: %s\n", error.text().c_str());
  return error.exitStatus();
}

void addFlags(CLI::App& app, Flags& flags) {
  app.set_version_flag("--version", TESSERA_VERSION);
  app.add_option("--connect", flags.address, "The master's address, HOST:PORT")
      ->required()
      ->envname("TESSERA_CONNECT");
  app.add_option(
         "--tile", flags.tile.tileNames,
         "Name of the tile in the wall file, for example r0c1; with --surface none also several, each "
         "with a --tile of its own")
      ->required()
      ->allow_extra_args(false)
      ->envname("TESSERA_TILE");
  const std::map<std::string, SurfaceKind> surfaces = {{"offscreen", SurfaceKind::Offscreen},
                                                       {"window", SurfaceKind::Window},
                                                       {"egl", SurfaceKind::Egl},
                                                       {"none", SurfaceKind::None}};
  app.add_option("--surface", flags.tile.surface,
                 "Where to draw: offscreen (in memory, by OSMesa), window (on a screen), egl (in memory, by "
                 "the GPU) or none (all but the drawing)")
      ->transform(CLI::CheckedTransformer(surfaces, CLI::ignore_case))
      ->default_str("offscreen")
      ->envname("TESSERA_SURFACE");
  app.add_option("--connect-timeout", flags.connectS, "Seconds to wait for the master")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 3600.0));
  app.add_option("--cache", flags.tile.cacheBytes,
                 "Memory for the geometry of a tile, such as 256MB; what was not seen longest is dropped, "
                 "never what is. 0: no limit")
      ->transform(CLI::AsSizeValue(false))
      ->default_str("1GB")
      ->envname("TESSERA_CACHE");
  app.add_option("--disk-cache", flags.diskBytes,
                 "Disk space, such as 4GB, for geometry that is there at the next start; 0: none")
      ->transform(CLI::AsSizeValue(false))
      ->default_str("0")
      ->envname("TESSERA_DISK_CACHE");
  app.add_option("--cache-dir", flags.cacheFolder,
                 "Folder of the disk cache; default: $XDG_CACHE_HOME/tessera/tiles or ~/.cache/tessera/tiles")
      ->envname("TESSERA_CACHE_DIR");
  const char* windows = "Windows (--surface window)";
  app.add_option("--monitor", flags.surface.monitor,
                 "Full screen on the monitor of this name, such as HDMI-1")
      ->group(windows);
  app.add_option("--window", flags.window,
                 "X,Y: place on the desktop, in pixels from its upper left; X,Y,WxH: the picture is drawn "
                 "that large instead of in the tile's size. 0,0 where nothing is said")
      ->group(windows);
  app.add_flag("--vsync,!--no-vsync", flags.surface.waitsForRetrace,
               "Change the picture between two refreshes of the monitor (the default), or at once")
      ->group(windows);
  app.add_flag("--pointer", flags.surface.showsPointer, "Show the pointer in the window")->group(windows);
  app.add_option("--egl-device", flags.eglDevice, "With --surface egl: draw on this device, counted from 0")
      ->check(CLI::Range(0, 255));
}

/// What the parser cannot know.
Status checkTogether(const CLI::App& app, Flags& flags) {
  const SurfaceKind kind = flags.tile.surface;
  if (flags.tile.tileNames.size() > 1 && kind != SurfaceKind::None) {
    return inputError("--tile", "a process draws one tile",
                      "start a process for each, or add --surface none");
  }
  for (const char* flag : {"--monitor", "--window", "--vsync", "--pointer"}) {
    if (app.count(flag) > 0 && kind != SurfaceKind::Window)
      return inputError(flag, "is for windows alone", "leave it out, or add --surface window");
  }
  if (app.count("--egl-device") > 0) {
    if (kind != SurfaceKind::Egl)
      return inputError("--egl-device", "is for EGL alone", "leave it out, or add --surface egl");
    flags.surface.eglDevice = flags.eglDevice;
  }
  if (app.count("--window") > 0) {
    if (!flags.surface.monitor.empty())
      return inputError("--window", "a window is either full screen or has a place",
                        "leave out --monitor or --window");
    const auto place = parsePixelPlace("--window", flags.window);
    if (!place) return place.error();
    flags.surface.window = *place;
  }
  const auto master = net::parseHostPort(flags.address);
  if (!master) return master.error();
  flags.tile.master = *master;
  flags.tile.connectDeadline = std::chrono::milliseconds(static_cast<int>(flags.connectS * 1000));
  return Done{};
}

/// Comes back only where it fails.
Error become(const char* sibling, char** argv) {
  std::error_code ec;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", ec);
  std::string path = self.parent_path() / sibling;
  if (ec || !std::filesystem::exists(path, ec)) {
    return runtimeError(path, "the program that draws on this surface is missing",
                        "build it and put it there, or choose another --surface");
  }
  std::vector<char*> arguments = {path.data()};
  for (char** argument = argv + 1; *argument; ++argument)
    arguments.push_back(*argument);
  arguments.push_back(nullptr);
  ::execv(path.c_str(), arguments.data());
  return runtimeError(path, std::string("cannot be started: ") + std::strerror(errno));
}

Status run(Flags& flags, char** argv, const TileProgram& program) {
  std::unique_ptr<SurfaceMaker> surfaces;
  if (flags.tile.surface != SurfaceKind::None) {
    surfaces = program.surfacesOf(flags.tile.surface, flags.surface);
    if (!surfaces) return become(program.sibling, argv);
    if (Status status = surfaces->check(); !status) return status;
  }
  if (flags.diskBytes > 0) {
    const auto folder = flags.cacheFolder.empty() ? defaultCacheFolder("tiles")
                                                  : Result(std::filesystem::path(flags.cacheFolder));
    auto disk = folder ? DiskStore::open(
                             {.folder = *folder, .budgetBytes = flags.diskBytes, .packBytes = kDiskPackBytes})
                       : Result<std::unique_ptr<DiskStore>>(folder.error());
    // A tile can do without.
    if (!disk) spdlog::warn("{}; going on without a disk cache", disk.error().text());
    if (disk) flags.tile.disk = std::move(*disk);
  }
  flags.tile.surfaces = surfaces.get();
  return runTiles(flags.tile);
}

}  // namespace

int runTileProgram(int argc, char** argv, const TileProgram& program) {
  initLog("tessera-tile");
  CLI::App app{"One tile of a tessera wall: draws what the master sends, and nothing else."};
  Flags flags;
  addFlags(app, flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForVersion& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    return fail(inputError("command line", e.what(), "see tessera-tile --help"));
  }
  if (const Status status = checkTogether(app, flags); !status) return fail(status.error());
  try {
    if (const Status status = run(flags, argv, program); !status) return fail(status.error());
  } catch (const std::exception& e) {
    return fail(runtimeError("", e.what()));
  }
  return 0;
}

}  // namespace tessera
