#include <csignal>
#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>
#include <spdlog/spdlog.h>

#include "common/base/log.h"
#include "server/commands/commands.h"
#include "server/importer/import_process.h"

namespace {

int fail(const tessera::Error& error) {
  std::fprintf(stderr, "tessera: error: %s\n", error.text().c_str());
  return error.exitStatus();
}

}  // namespace

int main(int argc, char** argv) {
  tessera::initLog("tessera");
  // A file that may grow no further is an error of the write, as a full disk is; it must not end the program.
  std::signal(SIGXFSZ, SIG_IGN);
  // Not for users: what openScene starts.
  if (argc == 2 && std::string_view(argv[1]) == tessera::kImportWorkerCommand)
    return tessera::runImportWorker();
  CLI::App app{"A tiled display wall: one master culls the scene and sends each tile what it sees."};
  app.set_version_flag("--version", TESSERA_VERSION);
  app.require_subcommand(1);
  std::vector<tessera::Command> commands;
  tessera::addRunCommand(app, commands);
  tessera::addServeCommand(app, commands);
  tessera::addImportCommand(app, commands);
  tessera::addCheckCommand(app, commands);
  tessera::addCullCommand(app, commands);
  tessera::addBenchCommands(app, commands);
  tessera::addSceneCommands(app, commands);
  tessera::addWallCommands(app, commands);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForAllHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForVersion& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    return fail(tessera::inputError("command line", e.what(), "see --help"));
  }
  try {
    for (const tessera::Command& command : commands) {
      if (!command.app->parsed()) continue;
      if (const tessera::Status status = command.run(); !status) return fail(status.error());
    }
  } catch (const std::bad_alloc&) {
    return fail(tessera::runtimeError("", "not enough memory"));
  } catch (const std::exception& e) {
    return fail(tessera::runtimeError("", e.what()));
  }
  return 0;
}
