#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/cull/result.h"
#include "common/scene/leaf_triangles.h"
#include "common/scene/scene.h"
#include "common/wall/wall.h"

namespace tessera {

/// Judges visible lists against the scene's triangles in exact arithmetic: which (leaf, tile) pairs must be
/// listed because a triangle meets the tile's closed frustum, near and far included. Billboards turn to the
/// eye and are not judged: they count as exact wherever they are listed.
class Audit {
 public:
  explicit Audit(const Scene& scene) : scene_(&scene), triangles_(scene) {}

  [[nodiscard]] Status add(std::uint64_t frame, const WallView& view, const cull::Result& result);

  [[nodiscard]] std::uint64_t pairs() const { return pairs_; }
  [[nodiscard]] std::uint64_t exactPairs() const { return exactPairs_; }
  /// Pairs that must be listed and are not. Never, but for a bug.
  [[nodiscard]] std::uint64_t drops() const { return drops_; }
  /// "frame F, tile T, leaf L" of the first one.
  [[nodiscard]] const std::string& firstDrop() const { return firstDrop_; }
  /// How many triangles had to be decided in exact arithmetic.
  [[nodiscard]] std::uint64_t exactDecisions() const { return exactDecisions_; }
  [[nodiscard]] double excessPercent() const;

 private:
  const Scene* scene_;
  LeafTriangles triangles_;
  std::uint64_t pairs_ = 0, exactPairs_ = 0, drops_ = 0, exactDecisions_ = 0;
  std::string firstDrop_;
};

}  // namespace tessera
