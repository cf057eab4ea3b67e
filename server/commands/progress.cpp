#include "server/commands/progress.h"

#include <cstdio>

#include <unistd.h>

namespace tessera {

namespace {
constexpr std::uint64_t kBarWidth = 40;
constexpr std::chrono::milliseconds kRedraw{100};
}  // namespace

Progress::Progress(std::string what, std::uint64_t all)
    : what_(std::move(what)),
      all_(all),
      isTerminal_(::isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()),
      lastDrawn_(start_ - kRedraw) {}

void Progress::update(std::uint64_t done) {
  if (all_ == 0) return;
  const auto now = std::chrono::steady_clock::now();
  if (isTerminal_) {
    if (now - lastDrawn_ < kRedraw && done < all_) return;
    lastDrawn_ = now;
    draw(done);
    drawn_ = true;
  } else if (const std::uint64_t tenth = done * 10 / all_; tenth > lastTenth_) {
    lastTenth_ = tenth;
    draw(done);
  }
}

void Progress::draw(std::uint64_t done) const {
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double rate = seconds > 0 ? static_cast<double>(done) / seconds : 0;
  const std::uint64_t filled = done * kBarWidth / all_;
  const std::string bar = std::string(filled, '#') + std::string(kBarWidth - filled, '.');
  std::fprintf(stderr, "%s[%s] %llu/%llu %s, %.1f/s%s", isTerminal_ ? "\r" : "", bar.c_str(),
               static_cast<unsigned long long>(done), static_cast<unsigned long long>(all_), what_.c_str(),
               rate, isTerminal_ ? "  " : "\n");
  std::fflush(stderr);
}

void Progress::finish() {
  if (drawn_) std::fputc('\n', stderr);
  drawn_ = false;
}

}  // namespace tessera
