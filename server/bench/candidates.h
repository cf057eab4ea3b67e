#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/hierarchy/spatial_hierarchy.h"
#include "common/scene/osg_cull_baseline.h"
#include "common/scene/scene.h"
#include "server/bench/interleaved_cull.h"

namespace tessera::bench {

/// A candidate of the table before there is a scene to run it on.
struct CandidateSpec {
  enum class Kind { Culler, OsgFull, OsgTraversal, LinearRead };
  std::string name;
  Kind kind = Kind::Culler;
  cull::Options options = {};
  Output output = Output::Ranges;
  HierarchyKind hierarchy = HierarchyKind::Graph;
};

/// The base of the ratios; always there, and first.
inline constexpr const char* kBaseName = "adaptive obb";
inline constexpr const char* kOhName = "oh obb";
inline constexpr const char* kLinearName = "linear read of all OBBs";

/// All of them, or those whose names begin with one of `only` and the base. Cullers of one thread unless
/// their names say otherwise. An input error where nothing begins with a name.
[[nodiscard]] Result<std::vector<CandidateSpec>> selectCandidates(const std::vector<std::string>& only,
                                                                  bool withHierarchies);

/// Candidates on a scene, and what they need beside it.
class CandidateSet {
 public:
  /// Builds the hierarchies and reads the graphs that the candidates ask for. `scene` must outlive this.
  [[nodiscard]] static Result<std::unique_ptr<CandidateSet>> make(const Scene& scene, UpAxis up,
                                                                  std::vector<CandidateSpec> specs);
  CandidateSet(const CandidateSet&) = delete;
  CandidateSet& operator=(const CandidateSet&) = delete;

  /// Before each frame, for the candidates that go by the view itself.
  void setView(const WallView& view) {
    if (osg_) osg_->setView(view);
  }
  /// Lists of a candidate's own hierarchy in the ids of the scene's leaves.
  void toGraphIds(std::size_t candidate, std::vector<VisibleList>& lists) const;
  [[nodiscard]] const std::vector<CandidateSpec>& specs() const { return specs_; }
  [[nodiscard]] const std::vector<InterleavedCull::Candidate>& candidates() const { return candidates_; }

 private:
  CandidateSet() = default;
  [[nodiscard]] Baseline baselineOf(CandidateSpec::Kind kind, const Scene& scene);

  std::vector<CandidateSpec> specs_;
  std::list<SpatialHierarchy> built_;
  std::vector<const SpatialHierarchy*> spatial_;  ///< by candidate; null on the scene's own hierarchy
  std::optional<OsgCullBaseline> osg_;
  volatile double linearSum_ = 0;  ///< so that the reading is not left out
  std::vector<InterleavedCull::Candidate> candidates_;
};

}  // namespace tessera::bench
