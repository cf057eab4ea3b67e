#pragma once

#include <string>

#include <spdlog/spdlog.h>

namespace tessera {

/// Sends log lines to standard error as "PROGRAM: level: text". The level is TESSERA_LOG
/// (trace, debug, info, warn, error) or info. Called once, at the start of main.
void initLog(const std::string& program);

}  // namespace tessera
