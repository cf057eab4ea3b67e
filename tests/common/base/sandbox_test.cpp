#include "common/base/sandbox.h"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <new>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr int kCannot = 77;

/// Two folders, one within the rules and one not.
class SandboxTest : public ::testing::Test {
 protected:
  SandboxTest() {
    char name[] = "/tmp/tessera-sandbox-XXXXXX";
    root_ = ::mkdtemp(name);
    for (const char* folder : {"read", "write", "write/a", "write/b", "outside"}) {
      fs::create_directory(root_ / folder);
      std::ofstream(root_ / folder / "file") << "content";
    }
    fs::create_symlink(root_ / "outside/file", root_ / "read/link");
  }
  ~SandboxTest() override { fs::remove_all(root_); }

  [[nodiscard]] SandboxRules rules() const {
    SandboxRules rules{.readable = systemReadable(), .writable = {root_ / "write"}};
    rules.readable.push_back(root_ / "read");
    return rules;
  }

  /// What `body` returns in a child that is confined: 0 for all is well, else which check failed.
  int confined(const std::function<int()>& body) const {
    const pid_t child = ::fork();
    if (child == 0) {
      const auto done = confine(rules());
      ::_exit(!done ? 101 : !done->files || !done->systemCalls ? kCannot : body());
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  fs::path root_;
};

#define EXPECT_CONFINED(body)                                                    \
  do {                                                                           \
    const int outcome = confined(body);                                          \
    if (outcome == kCannot) GTEST_SKIP() << "this kernel cannot confine at all"; \
    EXPECT_EQ(outcome, 0);                                                       \
  } while (false)

int openFor(const fs::path& path, int flags) {
  errno = 0;
  const int fd = ::open(path.c_str(), flags, 0600);
  return fd >= 0 ? 0 : errno;
}

TEST_F(SandboxTest, FilesOutsideOfTheRulesAreOutOfReach) {
  EXPECT_CONFINED([&] {
    if (openFor(root_ / "read/file", O_RDONLY) != 0) return 1;
    if (openFor(root_ / "write/file", O_RDWR) != 0) return 2;
    if (openFor(root_ / "outside/file", O_RDONLY) != EACCES) return 3;
    if (openFor(root_ / "read/../outside/file", O_RDONLY) != EACCES) return 4;
    if (openFor(root_ / "read/link", O_RDONLY) != EACCES) return 5;
    if (openFor("/etc/passwd", O_RDONLY) != EACCES) return 6;
    if (openFor(root_, O_RDONLY | O_DIRECTORY) != EACCES) return 7;
    if (openFor("/proc/1/environ", O_RDONLY) == 0) return 8;
    if (openFor("/usr/bin", O_RDONLY | O_DIRECTORY) != 0) return 9;
    return 0;
  });
}

TEST_F(SandboxTest, WritingIsForTheFoldersThatAreForIt) {
  EXPECT_CONFINED([&] {
    if (openFor(root_ / "read/file", O_WRONLY) != EACCES) return 1;
    if (openFor(root_ / "read/new", O_WRONLY | O_CREAT) != EACCES) return 2;
    if (openFor(root_ / "write/new", O_WRONLY | O_CREAT) != 0) return 3;
    if (::rename((root_ / "write/new").c_str(), (root_ / "write/a/new").c_str()) != 0) return 4;
    if (::rename((root_ / "write/a/new").c_str(), (root_ / "outside/new").c_str()) == 0) return 5;
    if (::unlink((root_ / "write/a/new").c_str()) != 0) return 6;
    if (::unlink((root_ / "read/file").c_str()) == 0) return 7;
    if (::truncate((root_ / "outside/file").c_str(), 0) == 0) return 8;
    if (::mkdir((root_ / "write/c").c_str(), 0700) != 0) return 9;
    if (::mkdir((root_ / "read/c").c_str(), 0700) == 0) return 10;
    if (::chmod((root_ / "outside/file").c_str(), 0777) == 0 || errno != EPERM) return 11;
    if (::chown((root_ / "outside/file").c_str(), 0, 0) == 0 || errno != EPERM) return 12;
    if (::utimensat(AT_FDCWD, (root_ / "outside/file").c_str(), nullptr, 0) == 0 || errno != EPERM) return 13;
    const int fd = ::open((root_ / "write/file").c_str(), O_RDONLY);
    if (::futimens(fd, nullptr) != 0) return 14;
    return 0;
  });
  EXPECT_EQ(fs::file_size(root_ / "outside/file"), 7u);
}

TEST_F(SandboxTest, ThereIsNoNetworkAndNoOtherProgram) {
  EXPECT_CONFINED([&] {
    for (const int domain : {AF_INET, AF_INET6, AF_UNIX, AF_NETLINK}) {
      if (::socket(domain, SOCK_STREAM, 0) >= 0 || errno != EPERM) return 1;
    }
    int pair[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, pair) == 0 || errno != EPERM) return 2;
    if (::fork() != -1 || errno != EPERM) return 3;
    if (::vfork() != -1) return 4;
    ::execl("/bin/true", "true", nullptr);
    if (errno != EPERM) return 5;
    if (std::system("true") == 0) return 6;
    if (::kill(::getppid(), 0) == 0 || errno != EPERM) return 7;
    if (::kill(::getpid(), 0) != 0) return 8;
    return 0;
  });
}

TEST_F(SandboxTest, ThreadsMemoryAndAbortWorkAsBefore) {
  EXPECT_CONFINED([&] {
    int sum = 0;
    std::thread([&] { sum = 7; }).join();
    const std::string large(50'000'000, 'x');
    return sum == 7 && large.back() == 'x' ? 0 : 1;
  });
  EXPECT_EQ(confined([]() -> int { std::abort(); }), 128 + SIGABRT);
}

TEST_F(SandboxTest, SaysWhatCannotBeConfined) {
  const auto errorOf = [&](const std::function<std::string()>& body) {
    const pid_t child = ::fork();
    if (child == 0) {
      std::ofstream(root_ / "said") << body();
      ::_exit(0);
    }
    ::waitpid(child, nullptr, 0);
    std::ifstream in(root_ / "said");
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_NE(errorOf([&] {
              const auto done = confine({.readable = {root_ / "absent"}});
              return done ? std::string() : done.error().text();
            }).find("absent: cannot be opened"),
            std::string::npos);
  EXPECT_NE(errorOf([&] {
              std::atomic<bool> stop{false};
              std::thread other([&] {
                while (!stop)
                  std::this_thread::yield();
              });
              const auto done = confine({});
              stop = true;
              other.join();
              return done ? std::string() : done.error().text();
            }).find("other threads run already"),
            std::string::npos);
}

TEST_F(SandboxTest, LimitsHold) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers take more memory than this limits";
#endif
  const pid_t child = ::fork();
  if (child == 0) {
    if (!limitProcess({.addressSpaceBytes = 500'000'000, .fileBytes = 1000})) ::_exit(1);
    try {
      const std::string large(600'000'000, 'x');
      ::_exit(large.empty() ? 2 : 3);
    } catch (const std::bad_alloc&) {
    }
    ::signal(SIGXFSZ, SIG_IGN);
    const int fd = ::open((root_ / "write/big").c_str(), O_WRONLY | O_CREAT, 0600);
    if (::pwrite(fd, "x", 1, 2000) == 1 || errno != EFBIG) ::_exit(4);
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

}  // namespace
}  // namespace tessera
