#include "common/wall/import/pixel_wall.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <tuple>

#include "common/wall/import/formats.h"

namespace tessera {

namespace {

constexpr double kGapBetweenSurfacesM = 0.1;
constexpr std::int64_t kMaxTiles = 4096;

std::string cellName(int column, int row) {
  return 'r' + std::to_string(row) + 'c' + std::to_string(column);
}

walltext::Settings settingsOf(const PixelScreen& screen) {
  walltext::Settings settings;
  settings.host = screen.host;
  settings.eye = screen.eye;
  if (!screen.isFullscreen) settings.windowPx = screen.windowPx;
  return settings;
}

/// A surface with its derived sizes.
struct Measured {
  int screenPx[2];
  double mmPerPx[2];
  double sizeMm[2];
};

Result<Measured> measured(const PixelSurface& surface, const std::string& fileName) {
  const auto fail = [&](const std::string& what) {
    return inputError(fileName + ':' + std::to_string(surface.line), what);
  };
  Measured result{};
  for (int axis = 0; axis < 2; ++axis) {
    const std::int64_t perScreen = surface.displaysPerScreen[axis], count = surface.screenCount[axis];
    const std::int64_t display = surface.displayPx[axis], bezel = surface.bezelPx[axis];
    const std::int64_t screen = display * perScreen + bezel * (perScreen - 1);
    const std::int64_t whole = screen * count + bezel * (count - 1);
    if (display < 1 || display > 16384 || screen < 1 || screen > 16384) {
      return fail("the displays have no possible size in pixels; 1 to 16384 a side are");
    }
    if (bezel <= -screen) return fail("the displays overlap wholly");
    result.screenPx[axis] = static_cast<int>(screen);
    result.mmPerPx[axis] =
        surface.sizeM[axis] > 0 ? surface.sizeM[axis] * 1000 / static_cast<double>(whole) : 1;
    result.sizeMm[axis] = static_cast<double>(whole) * result.mmPerPx[axis];
  }
  if (static_cast<std::int64_t>(surface.screenCount[0]) * surface.screenCount[1] > kMaxTiles) {
    return fail("describes more than " + std::to_string(kMaxTiles) + " tiles");
  }
  return result;
}

walltext::Grid gridOf(const PixelSurface& surface, const Measured& size,
                      const std::vector<PixelScreen>& screens) {
  walltext::Grid grid;
  grid.columns = surface.screenCount[0];
  grid.rows = surface.screenCount[1];
  grid.tilePx = {size.screenPx[0], size.screenPx[1]};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    grid.tileMm[axis] = size.screenPx[axis] * size.mmPerPx[axis];
    if (surface.bezelPx[axis] > 0) grid.bezelMm[axis] = surface.bezelPx[axis] * size.mmPerPx[axis] / 2;
    if (surface.bezelPx[axis] < 0) grid.overlapPx[axis] = -surface.bezelPx[axis];
  }
  std::set<std::string> shown;
  for (const PixelScreen& screen : screens) {
    const std::string name = cellName(screen.column, screen.row);
    shown.insert(name);
    grid.settings.emplace_back(name, settingsOf(screen));
  }
  for (int row = 0; row < grid.rows && !screens.empty(); ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      if (!shown.contains(cellName(column, row))) grid.missing.push_back(cellName(column, row));
    }
  }
  return grid;
}

}  // namespace

