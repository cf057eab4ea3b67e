#include "server/importer/import_process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <optional>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/importer/import_messages.h"

namespace tessera {

namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::json;

constexpr std::size_t kMaxAnswerBytes = 1 << 20;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

std::uint64_t memoryLimitOf(const ImportLimits& limits) {
  if (limits.memoryBytes > 0) return limits.memoryBytes;
  const long pages = ::sysconf(_SC_PHYS_PAGES), bytes = ::sysconf(_SC_PAGESIZE);
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(bytes) / 4 * 3;
}

std::string inWords(std::uint64_t bytes) {
  return std::to_string(bytes >> 20) + " MB";
}

std::string inWords(std::chrono::milliseconds time) {
  const auto tenths = time.count() / 100;
  return std::to_string(tenths / 10) + (tenths % 10 == 0 ? "" : "." + std::to_string(tenths % 10)) + " s";
}

/// A child process and the pipes to it; killed and collected when it goes.
class Worker {
 public:
  Worker() = default;
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
    for (const int fd : {in_, out_}) {
      if (fd >= 0) ::close(fd);
    }
  }

  Status start() {
    int toChild[2], fromChild[2];
    if (::pipe2(toChild, O_CLOEXEC) != 0) return failure("no pipe");
    if (::pipe2(fromChild, O_CLOEXEC) != 0) {
      ::close(toChild[0]), ::close(toChild[1]);
      return failure("no pipe");
    }
    const pid_t parent = ::getpid();
    pid_ = ::fork();
    if (pid_ == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (::getppid() != parent) ::_exit(127);  // the parent died in between
      ::setpgid(0, 0);                          // Ctrl-C is for the parent
      sigset_t none;
      ::sigemptyset(&none);
      ::sigprocmask(SIG_SETMASK, &none, nullptr);
      ::dup2(toChild[0], STDIN_FILENO);
      ::dup2(fromChild[1], STDOUT_FILENO);
      // What a reader says of a stranger's file is not for the user's terminal.
      ::dup2(::open("/dev/null", O_RDWR | O_CLOEXEC), STDERR_FILENO);
      ::execl("/proc/self/exe", "tessera", kImportWorkerCommand, static_cast<char*>(nullptr));
      ::_exit(127);
    }
    ::close(toChild[0]), ::close(fromChild[1]);
    in_ = toChild[1], out_ = fromChild[0];
    return pid_ > 0 ? Status(Done{}) : failure("cannot be started");
  }

  /// The order is far smaller than a pipe's buffer.
  void tell(const std::string& order) {
    (void)!::write(in_, order.data(), order.size());
    ::close(std::exchange(in_, -1));
  }

  /// Appends what came until `deadline`; false at the end of the stream or the deadline.
  bool read(std::string& into, Clock::time_point deadline) {
    pollfd waiting{out_, POLLIN, 0};
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    const int found = ::poll(&waiting, 1, static_cast<int>(std::clamp<long long>(left, 0, 1000)));
    if (found == 0 || (found < 0 && errno == EINTR)) return Clock::now() < deadline;
    std::array<char, 4096> block{};
    const ssize_t count = ::read(out_, block.data(), block.size());
    if (count <= 0) return false;
    into.append(block.data(), static_cast<std::size_t>(count));
    return into.size() <= kMaxAnswerBytes;
  }

  /// How it ended; none where it had to be killed.
  std::optional<int> wait(Clock::time_point deadline) {
    int status = 0;
    while (::waitpid(pid_, &status, WNOHANG) == 0) {
      if (Clock::now() >= deadline) return {};
      ::usleep(1000);
    }
    pid_ = -1;
    return status;
  }

 private:
  static Status failure(const char* what) {
    return runtimeError("import", std::string(what) + ": " + std::strerror(errno));
  }

  pid_t pid_ = -1;
  int in_ = -1, out_ = -1;
};

/// Takes whole lines off `text`. The last answer that is no progress stays in `answer`.
void takeLines(std::string& text, const std::function<void(double)>& progress, Json& answer) {
  for (std::size_t end; (end = text.find('\n')) != std::string::npos; text.erase(0, end + 1)) {
    const Json line =
        Json::parse(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), nullptr, false);
    if (!line.is_object()) continue;
    if (line.contains("progress") && line["progress"].is_number()) {
      if (progress) progress(std::clamp(line["progress"].get<double>(), 0.0, 1.0));
    } else if (line.contains("confined") && line["confined"].is_string()) {
      spdlog::debug("{}", runtimeError("import", line["confined"].get<std::string>()).text());
    } else {
      answer = line;
    }
  }
}

Error ended(const ImportOrder& order, const ImportLimits& limits, std::optional<int> status, bool wasLate) {
  const std::string file = order.job.scene.string();
  if (wasLate || !status) {
    return inputError(file, "was not imported within " + inWords(limits.time),
                      "give it longer with --import-timeout, or check the file");
  }
  if (WIFSIGNALED(*status)) {
    return inputError(file, std::string("crashed its reader (") + ::strsignal(WTERMSIG(*status)) + ")",
                      "the file is malformed: export it again, or convert it to .glb");
  }
  return runtimeError(
      file, "its import ended without a word (status " + std::to_string(WEXITSTATUS(*status)) + ")");
}

}  // namespace

Status runImportProcess(const ImportOrder& order, const ImportLimits& limits,
                        const std::function<void(double)>& progress) {
  const auto deadline = Clock::now() + limits.time;
  const std::uint64_t memoryBytes = memoryLimitOf(limits);
  Worker worker;
  if (Status status = worker.start(); !status) return status;
  ImportOrder told = order;
  // The address space of a program with sanitizers says nothing of what it uses.
  told.memoryBytes = kSanitized ? 0 : memoryBytes;
  worker.tell(orderText(told));
  std::string text;
  Json answer;
  while (worker.read(text, deadline))
    takeLines(text, progress, answer);
  takeLines(text, progress, answer);
  const bool wasLate = Clock::now() >= deadline;
  const auto status = worker.wait(std::max(deadline, Clock::now() + std::chrono::milliseconds(200)));
  if (answer.is_object() && answer.contains("done")) return Done{};
  if (answer.is_object() && answer.contains("memory")) {
    return inputError(order.job.scene.string(), "needs more than " + inWords(memoryBytes) + " to be imported",
                      "give it more with --import-memory, or check the file");
  }
  if (auto error = errorFrom(answer)) return *error;
  return ended(order, limits, status, wasLate);
}

}  // namespace tessera
