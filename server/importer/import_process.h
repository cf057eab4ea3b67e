#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "common/base/result.h"
#include "common/scene/load_scene.h"

namespace tessera {

/// What is imported, and how.
struct ImportJob {
  std::filesystem::path scene;
  UpAxis up = UpAxis::Auto;
  HierarchyKind hierarchy = HierarchyKind::Graph;
  std::uint64_t maxTrianglesPerLeaf = 0;
};

/// How much an import may take.
struct ImportLimits {
  std::chrono::milliseconds time{600'000};
  std::uint64_t memoryBytes = 0;  ///< of address space; 0: three quarters of the machine's memory
};

/// What the process that imports is told and answers, one JSON object a line.
struct ImportOrder {
  ImportJob job;
  std::filesystem::path store;
  std::string entry;              ///< name of the index in the store
  std::string sceneSha256;        ///< of the file as the one who ordered it saw it
  std::uint64_t memoryBytes = 0;  ///< of address space; 0: no limit
};

/// Runs the import in a process of its own, which may crash, hang or eat memory without harm to this one:
/// each of these is one error. On success the index stands in the store. `progress` is told shares of 0 to 1;
/// it may be empty. The child is this program's own file with kImportWorkerCommand.
[[nodiscard]] Status runImportProcess(const ImportOrder& order, const ImportLimits& limits,
                                      const std::function<void(double)>& progress);

inline constexpr const char* kImportWorkerCommand = "import-worker";

/// The other side: reads the order from standard input, confines itself (sandbox.h), imports, and answers on
/// standard output. Returns the exit status of the process.
[[nodiscard]] int runImportWorker();

}  // namespace tessera
