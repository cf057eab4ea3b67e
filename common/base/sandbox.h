#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.h"

namespace tessera {

/// What a process that reads files from strangers may do from now on.
struct SandboxRules {
  /// Folders (with all below) and single files that may be read. They must be there.
  std::vector<std::filesystem::path> readable = {};
  /// Folders in which files may also be written, made, renamed and removed. They must be there.
  std::vector<std::filesystem::path> writable = {};
};

/// What confine() could do on this machine.
struct Confinement {
  bool systemCalls = false;  ///< no network, no other programs, no hand on other processes
  bool files = false;        ///< no file outside of the rules
  std::string missing;       ///< why one of them is false; empty where both are true
};

/// Confines the calling process for good: it can gain no rights; sockets, other programs, new processes,
/// signals to others, tracing, mounting and changes of rights and owners fail with EPERM (seccomp); files
/// outside of the rules fail with EACCES (Landlock). Threads can be started as before. What is open already
/// stays open.
///
/// A kernel without one of the two makes the confinement weaker, which is no error: the result says so. An
/// error: a path of the rules cannot be opened, other threads run already (they would not be confined), or
/// the kernel refused what it said that it can.
[[nodiscard]] Result<Confinement> confine(const SandboxRules& rules);

/// What programs need to read anywhere: libraries and plugins, the dynamic linker's files, the time zone,
/// what a process sees of itself. Only paths that are there.
[[nodiscard]] std::vector<std::filesystem::path> systemReadable();

struct ProcessLimits {
  std::uint64_t addressSpaceBytes = 0;  ///< beyond it allocations fail; 0: as before
  std::uint64_t fileBytes = 0;          ///< beyond it writing fails (EFBIG); 0: as before
};

/// Lowers the limits of the calling process for good, and lets it leave no core file.
[[nodiscard]] Status limitProcess(const ProcessLimits& limits);

}  // namespace tessera
