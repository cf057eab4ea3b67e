#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "common/cull/culler.h"
#include "common/hierarchy/frustum_hierarchy.h"
#include "server/bench/linear_kernels.h"
#include "server/master/run_report.h"

namespace tessera::bench {

/// What a candidate hands over, and its time therefore covers.
enum class Output {
  Ranges,  ///< whole lists as ranges: Culler::cull
  Ids,     ///< the same, then written out as 32-bit leaf ids
  Diff,    ///< what changed since the frame before: Culler::cullChanges
  Count,   ///< of what is no culler: pairs, if anything
};
[[nodiscard]] std::string_view nameOf(Output output);

/// Something that is no culler of ours, timed among them.
struct Baseline {
  std::function<void()> run;
  std::function<std::uint64_t()> pairs;  ///< of the last run; not timed
};

/// Runs several cullers on the same frames in one process, one after the other in every frame, so that
/// whatever slows the machine slows all of them: only the ratios of their times are to be trusted. The order
/// is shuffled for every frame (and is the same in every run of the program), so that none always finds the
/// caches as the same other one has left them.
class InterleavedCull {
 public:
  struct Candidate {
    std::string name;
    const ObjectHierarchy* hierarchy = nullptr;
    cull::Options options = {};
    Output output = Output::Ranges;
    std::optional<Baseline> baseline = {};  ///< run in place of a culler
  };
  struct Measured {
    std::string name;
    Output output = Output::Ranges;
    Samples us;  ///< one for each frame, in order
    Samples classifications, pairs;
    cull::TestCounts counts;
    std::uint64_t listHash = 0;  ///< of all frames' lists; of ranges and ids alone
    /// Frames by Culler::picked(), by the algorithm's number.
    std::array<std::uint64_t, static_cast<std::size_t>(cull::Algorithm::Auto) + 1> picked = {};
  };

  explicit InterleavedCull(const std::vector<Candidate>& candidates);
  void frame(const FrustumHierarchy& frusta) {
    for (const std::size_t candidate : shuffled())
      run(candidate, frusta);
  }
  /// All candidates in the order of the next frame.
  [[nodiscard]] const std::vector<std::size_t>& shuffled() {
    std::shuffle(order_.begin(), order_.end(), random_);
    return order_;
  }
  /// One candidate alone.
  void run(std::size_t candidate, const FrustumHierarchy& frusta);

  /// False for a baseline, which has no lists.
  [[nodiscard]] bool hasLists(std::size_t candidate) const { return runners_[candidate].culler.has_value(); }
  /// All tiles' whole lists as of the candidate's last run, whatever its output. Not timed.
  void listsOf(std::size_t candidate, std::vector<VisibleList>& out) const;
  /// What the candidate's last run ran.
  [[nodiscard]] cull::Algorithm picked(std::size_t candidate) const {
    return runners_[candidate].culler->picked();
  }

  [[nodiscard]] const std::vector<Measured>& measured() const { return measured_; }

 private:
  struct Runner {
    std::optional<cull::Culler> culler;
    std::optional<Baseline> baseline;
    std::uint32_t tiles = 0;  ///< of the last run
  };
  /// Microseconds.
  double cullOnce(Runner& runner, const FrustumHierarchy& frusta, Measured& measured);

  std::vector<Runner> runners_;
  std::vector<Measured> measured_;
  LeafIds ids_;
  std::vector<std::size_t> order_;
  std::mt19937 random_{2006};
};

}  // namespace tessera::bench
