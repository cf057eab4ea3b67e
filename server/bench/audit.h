#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/cull/result.h"
#include "common/geometry/exact_frustum.h"
#include "common/scene/leaf_triangles.h"
#include "common/scene/scene.h"
#include "common/wall/wall.h"

namespace tessera {

/// Judges visible lists against the scene's triangles in exact arithmetic: which (leaf, tile) pairs must be
/// listed because a triangle meets the tile's closed frustum, near and far included. Billboards turn to the
/// eye and are not judged: they count as exact wherever they are listed. Any number of candidates is judged
/// side by side, and what is exact is worked out once for all of them.
class Audit {
 public:
  /// What was found of one candidate.
  struct Verdict {
    std::uint64_t pairs = 0, exactPairs = 0;
    /// Pairs that must be listed and are not. Never, but for a bug.
    std::uint64_t drops = 0;
    /// "frame F, tile T, leaf L" of the first one.
    std::string firstDrop;
    [[nodiscard]] double excessPercent() const;
  };

  /// The scene must outlive this, and its bounds must stay as they are.
  explicit Audit(const Scene& scene, std::size_t candidates = 1);

  /// Leaves that are not to be seen from now on, and count as meeting nothing; at first those that are absent
  /// from the scene's hierarchy.
  void hide(const VisibleList& absent) { absent_ = absent; }

  /// `lists`: of each candidate, its lists by tile. In stereo a leaf that meets a tile by either eye must be
  /// listed.
  [[nodiscard]] Status add(std::uint64_t frame, const WallView& view,
                           std::span<const std::vector<VisibleList>* const> lists);
  /// Of a single candidate.
  [[nodiscard]] Status add(std::uint64_t frame, const WallView& view, const cull::Result& result) {
    const std::vector<VisibleList>* const lists = &result.lists;
    return add(frame, view, {&lists, 1});
  }

  /// In the order of the candidates.
  [[nodiscard]] const std::vector<Verdict>& verdicts() const { return verdicts_; }
  /// How many triangles had to be decided in exact arithmetic.
  [[nodiscard]] std::uint64_t exactDecisions() const { return exactDecisions_; }

 private:
  /// What is known of a leaf and the tile at hand.
  enum class Meets : std::uint8_t { CertainlyNot, Open, No, Yes, Billboard };

  void findCandidates(const Frustum& tile);
  Status decide(std::span<ExactFrustum> seen);
  void judge(const VisibleList& list, Verdict& verdict, std::uint64_t frame, std::size_t tile) const;

  const Scene* scene_;
  LeafTriangles triangles_;
  VisibleList absent_;
  std::vector<Aabb> blocks_;  ///< around runs of leaves, so that far away ones are rejected together
  std::vector<Meets> meets_;  ///< by leaf, of the tile at hand
  std::uint64_t meeting_ = 0;
  std::vector<Verdict> verdicts_;
  std::uint64_t exactDecisions_ = 0;
};

}  // namespace tessera
