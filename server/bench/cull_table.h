#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/scene/load_scene.h"
#include "server/bench/report.h"

namespace tessera::bench {

struct CullTableOptions {
  std::uint64_t frames = 200;
  /// Only so many of them, from the first one on, with the camera as fast as ever; 0: all.
  std::uint64_t firstFrames = 0;
  /// So many of them, evenly spread, are judged in exact arithmetic for drops and excess; 0: none.
  std::uint64_t auditedFrames = 8;
  /// Also adaptive culling on the spatial hierarchies, which takes seconds to build for a million leaves.
  bool withHierarchies = true;
  /// Candidates whose names begin with one of these, and the base; empty: all.
  std::vector<std::string> only = {};
  /// As the scene was read; of what is compared with, too.
  UpAxis up = UpAxis::Auto;
};

/// Every algorithm, bound, output and hierarchy interleaved along one walk of one wall: times, ratios to
/// adaptive culling with OBBs on the scene's own hierarchy, to OH and to reading all boxes once; tests,
/// pairs, and excess over the pairs of which a triangle meets the tile. Fails where the audit finds a drop,
/// and where cullers that must agree do not: footprint, table and auto, whatever they keep or hand over.
[[nodiscard]] Result<Json> cullTable(const Scene& scene, const Wall& wall, const CameraPath& path,
                                     const CullTableOptions& options);

}  // namespace tessera::bench
