#pragma once

#include <string>

#include "common/base/result.h"
#include "common/wall/import/wall_import.h"
#include "common/wall/mpcdi/mpcdi.h"

namespace tessera {

/// The wall file of an MPCDI archive; every tile's "warp" names the archive's file, which must lie beside the
/// wall file, and the region.
/// 2d: a screen for each buffer, 1 mm a pixel, with a tile for each region's rectangle. 3d: a screen for each
/// region, across its frustum 1 m before the eye at the room's origin. a3 and sl: a screen for each region,
/// around the points that its projector lights as the eye sees them.
[[nodiscard]] Result<ImportedWall> wallOfMpcdi(const Mpcdi& mpcdi, const std::string& fileName);

}  // namespace tessera
