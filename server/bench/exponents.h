#pragma once

#include <cstdint>
#include <vector>

#include "common/base/result.h"
#include "server/bench/paper_figures.h"
#include "server/bench/report.h"

namespace tessera::bench {

/// The slope of log(y) against log(x) by least squares: the exponent with which y grows. 0 of fewer than two
/// different x. All positive.
[[nodiscard]] double exponentOf(const std::vector<double>& x, const std::vector<double>& y);

/// Culling time on grids from 1x1 to 32x32, all of them and all methods interleaved frame by frame, and the
/// exponents over 4 to 1024 tiles. Of a walk of `walkFrames`, the first `frames` are measured.
[[nodiscard]] Result<Json> tileExponents(const Scene& scene, const CameraPath& path, std::uint64_t walkFrames,
                                         std::uint64_t frames);

/// Culling time on cities of 1000 leaves, of ten times as many and so on up to `mostLeaves`, and the
/// exponents. Methods are interleaved frame by frame, the cities come one after the other.
[[nodiscard]] Result<Json> objectExponents(PaperScenes& scenes, const Wall& wall, const CameraPath& path,
                                           std::uint64_t frames, std::uint64_t mostLeaves);

}  // namespace tessera::bench
