#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "common/base/result.h"
#include "server/bench/audit.h"
#include "server/bench/candidates.h"
#include "server/bench/report.h"

namespace tessera::bench {

/// Reads candidates' lists back, whatever they hand over, and holds them against each other and against the
/// scene's triangles. Outside of what is timed.
class ListChecks {
 public:
  /// All must outlive this.
  ListChecks(const Scene& scene, const CandidateSet& set, const InterleavedCull& interleaved);

  /// The last frame's lists of footprint, table and auto must be equal where bounds and refinement are,
  /// whatever they keep or hand over. An error where they differ.
  [[nodiscard]] Status compare(std::uint64_t frame);
  /// No candidate may have dropped a leaf in the last frame. An error where one has.
  [[nodiscard]] Status judge(std::uint64_t frame, const WallView& view);

  /// What was found of one candidate.
  void addTo(Json& entry, std::size_t candidate) const;
  [[nodiscard]] std::uint64_t comparedFrames() const { return comparedFrames_; }
  [[nodiscard]] std::uint64_t auditedFrames() const { return auditedFrames_; }
  /// Of the first candidate; of all others too, but for billboards.
  [[nodiscard]] std::uint64_t exactPairs() const { return audit_.verdicts()[0].exactPairs; }

 private:
  /// What must be equal for lists to be.
  using Kind = std::tuple<cull::BoundsKind, bool, HierarchyKind>;
  struct First {
    std::size_t candidate;
    std::uint64_t hash;
  };

  void read(std::size_t candidate, std::vector<VisibleList>& out) const;

  const Scene& scene_;
  const CandidateSet& set_;
  const InterleavedCull& interleaved_;
  std::vector<std::size_t> listing_;  ///< candidates that have lists
  std::vector<std::uint64_t> hashes_, auditedPairs_;
  std::vector<std::vector<VisibleList>> lists_;
  Audit audit_;  ///< of the candidates that have lists
  std::uint64_t comparedFrames_ = 0, auditedFrames_ = 0;
};

}  // namespace tessera::bench