Result<ImportedWall> wallOfPixels(const std::vector<PixelSurface>& surfaces,
                                  const std::vector<PixelScreen>& screens, WarningList warnings,
                                  const std::string& origin, const std::string& fileName) {
  std::vector<Measured> sizes;
  for (const PixelSurface& surface : surfaces) {
    Result<Measured> size = measured(surface, fileName);
    if (!size) return size.error();
    sizes.push_back(*size);
  }
  std::vector<PixelScreen> used;
  std::set<std::tuple<int, int, int, walltext::Eye>> places;
  std::set<int> usedSurfaces;
  bool hasEyes = false;
  for (const PixelScreen& screen : screens) {
    const std::string where = fileName + ':' + std::to_string(screen.line);
    if (screen.surface < 0 || screen.surface >= static_cast<int>(surfaces.size())) {
      return inputError(where, "the screen lies on surface " + std::to_string(screen.surface) + " of " +
                                   std::to_string(surfaces.size()));
    }
    const PixelSurface& surface = surfaces[static_cast<std::size_t>(screen.surface)];
    if (screen.column < 0 || screen.row < 0 || screen.column >= surface.screenCount[0] ||
        screen.row >= surface.screenCount[1]) {
      return inputError(where, "column " + std::to_string(screen.column) + ", row " +
                                   std::to_string(screen.row) + " lies outside of the " +
                                   std::to_string(surface.screenCount[0]) + " x " +
                                   std::to_string(surface.screenCount[1]) + " screens");
    }
    if (!places.emplace(screen.surface, screen.column, screen.row, screen.eye).second) {
      warnings.add("second screen at the same place of the wall", screen.line,
                   "a tile shows in one window; left out");
      continue;
    }
    hasEyes = hasEyes || screen.eye != walltext::Eye::Both;
    usedSurfaces.insert(screen.surface);
    used.push_back(screen);
  }
  double width = 0, height = 0;
  walltext::Wall wall;
  wall.name = wallNameOf(fileName);
  wall.origin = origin;
  // A grid has bezels or overlaps, not both.
  const bool isMixed =
      surfaces.size() == 1 && surfaces[0].bezelPx[0] * std::int64_t{surfaces[0].bezelPx[1]} < 0;
  if (surfaces.size() == 1 && !hasEyes && !isMixed) {
    wall.grid = gridOf(surfaces[0], sizes[0], used);
    for (const std::string& name : wall.grid->missing) {
      warnings.add("place of the wall that no process shows", surfaces[0].line,
                   "a missing tile; the first is " + name);
    }
  } else {
    NameMaker tileNames;
    double x = 0;
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
      if (!usedSurfaces.contains(static_cast<int>(s))) {
        warnings.add("surface that no process shows", surfaces[s].line, "left out");
        continue;
      }
      walltext::Screen screen;
      screen.name = "surface" + std::to_string(s);
      const double w = sizes[s].sizeMm[0] / 1000, h = sizes[s].sizeMm[1] / 1000;
      screen.corners = {Vec3(x, 0, 0), Vec3(x + w, 0, 0), Vec3(x, h, 0)};
      width = x + w;
      x += w + kGapBetweenSurfacesM;
      height = std::max(height, h);
      for (const PixelScreen& source : used) {
        if (source.surface != static_cast<int>(s)) continue;
        walltext::Tile tile;
        const std::string prefix = surfaces.size() > 1 ? 's' + std::to_string(s) + '-' : "";
        const char* eye = source.eye == walltext::Eye::Left    ? "-left"
                          : source.eye == walltext::Eye::Right ? "-right"
                                                               : "";
        tile.name = tileNames.make(prefix + cellName(source.column, source.row) + eye);
        tile.px = {sizes[s].screenPx[0], sizes[s].screenPx[1]};
        const int place[2] = {source.column, source.row};
        for (std::size_t axis = 0; axis < 2; ++axis) {
          tile.sizeMm[axis] = sizes[s].screenPx[axis] * sizes[s].mmPerPx[axis];
          tile.atMm[axis] =
              place[axis] * (sizes[s].screenPx[axis] + surfaces[s].bezelPx[axis]) * sizes[s].mmPerPx[axis];
        }
        tile.settings = settingsOf(source);
        screen.tiles.push_back(std::move(tile));
      }
      wall.screens.push_back(std::move(screen));
    }
  }
  if (hasEyes || wall.screens.size() > 1) {
    walltext::Observer observer;
    observer.eyeM = Vec3(width / 2, height / 2, std::max(width, height));
    if (hasEyes) observer.stereo = walltext::Stereo::Tiles;
    wall.observer = observer;
    if (wall.screens.size() > 1) {
      warnings.add("several surfaces", surfaces[1].line,
                   "the file does not say where they stand; placed side by side in one plane");
    }
    warnings.add(
        "no eye", 0,
        "the file knows none; taken to be before the middle, as far away as the wall is wide or high");
  }
  settleEyes(wall, warnings);
  Result<std::string> json = wallText(wall, fileName);
  if (!json) return json.error();
  return ImportedWall{std::move(*json), warnings.texts(fileName)};
}

}  // namespace tessera
