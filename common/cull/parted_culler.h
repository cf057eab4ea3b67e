#pragma once

#include "common/cull/culler.h"

namespace tessera::cull {

/// Culls a scene whose static and moving parts have hierarchies of their own (Real-Time Rendering, section
/// 14.3): refitting the moving part never loosens or touches a box of the static one, and what cullers
/// remember of the static part stays valid. One id space: the static part's leaves first, then the moving
/// part's, so leaf i of `moving` is id fixed.leafCount() + i.
///
/// Both must outlive the culler. `movingFrusta` may be in the moving part's own coordinates (PlacedFrusta)
/// where it moves as a whole.
class PartedCuller {
 public:
  /// `options` must pass check().
  PartedCuller(const ObjectHierarchy& fixed, const ObjectHierarchy& moving, const Options& options)
      : offset_(fixed.leafCount()), fixed_(fixed, options), moving_(moving, options) {}

  /// The result lives until the next call.
  const Result& cull(const FrustumHierarchy& frusta) { return cull(frusta, frusta); }
  const Result& cull(const FrustumHierarchy& fixedFrusta, const FrustumHierarchy& movingFrusta);

 private:
  std::uint32_t offset_;
  Culler fixed_, moving_;
  Result result_;
};

}  // namespace tessera::cull
