#pragma once

#include <cstdint>

#include "common/base/result.h"
#include "server/bench/report.h"

namespace tessera::bench {

struct FanoutOptions {
  unsigned receivers = 16;
  std::uint64_t bytes = 500'000'000;  ///< that each receiver gets, in messages of about 4 MB
  unsigned runs = 3;
};

/// How fast one sender gets the same geometry to many receivers, processes of their own on this machine, over
/// loopback: as messages of the protocol (net::Connection), received and dropped or their assets also held
/// against their hashes, and as bare bytes over the same sockets in writes and reads of the same size. All in
/// turn in each run; MB/s, of all receivers together, and the medians. To be called before any thread is
/// started, as it forks.
[[nodiscard]] Result<Json> measureFanout(const FanoutOptions& options);

}  // namespace tessera::bench
