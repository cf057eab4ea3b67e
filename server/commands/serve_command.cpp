#include <cstdio>
#include <memory>

#include <spdlog/spdlog.h>

#include "common/base/file.h"
#include "server/commands/commands.h"
#include "server/commands/inputs.h"
#include "server/commands/live_wall.h"
#include "server/commands/stop_signals.h"
#include "server/master/master.h"

namespace tessera {

namespace {

struct ServeFlags {
  InputFiles files;
  CullFlags cull;
  StreamFlags stream;
  MotionFlags motion;
  std::string listen = "0.0.0.0:7400", json;
  std::uint64_t frames = 0;
  LiveFlags live;
  bool interactive = false;
  double framesPerSecond = 60, frameDeadlineS = 1, tilesDeadlineS = 60;
};

Status serve(const ServeFlags& flags) {
  const auto cullOptions = flags.cull.options();
  if (!cullOptions) return cullOptions.error();
  const auto wall = flags.files.readWall();
  if (!wall) return wall.error();
  const auto camera = flags.files.readCamera();
  if (!camera) return camera.error();
  const auto address = net::parseHostPort(flags.listen);
  if (!address) return address.error();
  const auto scene = flags.files.readScene();
  if (!scene) return scene.error();

  MasterOptions options;
  options.cull = *cullOptions;
  options.planeSource = flags.cull.planeSource();
  options.motion = flags.motion.options;
  options.stream = flags.stream.stream();
  options.frames = flags.frames;
  options.framesPerSecond = flags.framesPerSecond;
  options.frameDeadline = std::chrono::milliseconds(static_cast<int>(flags.frameDeadlineS * 1000));
  options.tilesDeadline = std::chrono::milliseconds(static_cast<int>(flags.tilesDeadlineS * 1000));
  const auto setups = TileSetups::make(*wall);
  if (!setups) return setups.error();
  const auto live = LiveWall::make(flags.live, *scene, *wall, *camera, flags.interactive);
  if (!live) return live.error();
  Master master(*scene, *wall, *camera, *setups, options);
  const StopSignals signals(master.io(), [&master] { master.stop(); });
  const auto port = master.listen(*address);
  if (!port) return port.error();
  // Scripts that asked for port 0 read the number from here.
  std::printf("listening on %s:%u for %zu tiles\n", address->host.c_str(), unsigned{*port},
              wall->tiles.size());
  std::fflush(stdout);
  Master::Hooks hooks{.whileWaitingForTiles = [] { return Status(Done{}); }, .eachFrame = {}, .progress = {}};
  (*live)->hookInto(master, hooks);
  auto report = master.run(hooks, true);
  if (!report) return report.error();
  report->warpErrorPx = setups->warpErrorPx();
  nameMode(*report, flags.files, flags.cull);
  if (!flags.json.empty()) return writeFileAtomically(flags.json, report->json());
  return Done{};
}

}  // namespace

void addServeCommand(CLI::App& tessera, std::vector<Command>& commands) {
  CLI::App* app =
      tessera.add_subcommand("serve", "The master alone; tiles connect from elsewhere (tessera-tile)");
  auto flags = std::make_shared<ServeFlags>();
  flags->files.addWall(*app);
  flags->files.addScene(*app);
  flags->files.addHierarchy(*app);
  flags->files.addCamera(*app);
  flags->cull.add(*app);
  flags->stream.add(*app);
  flags->motion.add(*app);
  flags->live.add(*app);
  app->add_flag(
      "--interactive", flags->interactive,
      "Mouse, keyboard and gamepads at the tiles' windows move the camera; the keyframes of --camera are "
      "the views of the keys 1 to 9");
  app->add_option("--listen", flags->listen,
                  "Address to listen on, HOST:PORT; anyone who reaches it may be a tile")
      ->capture_default_str()
      ->envname("TESSERA_LISTEN");
  app->add_option("--frames", flags->frames,
                  "End after so many frames; 0: fly the path over and over until stopped")
      ->capture_default_str();
  app->add_option("--fps", flags->framesPerSecond,
                  "At most so many frames a second; 0: as fast as the tiles are")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1000.0));
  app->add_option("--frame-deadline", flags->frameDeadlineS,
                  "Seconds after which a tile that has not drawn is left behind")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 3600.0));
  app->add_option("--tiles-deadline", flags->tilesDeadlineS,
                  "Seconds to wait for all tiles before starting without some")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 86400.0));
  app->add_option("--json", flags->json, "Write the report to this file at the end");
  commands.push_back({app, [flags] { return serve(*flags); }});
}

}  // namespace tessera
