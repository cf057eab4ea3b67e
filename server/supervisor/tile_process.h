#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "common/base/result.h"
#include "common/net/asio.h"

namespace tessera {

/// How to start the tiles of one wall on this machine.
struct TileProcessOptions {
  std::filesystem::path program;  ///< tessera-tile
  std::string masterAddress;
  std::string surface;  ///< as for --surface
  bool singleThreadedDrawing =
      false;  ///< there are no fewer tiles than cores: llvmpipe shall not start threads
};

/// The tile processes of a run, of one tile each or, where nothing is drawn, of several: starts them,
/// forwards what they say to the log, starts one that dies again a few times, ends them all. They die with
/// this process, however it ends. Used by one thread; their output is read on the io context's thread.
class TileProcesses {
 public:
  TileProcesses(net::asio::io_context& io, TileProcessOptions options);
  ~TileProcesses();
  TileProcesses(const TileProcesses&) = delete;
  TileProcesses& operator=(const TileProcesses&) = delete;

  /// Starts one process for the tiles, at least one; `arguments` are for it alone.
  [[nodiscard]] Status start(std::vector<std::string> tileNames, std::vector<std::string> arguments = {});

  /// Collects those that ended. One that fails before it ever was part of the wall is an error with its last
  /// words; `mayRestart`: others are started again, at most three times each.
  [[nodiscard]] Status check(bool mayRestart);

  /// Waits for all to end by themselves, asks the rest with SIGTERM, then kills. At most about a second.
  void end(std::chrono::milliseconds patience);

 private:
  struct Output;
  struct Child {
    std::vector<std::string> tileNames, arguments;
    std::string name;  ///< for people: "tile r0c0"
    pid_t pid = -1;    ///< -1: ended
    int starts = 0;
    std::shared_ptr<Output> output;
  };
  Status launch(Child& child);
  bool collect(Child& child, int& status);

  net::asio::io_context& io_;
  const TileProcessOptions options_;
  std::vector<Child> children_;
};

/// The tessera-tile beside this program, or TESSERA_TILE_PROGRAM.
[[nodiscard]] Result<std::filesystem::path> findTileProgram();

}  // namespace tessera
