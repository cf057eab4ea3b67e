#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace tessera {

/// A progress bar on standard error: redrawn in place on a terminal, a line at every tenth otherwise.
class Progress {
 public:
  /// `all` 0: the end is not known, nothing is drawn.
  Progress(std::string what, std::uint64_t all);
  void update(std::uint64_t done);
  /// Ends the line.
  void finish();

 private:
  void draw(std::uint64_t done) const;
  const std::string what_;
  const std::uint64_t all_;
  const bool isTerminal_;
  std::uint64_t lastTenth_ = 0;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point start_, lastDrawn_;
};

}  // namespace tessera
