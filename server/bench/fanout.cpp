#include "server/bench/fanout.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/assets/asset_id.h"
#include "common/net/connection.h"
#include "server/bench/fanout_receiver.h"

namespace tessera::bench {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kMessageBytes = 4'000'000, kAssetBytes = 250'000;
/// Different messages: together larger than caches.
constexpr std::size_t kMostMessages = 32;
constexpr std::chrono::milliseconds kDeadline{120'000};
constexpr net::Milliseconds kWriteDeadline{30'000};

struct Kind {
  FanoutReceiver receiver;
  const char* name;
};
constexpr std::array kKinds = {Kind{FanoutReceiver::Bare, "bare TCP"},
                               Kind{FanoutReceiver::BareWhole, "bare TCP, into whole messages"},
                               Kind{FanoutReceiver::Messages, "messages, dropped"},
                               Kind{FanoutReceiver::CheckedAssets, "messages, assets checked by SHA-256"}};

/// What is sent: the same messages over and over.
struct Load {
  std::vector<net::SharedBytes> different;
  std::uint64_t messages = 0, bytes = 0;
  [[nodiscard]] const net::SharedBytes& message(std::uint64_t i) const {
    return different[i % different.size()];
  }
};

Load makeLoad(std::uint64_t bytes) {
  Load load;
  load.messages = std::max<std::uint64_t>(1, bytes / kMessageBytes);
  std::mt19937_64 random(1);
  std::vector<std::uint64_t> noise(kMessageBytes / sizeof(std::uint64_t));
  while (load.different.size() < std::min<std::uint64_t>(load.messages, kMostMessages)) {
    std::generate(noise.begin(), noise.end(), std::ref(random));
    proto::Assets message;
    for (std::size_t at = 0; at + kAssetBytes <= kMessageBytes; at += kAssetBytes) {
      const auto content = std::as_bytes(std::span(noise)).subspan(at, kAssetBytes);
      message.assets.push_back(
          {.id = assetIdOf(content).bytes, .kind = proto::AssetKind::Drawable, .bytes = content});
    }
    load.different.push_back(std::make_shared<const proto::Bytes>(proto::encode(message)));
  }
  for (std::uint64_t i = 0; i < load.messages; ++i)
    load.bytes += load.message(i)->size();
  return load;
}

/// A file descriptor that is closed with this.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] int release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

Error failure(const char* what) {
  return runtimeError("fan-out", std::string(what) + ": " + std::strerror(errno));
}

Result<std::uint16_t> listenAnywhere(const Descriptor& listener) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* any = reinterpret_cast<sockaddr*>(&address);
  if (bind(listener.get(), any, size) != 0 || listen(listener.get(), SOMAXCONN) != 0 ||
      getsockname(listener.get(), any, &size) != 0)
    return failure("cannot listen");
  return ntohs(address.sin_port);
}

/// Waits until one of the descriptors can be read or written. False: the time is over.
bool waitFor(std::span<pollfd> fds, Clock::time_point end) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
  return left > 0 && poll(fds.data(), fds.size(), static_cast<int>(left)) > 0;
}

/// The processes that receive; those left are killed with this.
class Receivers {
 public:
  Receivers() = default;
  Receivers(const Receivers&) = delete;
  Receivers& operator=(const Receivers&) = delete;
  ~Receivers() {
    for (const pid_t pid : pids_) {
      kill(pid, SIGKILL);
      waitpid(pid, nullptr, 0);
    }
  }
  Status start(FanoutReceiver receiver, std::uint16_t port, const Load& load) {
    const pid_t pid = fork();
    if (pid < 0) return failure("cannot fork");
    if (pid == 0) _exit(receiveFanout(receiver, port, load.bytes, load.messages) ? 0 : 1);
    pids_.push_back(pid);
    return Done{};
  }
  /// They have said that all is there, so that they end at once.
  Status finish() {
    bool good = true;
    for (const pid_t pid : std::exchange(pids_, {})) {
      int status = 0;
      good = waitpid(pid, &status, 0) == pid && WIFEXITED(status) && WEXITSTATUS(status) == 0 && good;
    }
    return good ? Status(Done{}) : Status(runtimeError("fan-out", "a receiver has failed"));
  }

