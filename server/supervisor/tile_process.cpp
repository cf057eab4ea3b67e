#include "server/supervisor/tile_process.h"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <signal.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tessera {

namespace {

constexpr int kMaxStarts = 4;
constexpr std::size_t kLastWordsBytes = 2048;

std::string endingOf(int status) {
  if (WIFSIGNALED(status)) return std::string("was ended by the signal ") + ::strsignal(WTERMSIG(status));
  return "ended with exit status " + std::to_string(WEXITSTATUS(status));
}

std::string nameOf(const std::vector<std::string>& tiles) {
  if (tiles.size() == 1) return "tile " + tiles.front();
  return "tiles " + tiles.front() + " to " + tiles.back();
}

/// Whether some child of this process has ended and waits to be collected; one call, however many there are.
bool hasEndedChild() {
  siginfo_t info{};
  return ::waitid(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid != 0;
}

/// The environment of this process, with the variables for a tile's drawing.
std::vector<std::string> tileEnvironment(bool singleThreaded) {
  std::vector<std::string> environment;
  for (char** entry = environ; *entry; ++entry) {
    const std::string_view text = *entry;
    if (singleThreaded && text.starts_with("LP_NUM_THREADS=")) continue;
    environment.emplace_back(text);
  }
  if (singleThreaded) environment.emplace_back("LP_NUM_THREADS=0");
  return environment;
}

std::vector<char*> pointers(std::vector<std::string>& strings) {
  std::vector<char*> out;
  for (std::string& s : strings)
    out.push_back(s.data());
  out.push_back(nullptr);
  return out;
}

}  // namespace

/// Standard error of one child, read as it comes.
struct TileProcesses::Output : std::enable_shared_from_this<Output> {
  Output(net::asio::io_context& io, int fd, std::string whose) : pipe(io, fd), name(std::move(whose)) {}

  void readOn() {
    pipe.async_read_some(net::asio::buffer(block),
                         [self = shared_from_this()](const net::error_code& ec, std::size_t n) {
                           if (ec) return;
                           self->take(std::string_view(self->block.data(), n));
                           self->readOn();
                         });
  }

  void take(std::string_view text) {
    const std::lock_guard lock(mutex);
    partial.append(text);
    for (std::size_t end; (end = partial.find('\n')) != std::string::npos; partial.erase(0, end + 1)) {
      const std::string line = partial.substr(0, end);
      spdlog::info("{}: {}", name, line);
      lastLine = line;
    }
    if (partial.size() > kLastWordsBytes) partial.erase(0, partial.size() - kLastWordsBytes);
  }

  std::string lastWords() {
    const std::lock_guard lock(mutex);
    return partial.empty() ? lastLine : partial;
  }

  net::asio::posix::stream_descriptor pipe;
  const std::string name;
  std::array<char, 1024> block{};
  std::mutex mutex;
  std::string partial, lastLine;
};

TileProcesses::TileProcesses(net::asio::io_context& io, TileProcessOptions options)
    : io_(io), options_(std::move(options)) {}

TileProcesses::~TileProcesses() {
  end(std::chrono::milliseconds(0));
}

Status TileProcesses::start(std::vector<std::string> tileNames, std::vector<std::string> arguments) {
  std::string name = nameOf(tileNames);
  children_.push_back({.tileNames = std::move(tileNames),
                       .arguments = std::move(arguments),
                       .name = std::move(name),
                       .output = nullptr});
  return launch(children_.back());
}

Status TileProcesses::launch(Child& child) {
  std::vector<std::string> arguments = {options_.program.string(), "--connect", options_.masterAddress,
                                        "--surface", options_.surface};
  for (const std::string& tile : child.tileNames)
    arguments.insert(arguments.end(), {"--tile", tile});
  arguments.insert(arguments.end(), child.arguments.begin(), child.arguments.end());
  std::vector<std::string> environment = tileEnvironment(options_.singleThreadedDrawing);
  // All that allocates is done before the fork: this process has threads.
  const std::vector<char*> argv = pointers(arguments), envp = pointers(environment);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    return runtimeError(child.name, std::string("no pipe: ") + std::strerror(errno));
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(127);  // the parent died in between
    ::setpgid(0, 0);                          // Ctrl-C is for the master, which ends the tiles in order
    sigset_t none;
    ::sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    ::dup2(ends[1], STDERR_FILENO);
    const int nowhere = ::open("/dev/null", O_RDWR);
    ::dup2(nowhere, STDIN_FILENO);
    ::dup2(nowhere, STDOUT_FILENO);
    ::execve(argv[0], argv.data(), envp.data());
    const char* reason = std::strerror(errno);
    (void)!::write(STDERR_FILENO, reason, std::strlen(reason));
    ::_exit(127);
  }
  ::close(ends[1]);
  if (pid < 0) {
    ::close(ends[0]);
    return runtimeError(child.name, std::string("cannot be started: ") + std::strerror(errno));
  }
  child.pid = pid;
  ++child.starts;
  child.output = std::make_shared<Output>(io_, ends[0], child.name);
  net::asio::post(io_, [output = child.output] { output->readOn(); });
  return Done{};
}

bool TileProcesses::collect(Child& child, int& status) {
  if (child.pid < 0 || ::waitpid(child.pid, &status, WNOHANG) != child.pid) return false;
  child.pid = -1;
  return true;
}

Status TileProcesses::check(bool mayRestart) {
  if (!hasEndedChild()) return Done{};
  for (Child& child : children_) {
    int status = 0;
    if (!collect(child, status)) continue;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // for what is still in the pipe
    const std::string words = child.output->lastWords();
    const Error died = runtimeError(
        child.name, "its process " + endingOf(status) + (words.empty() ? "" : ", its last words: " + words));
    if (!mayRestart) return died;
    if (child.starts >= kMaxStarts) {
      spdlog::error("{}; it is not started again", died.text());
      continue;
    }
    spdlog::warn("{}; starting it again", died.text());
    if (Status started = launch(child); !started) return started;
  }
  return Done{};
}

void TileProcesses::end(std::chrono::milliseconds patience) {
  const auto waitFor = [this](std::chrono::milliseconds limit) {
    const auto deadline = std::chrono::steady_clock::now() + limit;
    for (;;) {
      bool running = false;
      for (Child& child : children_) {
        int status = 0;
        if (child.pid >= 0 && !collect(child, status)) running = true;
      }
      if (!running || std::chrono::steady_clock::now() >= deadline) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  };
  const auto signalAll = [this](int signal) {
    for (const Child& child : children_) {
      if (child.pid >= 0) ::kill(child.pid, signal);
    }
  };
  waitFor(patience);
  signalAll(SIGTERM);
  waitFor(std::chrono::milliseconds(200));
  signalAll(SIGKILL);
  waitFor(std::chrono::milliseconds(500));
}

Result<std::filesystem::path> findTileProgram() {
  if (const char* named = std::getenv("TESSERA_TILE_PROGRAM")) return std::filesystem::path(named);
  std::error_code ec;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", ec);
  std::filesystem::path program = self.parent_path() / "tessera-tile";
  if (ec || !std::filesystem::exists(program, ec)) {
    return runtimeError(program.string(), "the tile program is missing",
                        "build it, or name it in TESSERA_TILE_PROGRAM");
  }
  return program;
}

}  // namespace tessera
