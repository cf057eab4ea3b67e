#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/cull/culler.h"
#include "common/hierarchy/frustum_hierarchy.h"
#include "server/master/run_report.h"

namespace tessera::bench {

/// Runs several cullers on the same frames in one process, one after the other in every frame and in turn
/// first, so that whatever slows the machine slows all of them: only the ratios of their times are to be
/// trusted.
class InterleavedCull {
 public:
  struct Candidate {
    std::string name;
    const ObjectHierarchy* hierarchy = nullptr;
    cull::Options options;
  };
  struct Measured {
    std::string name;
    Samples us;  ///< one for each frame, in order
    Samples classifications, pairs;
    cull::TestCounts counts;
    std::uint64_t listHash = 0;
  };

  explicit InterleavedCull(const std::vector<Candidate>& candidates);
  void frame(const FrustumHierarchy& frusta) {
    for (std::size_t i = 0; i < cullers_.size(); ++i)
      static_cast<void>(run((first_ + i) % cullers_.size(), frusta));
    ++first_;
  }
  /// One candidate alone; the result lives until its next run.
  const cull::Result& run(std::size_t candidate, const FrustumHierarchy& frusta);

  [[nodiscard]] const std::vector<Measured>& measured() const { return measured_; }

 private:
  std::vector<cull::Culler> cullers_;
  std::vector<Measured> measured_;
  std::size_t first_ = 0;
};

}  // namespace tessera::bench
