#pragma once

#include <cstddef>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/bench/interleaved_cull.h"
#include "server/bench/walk.h"

namespace tessera::bench {

using Json = nlohmann::ordered_json;

/// {"p25": ..., "p50": ..., "p75": ..., "p99": ...}
[[nodiscard]] Json spreadOf(const Samples& samples);
/// The median of each run of `window` consecutive values: a curve along a walk.
[[nodiscard]] std::vector<double> smoothed(const Samples& samples, std::size_t window);
/// The median of the quotients frame by frame, and their quartiles.
[[nodiscard]] Json ratioOf(const Samples& numerator, const Samples& denominator);
[[nodiscard]] Json stepOf(const Walk& walk);
/// Times, tests and pairs of one candidate; its time relative to `base` where there is one.
[[nodiscard]] Json summaryOf(const InterleavedCull::Measured& measured, const Samples* base);

}  // namespace tessera::bench
