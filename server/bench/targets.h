#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/bench/paper_figures.h"
#include "server/bench/report.h"

namespace tessera::bench {

/// One figure that culling is held to.
struct TargetFigure {
  enum class Bound { AtLeast, AtMost };
  std::string name;
  double measured = 0;
  std::optional<double> target = {};  ///< none: told beside another figure
  Bound bound = Bound::AtLeast;
  Walk::Step step = {};  ///< of the camera
  std::uint64_t frames = 0;
  [[nodiscard]] bool isMet() const {
    return !target || (bound == Bound::AtLeast ? measured >= *target : measured <= *target);
  }
};
using TargetFigures = std::vector<TargetFigure>;

/// Figures of the power plant ("P"), of a city of 100,000 leaves ("C1") and of one of a million ("C2").
/// `frameScale` (0, 1] measures only so many of the frames of each walk, whose camera is as fast as ever.
[[nodiscard]] Result<TargetFigures> powerPlantTargets(const Scene& scene, double frameScale);
[[nodiscard]] Result<TargetFigures> cityTargets(const Scene& scene, double frameScale);
[[nodiscard]] Result<TargetFigures> millionTargets(const Scene& scene, double frameScale);

struct TargetsOptions {
  std::uint64_t runs = 3;
  double frameScale = 1;
  std::vector<std::string> only = {};  ///< of P, C1, C2; empty: all
};

/// Measures every figure so many times, one scene after the other: for each figure its target, what was
/// measured and whether that meets it, by run.
[[nodiscard]] Result<Json> measureTargets(PaperScenes& scenes, const TargetsOptions& options);

}  // namespace tessera::bench
