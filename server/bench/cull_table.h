#pragma once

#include <cstdint>
#include <vector>

#include "common/base/result.h"
#include "common/scene/scene.h"
#include "server/bench/report.h"

namespace tessera::bench {

struct CullTableOptions {
  std::uint64_t frames = 200;
  /// So many of them, evenly spread, are judged in exact arithmetic for the excess; 0: none.
  std::uint64_t auditedFrames = 8;
  /// Also adaptive culling on the spatial hierarchies, which takes seconds to build for a million leaves.
  bool withHierarchies = true;
};

/// Every algorithm, bound and hierarchy interleaved along one walk of one wall: times, ratios to adaptive
/// culling with OBBs on the scene's own hierarchy, tests, pairs, and excess over the pairs of which a
/// triangle meets the tile. Fails where the audit finds a drop.
[[nodiscard]] Result<Json> cullTable(const Scene& scene, const Wall& wall, const CameraPath& path,
                                     const CullTableOptions& options);

}  // namespace tessera::bench
