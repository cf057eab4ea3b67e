#pragma once

#include <string>
#include <vector>

#include "common/wall/import/wall_import.h"
#include "common/wall/import/wall_text.h"
#include "common/wall/import/warning_list.h"

namespace tessera {

/// A wall as Tide and DisplayCluster know it: surfaces of equal displays, measured in pixels.
struct PixelSurface {
  int displayPx[2] = {0, 0};
  int displaysPerScreen[2] = {1,
                              1};  ///< a screen is what one window covers, bezels between displays included
  int screenCount[2] = {1, 1};
  int bezelPx[2] = {0, 0};   ///< between two displays; negative: they overlap
  double sizeM[2] = {0, 0};  ///< of the whole surface; 0: not said
  int line = 0;
};

/// One window of a process.
struct PixelScreen {
  int surface = 0, column = 0, row = 0;
  std::array<int, 2> windowPx = {0, 0};
  bool isFullscreen = false;
  walltext::Eye eye = walltext::Eye::Both;
  std::string host;
  int line = 0;
};

/// The wall file of it. One surface becomes a planar wall of 1 mm a pixel unless it has a size; several
/// surfaces, or a surface with windows for single eyes, become screens side by side before an assumed eye.
[[nodiscard]] Result<ImportedWall> wallOfPixels(const std::vector<PixelSurface>& surfaces,
                                                const std::vector<PixelScreen>& screens, WarningList warnings,
                                                const std::string& origin, const std::string& fileName);

}  // namespace tessera
