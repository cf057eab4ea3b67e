#include "common/base/sandbox.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "common/base/system_call_filter.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// Landlock as in the kernel's headers of its later versions; Debian 12 has older ones.
struct LandlockRuleset {
  std::uint64_t files = 0;
  std::uint64_t network = 0;  ///< version 4 on
  std::uint64_t scope = 0;    ///< version 6 on
};
struct [[gnu::packed]] LandlockPathRule {
  std::uint64_t allowed = 0;
  std::int32_t parent = -1;
};
constexpr unsigned kVersionFlag = 1;
constexpr int kPathRule = 1;
constexpr std::uint64_t kExecute = 1 << 0, kWriteFile = 1 << 1, kReadFile = 1 << 2, kReadDir = 1 << 3,
                        kRemoveDir = 1 << 4, kRemoveFile = 1 << 5, kMakeDir = 1 << 7, kMakeReg = 1 << 8,
                        kAllOfVersion1 = (1 << 13) - 1, kRefer = 1 << 13, kTruncate = 1 << 14,
                        kIoctlDevice = 1 << 15;
constexpr std::uint64_t kOfFiles = kExecute | kWriteFile | kReadFile | kTruncate | kIoctlDevice;
constexpr std::uint64_t kReading = kReadFile | kReadDir;
constexpr std::uint64_t kWriting =
    kReading | kWriteFile | kRemoveDir | kRemoveFile | kMakeDir | kMakeReg | kRefer | kTruncate;

/// Closes a descriptor at the end.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  operator int() const { return fd_; }  // NOLINT: as a descriptor is used

 private:
  int fd_;
};

Error refused(const char* what) {
  return runtimeError("sandbox", std::string(what) + ": " + std::strerror(errno));
}

Status allow(int ruleset, const fs::path& path, std::uint64_t rights) {
  const Descriptor fd(::open(path.c_str(), O_PATH | O_CLOEXEC));
  if (fd < 0) return inputError(path.string(), std::string("cannot be opened: ") + std::strerror(errno));
  struct stat status {};
  if (::fstat(fd, &status) != 0) return refused("a path cannot be looked at");
  if (!S_ISDIR(status.st_mode)) rights &= kOfFiles;
  const LandlockPathRule rule{rights, fd};
  if (::syscall(SYS_landlock_add_rule, ruleset, kPathRule, &rule, 0) != 0)
    return refused("no rule can be added");
  return Done{};
}

/// True where the kernel holds files back from now on; false with `missing` where it cannot.
Result<bool> confineFiles(const SandboxRules& rules, std::string& missing) {
  const long version = ::syscall(SYS_landlock_create_ruleset, nullptr, 0, kVersionFlag);
  // Version 1 forbids renaming from one folder to another, by which files are published.
  if (version < 2) {
    missing = "this kernel cannot hold files back from a process (no Landlock)";
    return false;
  }
  LandlockRuleset wanted;
  wanted.files = kAllOfVersion1 | kRefer | (version >= 3 ? kTruncate : 0) | (version >= 5 ? kIoctlDevice : 0);
  if (version >= 4) wanted.network = 3;  // binding and connecting
  if (version >= 6) wanted.scope = 3;    // abstract sockets and signals
  const std::size_t size = version >= 6 ? 24 : version >= 4 ? 16 : 8;
  const Descriptor ruleset(static_cast<int>(::syscall(SYS_landlock_create_ruleset, &wanted, size, 0)));
  if (ruleset < 0) return refused("no rules for files can be made");
  for (const fs::path& path : rules.readable) {
    if (Status done = allow(ruleset, path, kReading & wanted.files); !done) return done.error();
  }
  for (const fs::path& path : rules.writable) {
    if (Status done = allow(ruleset, path, kWriting & wanted.files); !done) return done.error();
  }
  if (::syscall(SYS_landlock_restrict_self, static_cast<int>(ruleset), 0) != 0) {
    return refused("the rules for files cannot be set");
  }
  return true;
}

Result<bool> confineSystemCalls(std::string& missing) {
  std::vector<sock_filter> filter = systemCallFilter();
  if (filter.empty()) {
    missing = "system calls of this processor are not known";
    return false;
  }
  const sock_fprog program{static_cast<unsigned short>(filter.size()), filter.data()};
  if (::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &program) == 0) return true;
  if (errno != ENOSYS && errno != EINVAL) return refused("the filter of system calls cannot be set");
  missing = "this kernel cannot filter system calls (no seccomp)";
  return false;
}

bool hasOneThread() {
  std::error_code ec;
  std::size_t threads = 0;
  for (fs::directory_iterator it("/proc/self/task", ec), end; !ec && it != end; it.increment(ec))
    ++threads;
  return ec || threads == 1;
}

Status lower(int resource, std::uint64_t to, const char* what) {
  rlimit limit{};
  ::getrlimit(static_cast<__rlimit_resource_t>(resource), &limit);
  limit.rlim_max = std::min<rlim_t>(limit.rlim_max, to);
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_cur, to);
  if (::setrlimit(static_cast<__rlimit_resource_t>(resource), &limit) != 0) return refused(what);
  return Done{};
}

}  // namespace

Result<Confinement> confine(const SandboxRules& rules) {
  if (!hasOneThread()) {
    return runtimeError("sandbox", "other threads run already", "confine the process before it starts any");
  }
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return refused("gaining rights cannot be forbidden");
  Confinement done;
  auto files = confineFiles(rules, done.missing);
  if (!files) return files.error();
  std::string missing;
  auto calls = confineSystemCalls(missing);
  if (!calls) return calls.error();
  done.files = *files;
  done.systemCalls = *calls;
  if (!done.missing.empty() && !missing.empty()) done.missing += "; ";
  done.missing += missing;
  return done;
}

std::vector<fs::path> systemReadable() {
  std::vector<fs::path> there;
  for (const char* path : {"/usr", "/lib", "/lib64", "/etc/ld.so.cache", "/etc/ld.so.preload",
                           "/etc/localtime", "/etc/ssl/openssl.cnf", "/proc/self", "/proc/cpuinfo",
                           "/proc/meminfo", "/sys/devices/system/cpu", "/dev/null", "/dev/urandom"}) {
    if (::access(path, R_OK) == 0) there.emplace_back(path);
  }
  return there;
}

Status limitProcess(const ProcessLimits& limits) {
  if (Status done = lower(RLIMIT_CORE, 0, "core files cannot be forbidden"); !done) return done;
  if (limits.addressSpaceBytes > 0) {
    if (Status done = lower(RLIMIT_AS, limits.addressSpaceBytes, "memory cannot be limited"); !done)
      return done;
  }
  if (limits.fileBytes > 0) {
    if (Status done = lower(RLIMIT_FSIZE, limits.fileBytes, "files cannot be limited"); !done) return done;
  }
  return Done{};
}

}  // namespace tessera
