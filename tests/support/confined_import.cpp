#include "tests/support/confined_import.h"

#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/base/sandbox.h"
#include "common/scene/load_scene.h"

namespace tessera::test {

namespace {

constexpr std::uint64_t kMemoryBytes = std::uint64_t{2} << 30;
constexpr int kOutOfMemory = 3, kBroken = 4, kNotConfined = 5;

int import(const std::filesystem::path& file) {
  ProcessLimits limits;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  limits.addressSpaceBytes = kMemoryBytes;
#endif
  SandboxRules rules{.readable = systemReadable(), .writable = {}};
  rules.readable.push_back(file.parent_path());
  if (!limitProcess(limits) || !confine(rules)) return kNotConfined;
  try {
    const auto scene = loadScene(file);
    if (!scene) {
      std::fprintf(stderr, "%s\n", scene.error().text().c_str());
      return scene.error().what.find("more memory") != std::string::npos ? kOutOfMemory
                                                                         : scene.error().exitStatus();
    }
    const Sphere& sphere = scene->sphere();
    return !scene->leaves.empty() && sphere.center.allFinite() && std::isfinite(sphere.radius) ? 0 : kBroken;
  } catch (const std::bad_alloc&) {
    return kOutOfMemory;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "exception: %s\n", e.what());
    return kBroken;
  }
}

}  // namespace

const char* nameOf(ImportEnd end) {
  constexpr const char* kNames[kImportEnds] = {"good", "refused", "memory", "crashed", "timed out", "broken"};
  return kNames[static_cast<std::size_t>(end)];
}

ConfinedImport::ConfinedImport(const std::filesystem::path& file, std::chrono::milliseconds deadline,
                               bool isShown)
    : deadline_(std::chrono::steady_clock::now() + deadline) {
  pid_ = ::fork();
  if (pid_ != 0) return;
  if (!isShown) {
    const int null = ::open("/dev/null", O_WRONLY);
    ::dup2(null, STDOUT_FILENO);
    ::dup2(null, STDERR_FILENO);
  }
  // What handlers this process has are not the child's.
  for (const int number : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL})
    ::signal(number, SIG_DFL);
  ::_exit(import(file));
}

ConfinedImport::~ConfinedImport() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

bool ConfinedImport::poll() {
  if (pid_ <= 0) return true;
  const bool isLate = std::chrono::steady_clock::now() > deadline_;
  if (isLate) ::kill(pid_, SIGKILL);
  if (::waitpid(pid_, &status_, isLate ? 0 : WNOHANG) == 0) return false;
  pid_ = -1;
  if (WIFSIGNALED(status_)) {
    end_ = isLate && WTERMSIG(status_) == SIGKILL ? ImportEnd::TimedOut : ImportEnd::Crashed;
  } else {
    switch (WEXITSTATUS(status_)) {
      case 0:
        end_ = ImportEnd::Good;
        break;
      case 1:
      case 2:
        end_ = ImportEnd::Refused;
        break;
      case kOutOfMemory:
        end_ = ImportEnd::Memory;
        break;
      default:
        end_ = ImportEnd::Broken;
    }
  }
  return true;
}

std::string ConfinedImport::detail() const {
  if (WIFSIGNALED(status_)) return std::string("signal ") + ::strsignal(WTERMSIG(status_));
  return "exit status " + std::to_string(WEXITSTATUS(status_));
}

}  // namespace tessera::test
