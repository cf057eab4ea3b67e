#pragma once

#include <atomic>
#include <csignal>
#include <functional>

#include <spdlog/spdlog.h>

#include "common/net/asio.h"

namespace tessera {

/// Calls `stop` once, on the io context's thread, when SIGINT or SIGTERM comes. A second one ends the process
/// at once (its tiles die with it).
class StopSignals {
 public:
  StopSignals(net::asio::io_context& io, std::function<void()> stop)
      : set_(io, SIGINT, SIGTERM), stop_(std::move(stop)) {
    wait();
  }
  [[nodiscard]] bool wasStopped() const { return count_ > 0; }

 private:
  void wait() {
    set_.async_wait([this](const net::error_code& ec, int signal) {
      if (ec) return;
      if (++count_ > 1) std::_Exit(128 + signal);
      spdlog::info("stopping");
      stop_();
      wait();
    });
  }

  net::asio::signal_set set_;
  std::function<void()> stop_;
  std::atomic<int> count_{0};
};

}  // namespace tessera
