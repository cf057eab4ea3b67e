#include <cstdio>
#include <map>

#include <CLI/CLI.hpp>
#include <spdlog/spdlog.h>

#include "client/tile_client.h"
#include "common/base/log.h"

namespace {

int fail(const tessera::Error& error) {
  std::fprintf(stderr, "tessera-tile: error: %s\n", error.text().c_str());
  return error.exitStatus();
}

}  // namespace

int main(int argc, char** argv) {
  using tessera::proto::SurfaceKind;
  tessera::initLog("tessera-tile");
  CLI::App app{"One tile of a tessera wall: draws what the master sends, and nothing else."};
  app.set_version_flag("--version", TESSERA_VERSION);
  std::string address;
  tessera::TileOptions options;
  double connectS = 10;
  app.add_option("--connect", address, "The master's address, HOST:PORT")
      ->required()
      ->envname("TESSERA_CONNECT");
  app.add_option(
         "--tile", options.tileNames,
         "Name of the tile in the wall file, for example r0c1; with --surface none also several, each "
         "with a --tile of its own")
      ->required()
      ->allow_extra_args(false)
      ->envname("TESSERA_TILE");
  const std::map<std::string, SurfaceKind> surfaces = {{"offscreen", SurfaceKind::Offscreen},
                                                       {"none", SurfaceKind::None}};
  app.add_option("--surface", options.surface,
                 "Where to draw: offscreen (in memory, by OSMesa) or none (all but the drawing)")
      ->transform(CLI::CheckedTransformer(surfaces, CLI::ignore_case))
      ->default_str("offscreen")
      ->envname("TESSERA_SURFACE");
  app.add_option("--connect-timeout", connectS, "Seconds to wait for the master")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 3600.0));
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForVersion& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    return fail(tessera::inputError("command line", e.what(), "see tessera-tile --help"));
  }
  if (options.tileNames.size() > 1 && options.surface != SurfaceKind::None) {
    return fail(tessera::inputError("--tile", "a process draws one tile",
                                    "start a process for each, or add --surface none"));
  }
  const auto master = tessera::net::parseHostPort(address);
  if (!master) return fail(master.error());
  options.master = *master;
  options.connectDeadline = std::chrono::milliseconds(static_cast<int>(connectS * 1000));
  try {
    if (const tessera::Status status = tessera::runTiles(options); !status) return fail(status.error());
  } catch (const std::exception& e) {
    return fail(tessera::runtimeError("", e.what()));
  }
  return 0;
}