 private:
  std::vector<pid_t> pids_;
};

/// Writes the load to all sockets, in turn wherever there is room, until each receiver has answered.
Status sendBare(const std::vector<Descriptor>& sockets, const Load& load, Clock::time_point end) {
  struct Progress {
    std::uint64_t message = 0;
    std::size_t at = 0;
  };
  std::vector<Progress> progress(sockets.size());
  std::vector<pollfd> fds;
  for (const Descriptor& socket : sockets) {
    fcntl(socket.get(), F_SETFL, O_NONBLOCK);
    fds.push_back({.fd = socket.get(), .events = POLLOUT, .revents = 0});
  }
  for (std::size_t left = sockets.size(); left > 0;) {
    if (!waitFor(fds, end)) return runtimeError("fan-out", "nothing moves");
    for (std::size_t i = 0; i < fds.size(); ++i) {
      if (fds[i].revents == 0) continue;
      Progress& mine = progress[i];
      if (mine.message == load.messages) {
        char done = 0;
        if (read(fds[i].fd, &done, 1) != 1) return failure("a receiver is gone");
        fds[i].fd = -1;  // poll() looks no more
        --left;
        continue;
      }
      const proto::Bytes& bytes = *load.message(mine.message);
      const ssize_t sent =
          write(fds[i].fd, bytes.data() + mine.at, std::min(bytes.size() - mine.at, kBareStretchBytes));
      if (sent < 0 && errno == EAGAIN) continue;
      if (sent < 0) return failure("cannot write");
      mine.at += static_cast<std::size_t>(sent);
      if (mine.at < bytes.size()) continue;
      mine = {.message = mine.message + 1, .at = 0};
      if (mine.message == load.messages) fds[i].events = POLLIN;
    }
  }
  return Done{};
}

net::awaitable<void> sendMessages(std::shared_ptr<net::Connection> to, const Load& load,
                                  std::size_t& answers) {
  for (std::uint64_t i = 0; i < load.messages; ++i)
    to->queue(load.message(i));
  to->flush();
  const auto answer = co_await to->read(proto::Expect::FromTile, kDeadline);
  answers += answer ? 1 : 0;
  to->close();
}

Status sendByConnections(std::vector<Descriptor>& sockets, const Load& load) {
  net::asio::io_context io;
  std::size_t answers = 0;
  for (Descriptor& descriptor : sockets) {
    net::tcp::socket socket(io);
    net::error_code ec;
    socket.assign(net::tcp::v4(), descriptor.get(), ec);
    if (ec) return runtimeError("fan-out", ec.message());
    static_cast<void>(descriptor.release());
    const auto connection = std::make_shared<net::Connection>(std::move(socket));
    connection->startWriter(kWriteDeadline);
    net::asio::co_spawn(io, sendMessages(connection, load, answers), net::asio::detached);
  }
  io.run_for(kDeadline);
  return answers == sockets.size() ? Status(Done{})
                                   : Status(runtimeError("fan-out", "a receiver has not answered"));
}

/// Of this process and of those that have ended under it.
double processorUs() {
  double us = 0;
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage = {};
    getrusage(who, &usage);
    for (const timeval& part : {usage.ru_utime, usage.ru_stime})
      us += 1e6 * static_cast<double>(part.tv_sec) + static_cast<double>(part.tv_usec);
  }
  return us;
}

/// Of all receivers together, by the clock and for each second of processor time on either side.
struct Speed {
  double mbPerS = 0, mbPerProcessorS = 0;
};

Result<Speed> measureOnce(const Kind& kind, const Load& load, unsigned count) {
  const Clock::time_point end = Clock::now() + kDeadline;
  const Descriptor listener(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const auto port = listenAnywhere(listener);
  if (!port) return port.error();
  Receivers receivers;
  std::vector<Descriptor> sockets;
  for (unsigned i = 0; i < count; ++i) {
    if (Status status = receivers.start(kind.receiver, *port, load); !status) return status.error();
    pollfd waiting = {.fd = listener.get(), .events = POLLIN, .revents = 0};
    if (!waitFor({&waiting, 1}, end)) return runtimeError("fan-out", "a receiver does not connect");
    sockets.emplace_back(accept4(listener.get(), nullptr, nullptr, SOCK_CLOEXEC));
    if (sockets.back().get() < 0) return failure("cannot accept");
  }
  const auto start = Clock::now();
  const double processorStart = processorUs();
  Status status = kind.receiver <= FanoutReceiver::BareWhole ? sendBare(sockets, load, end)
                                                             : sendByConnections(sockets, load);
  const std::chrono::duration<double, std::micro> us = Clock::now() - start;
  if (status) status = receivers.finish();
  if (!status) return status.error();
  const double bytes = static_cast<double>(load.bytes) * count;
  return Speed{.mbPerS = bytes / us.count(), .mbPerProcessorS = bytes / (processorUs() - processorStart)};
}

double medianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

Result<Json> measureFanout(const FanoutOptions& options) {
  const Load load = makeLoad(options.bytes);
  std::array<std::vector<double>, kKinds.size()> speeds, byProcessor;
  for (unsigned run = 0; run < options.runs; ++run) {
    for (std::size_t turn = 0; turn < kKinds.size(); ++turn) {
      const std::size_t kind = (run + turn) % kKinds.size();
      const auto speed = measureOnce(kKinds[kind], load, options.receivers);
      if (!speed) return speed.error();
      speeds[kind].push_back(speed->mbPerS);
      byProcessor[kind].push_back(speed->mbPerProcessorS);
    }
  }
  Json json = {{"receivers", options.receivers},
               {"bytes_each", load.bytes},
               {"runs", options.runs},
               {"kinds", Json::array()}};
  for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
    json["kinds"].push_back(
        {{"name", kKinds[kind].name},
         {"mb_per_s", speeds[kind]},
         {"median_mb_per_s", medianOf(speeds[kind])},
         {"of_bare", medianOf(speeds[kind]) / medianOf(speeds[0])},
         {"mb_per_processor_s", byProcessor[kind]},
         {"median_mb_per_processor_s", medianOf(byProcessor[kind])},
         {"of_bare_by_processor_time", medianOf(byProcessor[kind]) / medianOf(byProcessor[0])}});
  }
  return json;
}

}  // namespace tessera::bench
