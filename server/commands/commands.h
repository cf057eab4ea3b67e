#pragma once

#include <functional>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/base/result.h"

namespace tessera {

/// A subcommand of `tessera` as it was given on the command line, ready to run. Returns once it is done.
struct Command {
  CLI::App* app = nullptr;
  std::function<Status()> run;
};

void addRunCommand(CLI::App& tessera, std::vector<Command>& commands);
void addImportCommand(CLI::App& tessera, std::vector<Command>& commands);
void addServeCommand(CLI::App& tessera, std::vector<Command>& commands);
void addCheckCommand(CLI::App& tessera, std::vector<Command>& commands);
void addCullCommand(CLI::App& tessera, std::vector<Command>& commands);
void addBenchCommands(CLI::App& tessera, std::vector<Command>& commands);
void addWallCommands(CLI::App& tessera, std::vector<Command>& commands);
void addSceneCommands(CLI::App& tessera, std::vector<Command>& commands);

}  // namespace tessera
