#pragma once

#include <cstdint>
#include <span>

#include "common/base/result.h"
#include "common/scene/scene.h"
#include "common/wall/camera_path.h"
#include "common/wall/wall.h"
#include "server/bench/report.h"

namespace tessera::bench {

struct WallShapesOptions {
  std::uint64_t frames = 300;
  /// An observer's head moves by so much a frame, metres, to and fro; 0: it stands still.
  double headStepM = 0;
};

/// For each wall, interleaved frame by frame along one walk: frusta and lists as the master makes them
/// (WallCuller, `auto`), by one hierarchy over all tiles (`adaptive`), and tile by tile (`oh`); of stereo
/// walls also each eye apart. Times are of frusta and culling together, in us.
[[nodiscard]] Json wallShapes(const Scene& scene, std::span<const Wall> walls, const CameraPath& path,
                              const WallShapesOptions& options);

}  // namespace tessera::bench
