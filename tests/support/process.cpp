#include "tests/support/process.h"

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tessera::test {

namespace fs = std::filesystem;

namespace {

std::string slurp(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

template <class Done>
bool poll(std::chrono::milliseconds deadline, Done done) {
  const auto end = std::chrono::steady_clock::now() + deadline;
  while (!done()) {
    if (std::chrono::steady_clock::now() >= end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

std::string freshName(const char* kind) {
  static std::atomic<int> count{0};
  return fs::temp_directory_path() /
         ("tessera-test-" + std::to_string(::getpid()) + "-" + std::to_string(++count) + "-" + kind);
}

}  // namespace

Process::Process(const std::vector<std::string>& arguments,
                 const std::map<std::string, std::string>& environment)
    : outFile_(freshName("out")), errFile_(freshName("err")) {
  std::vector<std::string> copy = arguments;
  std::vector<char*> argv;
  for (std::string& a : copy)
    argv.push_back(a.data());
  argv.push_back(nullptr);
  std::ofstream(outFile_).close();
  std::ofstream(errFile_).close();
  pid_ = ::fork();
  if (pid_ == 0) {
    ::setpgid(0, 0);
    // Scenes that tests import are no business of the user's own store.
    ::setenv("TESSERA_STORE", (std::string(TESSERA_BIN_DIR) + "/../test-store").c_str(), 0);
    for (const auto& [name, value] : environment)
      ::setenv(name.c_str(), value.c_str(), 1);
    ::dup2(::open("/dev/null", O_RDONLY), 0);
    ::dup2(::open(outFile_.c_str(), O_WRONLY | O_APPEND), 1);
    ::dup2(::open(errFile_.c_str(), O_WRONLY | O_APPEND), 2);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
}

Process::~Process() {
  if (!ended()) {
    ::kill(-pid_, SIGKILL);
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, &status_, 0);
  }
  fs::remove(outFile_);
  fs::remove(errFile_);
}

void Process::signal(int number) const {
  ::kill(pid_, number);
}

bool Process::ended() const {
  if (!reaped_ && ::waitpid(pid_, &status_, WNOHANG) == pid_) reaped_ = true;
  return reaped_;
}

Outcome Process::wait(std::chrono::milliseconds deadline) {
  Outcome outcome;
  if (poll(deadline, [this] { return ended(); })) {
    outcome.status = WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
  } else {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, &status_, 0);
    reaped_ = true;
  }
  outcome.out = out();
  outcome.err = err();
  return outcome;
}

std::string Process::out() const {
  return slurp(outFile_);
}
std::string Process::err() const {
  return slurp(errFile_);
}

bool Process::waitForOut(const std::string& text, std::chrono::milliseconds deadline) const {
  (void)poll(deadline, [&] { return out().find(text) != std::string::npos || ended(); });
  return out().find(text) != std::string::npos;
}

bool Process::waitForErr(const std::string& text, std::chrono::milliseconds deadline) const {
  (void)poll(deadline, [&] { return err().find(text) != std::string::npos || ended(); });
  return err().find(text) != std::string::npos;
}

Outcome run(const std::vector<std::string>& arguments, std::chrono::milliseconds deadline,
            const std::map<std::string, std::string>& environment) {
  return Process(arguments, environment).wait(deadline);
}

TemporaryFolder::TemporaryFolder() : path_(freshName("folder")) {
  fs::create_directories(path_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::string TemporaryFolder::write(const std::string& name, const std::string& content) const {
  std::ofstream(path_ + "/" + name, std::ios::binary) << content;
  return path_ + "/" + name;
}

std::string program(const std::string& name) {
  return std::string(TESSERA_BIN_DIR) + "/" + name;
}

std::string sharedScene(const std::string& name) {
  const fs::path path = fs::path(TESSERA_SOURCE_DIR).parent_path() / "shared/scenes" / name;
  return fs::exists(path) ? path.string() : std::string();
}

std::string config(const std::string& name) {
  return std::string(TESSERA_SOURCE_DIR) + "/configs/" + name;
}

}  // namespace tessera::test
