#pragma once

#include <cstdint>
#include <string>

namespace tessera {

/// Names the monotonic clock of this machine since its last start: times of two processes can be compared
/// where their ids are equal. Empty where it cannot be told.
[[nodiscard]] std::string hostClockId();

/// The monotonic clock, nanoseconds.
[[nodiscard]] std::int64_t monotonicNs();

/// Processor time of the calling thread so far, nanoseconds; waiting takes none.
[[nodiscard]] std::int64_t threadCpuNs();

/// Largest resident set of this process so far.
[[nodiscard]] std::uint64_t peakResidentBytes();

}  // namespace tessera
