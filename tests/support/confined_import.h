#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include <sys/types.h>

namespace tessera::test {

/// How an import in a process of its own ended.
enum class ImportEnd {
  Good,      ///< there is a scene
  Refused,   ///< one error said what is wrong with the file
  Memory,    ///< it needed more than it was given, and said so or was stopped
  Crashed,   ///< a signal ended it
  TimedOut,  ///< it was killed at its deadline
  Broken,    ///< an exception got out, or the scene has bounds that are no numbers: a bug of ours
};
constexpr std::size_t kImportEnds = 6;
[[nodiscard]] const char* nameOf(ImportEnd end);

/// A child of this process that imports one file: confined to the file's folder, to 2 GiB and to a deadline.
/// The child has all that this process has loaded, so it starts at once.
class ConfinedImport {
 public:
  /// `isShown`: what the child says goes to standard error, else nowhere.
  ConfinedImport(const std::filesystem::path& file, std::chrono::milliseconds deadline, bool isShown);
  ~ConfinedImport();
  ConfinedImport(const ConfinedImport&) = delete;
  ConfinedImport& operator=(const ConfinedImport&) = delete;

  /// True once it ended or was killed at its deadline.
  bool poll();
  [[nodiscard]] ImportEnd end() const { return end_; }
  [[nodiscard]] std::string detail() const;  ///< the signal

 private:
  pid_t pid_ = -1;
  std::chrono::steady_clock::time_point deadline_;
  ImportEnd end_ = ImportEnd::Good;
  int status_ = 0;
};

}  // namespace tessera::test
