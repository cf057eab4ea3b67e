#include "common/wall/wall_file.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "common/base/file.h"
#include "common/wall/json_document.h"
#include "common/wall/json_reader.h"
#include "common/wall/tile_reader.h"

namespace tessera {

namespace {

constexpr NumberRange kClipRange{1e-9, 1e15};
constexpr NumberRange kRoomRangeM{-kMaxRoomM, kMaxRoomM};
constexpr double kLeastSideM = 1e-3;
/// Corners at other than right angles are squared up: without a word, with a warning, not any more.
constexpr double kSilentSkewDeg = 0.01, kMostSkewDeg = 1;

double radians(double degrees) {
  return degrees * (std::numbers::pi / 180);
}

std::string sizeText(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

/// Builds one Wall; each function reads one part of the file.
class WallReader {
 public:
  explicit WallReader(const std::string& sourceName)
      : source_(sourceName), json_(sourceName), tiles_(json_, source_) {
    wall_.source = sourceName;
  }

  Result<Wall> read(const JsonDocument& document) {
    const JsonValue root = document.root();
    wall_.fovYRad = radians(kDefaultFovYDeg);
    if (json_.object(root, "wall", {"$schema", "name", "grid", "screens", "tiles", "camera", "observer"})) {
      if (const auto schema = root.find("$schema")) json_.string(*schema, "$schema", kMaxWallNameBytes);
      if (const auto name = root.find("name")) wall_.name = json_.string(*name, "name", kMaxWallNameBytes);
      if (const auto observer = root.find("observer")) readObserver(*observer);
      readScreens(root);
      const auto tiles = root.find("tiles");
      if (tiles && json_.ok()) tiles_.overrides(*tiles, wall_.tiles);
      if (const auto camera = root.find("camera")) readCamera(*camera);
      if (json_.ok()) checkEyes(root);
      if (json_.ok()) checkTiles();
    }
    if (json_.error()) return *json_.error();
    return std::move(wall_);
  }

 private:
  void readScreens(const JsonValue& root) {
    const auto grid = root.find("grid"), screens = root.find("screens");
    if (grid && screens) {
      return json_.fail(grid->line(), "a wall has either one \"grid\" or \"screens\"",
                        "move the grid into a screen");
    }
    if (!grid && !screens) {
      return json_.fail(root.line(), "\"wall\" lacks \"grid\"", "add it, or \"screens\"");
    }
    if (grid) {
      Screen screen;
      screen.name = "wall";
      screen.widthMm = screen.heightMm = 0;
      return readGrid(*grid, screen);
    }
    if (!json_.array(*screens, "screens")) return;
    const std::vector<JsonValue> all = screens->children();
    if (all.empty() || all.size() > static_cast<std::size_t>(kMaxScreens)) {
      return json_.fail(screens->line(), "the wall has " + std::to_string(all.size()) + " screens",
                        "it has 1 to " + std::to_string(kMaxScreens));
    }
    if (all.size() > 1 && !wall_.observer && json_.ok()) {
      return json_.fail(screens->line(), "several screens are seen by somebody who stands before them",
                        "add \"observer\": {\"eye_m\": [x, y, z]}");
    }
    for (const JsonValue& screen : all) {
      if (json_.ok()) readScreen(screen, all.size() == 1);
    }
  }

  void readScreen(const JsonValue& value, bool isOnly) {
    if (!json_.object(value, "screen", {"name", "corners_m", "size_mm", "grid", "tiles"})) return;
    Screen screen;
    screen.name = "wall";
    screen.widthMm = screen.heightMm = 0;
    if (const auto name = value.find("name")) {
      screen.name = json_.string(*name, "name", kMaxTileNameBytes);
    } else if (!isOnly) {
      return json_.fail(value.line(), "one of several screens lacks \"name\"", "add it");
    }
    for (const Screen& other : wall_.screens) {
      if (other.name == screen.name)
        return json_.fail(value.line(), "two screens are named \"" + excerpt(screen.name, 64) + "\"",
                          "rename one of them");
    }
    const auto corners = value.find("corners_m"), size = value.find("size_mm");
    if (corners && size)
      return json_.fail(size->line(), "\"corners_m\" says the screen's size already", "remove \"size_mm\"");
    if (!corners && !isOnly)
      return json_.fail(value.line(), "one of several screens lacks \"corners_m\"", "say where it stands");
    if (corners) readCorners(*corners, screen);
    if (size) {
      const std::vector<double> mm = json_.numbers(*size, "size_mm", 2, {1e-3, kMostMm});
      screen.widthMm = mm[0];
      screen.heightMm = mm[1];
    }
    const auto grid = value.find("grid"), tiles = value.find("tiles");
    if (!grid == !tiles)
      return json_.fail(value.line(), "a screen has either \"grid\" or \"tiles\"",
                        grid ? "remove one of them" : "add one of them");
    if (!json_.ok()) return;
    if (grid) return readGrid(*grid, screen);
    screen.firstTile = static_cast<std::uint32_t>(wall_.tiles.size());
    tiles_.tiles(*tiles, static_cast<std::uint32_t>(wall_.screens.size()), screen, wall_.tiles);
    if (!json_.ok()) return;
    const Tile& only = wall_.tiles[screen.firstTile];
    const bool fillsIt = screen.tileCount == 1 && only.freeTurnRad == 0 && only.corners[0] == Vec2(-1, -1) &&
                         only.corners[2] == Vec2(1, 1);
    screen.columns = screen.rows = fillsIt ? 1 : 0;
    addScreen(std::move(screen));
  }

  void readGrid(const JsonValue& value, Screen& screen) {
    screen.firstTile = static_cast<std::uint32_t>(wall_.tiles.size());
    const GridSpec grid = tiles_.grid(value);
    if (!json_.ok()) return;
    if (wall_.tiles.size() + grid.names.size() > static_cast<std::size_t>(kMaxTiles))
      return json_.fail(value.line(), "there are too many tiles",
                        "a wall has at most " + std::to_string(kMaxTiles));
    const double sticksOutMm =
        layOut(grid, static_cast<std::uint32_t>(wall_.screens.size()), screen, wall_.tiles);
    if (screen.tileCount == 0)
      return json_.fail(value.line(), "the grid has no tile left", "a screen has at least one tile");
    const Tile& first = wall_.tiles[screen.firstTile];
    if (!(first.widthMm > 0 && first.heightMm > 0))
      return json_.fail(value.line(), "the screen is smaller than its bezels", "check their millimetres");
    if (sticksOutMm > 1e-6 * std::max(screen.widthMm, screen.heightMm))
      return json_.fail(value.line(),
                        "the grid sticks out over its screen by " + numberText(sticksOutMm) + " mm",
                        "leave \"tile_mm\" out to have the tiles fitted to the screen");
    addScreen(std::move(screen));
  }

  void addScreen(Screen screen) {
    assignCanvases(screen, wall_.tiles);
    wall_.screens.push_back(std::move(screen));
  }

  void readCorners(const JsonValue& value, Screen& screen) {
    if (!json_.object(value, "corners_m", {"lower_left", "lower_right", "upper_left"})) return;
    const auto corner = [&](const char* key) {
      const auto found = json_.required(value, "corners_m", key);
      return found ? json_.vec3(*found, key, kRoomRangeM) : Vec3(Vec3::Zero());
    };
    const Vec3 lowerLeft = corner("lower_left"), lowerRight = corner("lower_right"),
               upperLeft = corner("upper_left");
    if (!json_.ok()) return;
    const Vec3 across = lowerRight - lowerLeft, side = upperLeft - lowerLeft;
    const double width = across.norm(), length = side.norm();
    if (width < kLeastSideM || length < kLeastSideM)
      return json_.fail(value.line(), "two corners of the screen are the same point",
                        "a screen is at least " + numberText(kLeastSideM) + " m wide and high");
    const double sine = across.cross(side).norm() / width / length;
    const double skewDeg = std::acos(std::min(1.0, sine)) * (180 / std::numbers::pi);
    if (sine < 1e-3)
      return json_.fail(value.line(), "the corners of the screen lie on one line",
                        "lower_left, lower_right and upper_left are three corners of a rectangle");
    if (skewDeg > kMostSkewDeg)
      return json_.fail(value.line(),
                        "the screen's corners are " + numberText(std::round(skewDeg * 100) / 100) +
                            " degrees away from a right angle",
                        "measure again: a screen is a rectangle");
    if (skewDeg > kSilentSkewDeg)
      wall_.warnings.push_back(
          "the corners of screen \"" + screen.name + "\" are " +
          numberText(std::round(skewDeg * 1000) / 1000) +
          " degrees away from a right angle; its lower edge is kept and its side squared up");
    screen.right = across / width;
    const Vec3 up = side - screen.right * screen.right.dot(side);
    screen.up = (up - screen.right * screen.right.dot(up)).normalized();
    screen.widthMm = width * 1000;
    screen.heightMm = up.norm() * 1000;
    screen.centerM = lowerLeft + across / 2 + up / 2;
  }

  void readObserver(const JsonValue& value) {
    if (!json_.object(value, "observer", {"eye_m", "scale", "osc_port", "stereo"})) return;
    Observer observer;
    if (const auto eye = json_.required(value, "observer", "eye_m"))
      observer.eyeM = json_.vec3(*eye, "eye_m", kRoomRangeM);
    if (const auto scale = value.find("scale")) observer.scale = json_.number(*scale, "scale", {1e-9, 1e9});
    if (const auto port = value.find("osc_port"))
      observer.oscPort = json_.integer(*port, "osc_port", {1, 65535});
    if (const auto stereo = value.find("stereo")) {
      if (!json_.object(*stereo, "stereo", {"mode", "separation_mm"})) return;
      if (const auto mode = json_.required(*stereo, "stereo", "mode")) {
        observer.stereo = static_cast<Stereo>(
            json_.choice(*mode, "mode", {"none", "side-by-side", "top-bottom", "tiles", "quad-buffer"}));
      }
      if (const auto separation = stereo->find("separation_mm"))
        observer.separationM = json_.number(*separation, "separation_mm", {0, 10'000}) / 1000;
    }
    wall_.observer = observer;
  }

  void readCamera(const JsonValue& camera) {
    if (!json_.object(camera, "camera", {"fov_y_deg", "near_m", "far_m"})) return;
    if (const auto fov = camera.find("fov_y_deg")) {
      wall_.fovYRad = radians(json_.number(*fov, "fov_y_deg", {kMinFovYDeg, kMaxFovYDeg}));
      if (wall_.observer)
        json_.fail(fov->line(), "with an \"observer\" the field of view follows from where the eye stands",
                   "remove \"fov_y_deg\"");
    }
    if (const auto near = camera.find("near_m")) wall_.near = json_.number(*near, "near_m", kClipRange);
    const auto far = camera.find("far_m");
    if (far) wall_.far = json_.number(*far, "far_m", kClipRange);
    if (wall_.near && wall_.far && !(*wall_.near < *wall_.far)) {
      json_.fail(far->line(),
                 "\"far_m\" (" + numberText(*wall_.far) + ") must be greater than \"near_m\" (" +
                     numberText(*wall_.near) + ")",
                 "leave both out to have them fitted to the scene");
    }
  }

  void checkEyes(const JsonValue& root) {
    const auto observer = root.find("observer");
    const bool hasEyes = wall_.observer && wall_.observer->stereo == Stereo::Tiles;
    for (const Tile& tile : wall_.tiles) {
      if ((tile.eye != TileEye::Both) == hasEyes) continue;
      const int line = tiles_.lineOf(tile.name);
      if (hasEyes)
        return json_.fail(line, "tile \"" + tile.name + "\" does not say which eye it is for",
                          "with stereo mode \"tiles\" every tile has \"eye\": \"left\" or \"right\"");
      return json_.fail(line,
                        "tile \"" + tile.name + "\" is for one eye, but the wall is not in stereo by tiles",
                        "add \"stereo\": {\"mode\": \"tiles\"} to the observer, or remove \"eye\"");
    }
    if (!observer) return;
    if (const auto s = screenNotBefore(wall_, wall_.observer->eyeM)) {
      const auto eye = observer->find("eye_m");
      json_.fail(eye->line(),
                 "the eye lies in the plane of screen \"" + wall_.screens[*s].name + "\" or behind it",
                 "stand at least " + numberText(kLeastEyeDistanceM) +
                     " m before every screen; its corners go round counterclockwise as the viewer sees them");
    }
  }

  void checkTiles() {
    const Stereo stereo = wall_.observer ? wall_.observer->stereo : Stereo::None;
    bool warnedOfOdd = false, warnedOfPixels = false;
    for (const Tile& tile : wall_.tiles) {
      const int line = tiles_.lineOf(tile.name);
      const auto& blend = tile.output.blendPx;
      if (blend[0] + blend[1] > tile.widthPx || blend[2] + blend[3] > tile.heightPx)
        return json_.fail(line, "the blend ramps of tile \"" + tile.name + "\" are wider than its picture",
                          "make them, or the overlap, smaller");
      if ((stereo == Stereo::SideBySide && tile.widthPx % 2 != 0) ||
          (stereo == Stereo::TopBottom && tile.heightPx % 2 != 0))
        return json_.fail(line,
                          "tile \"" + tile.name + "\" of " + sizeText(tile.widthPx, tile.heightPx) +
                              " pixels has no halves",
                          "each eye has half of its pixels: make them even");
      const double shape = tile.widthMm / tile.widthPx / (tile.heightMm / tile.heightPx);
      if (!warnedOfPixels && std::abs(shape - 1) > 0.01) {
        warnedOfPixels = true;
        wall_.warnings.push_back("the pixels of tile \"" + tile.name + "\" are " +
                                 numberText(std::round(shape * 1000) / 1000) +
                                 " times as wide as high; check its pixels and millimetres");
      }
      const bool isOddAcross = tile.canvasWidthPx > tile.widthPx && tile.widthPx % 2 != 0;
      const bool isOddDown = tile.canvasHeightPx > tile.heightPx && tile.heightPx % 2 != 0;
      if (warnedOfOdd || (!isOddAcross && !isOddDown)) continue;
      warnedOfOdd = true;
      wall_.warnings.push_back(
          "tiles of " + sizeText(tile.widthPx, tile.heightPx) +
          " pixels start at odd pixels of the wall, where texture mip-maps may shift at the seams by up to a "
          "quad of pixels; even tile sizes avoid it");
    }
  }

  const std::string source_;
  JsonReader json_;
  TileReader tiles_;
  Wall wall_;
};

}  // namespace

Result<Wall> readWallFile(const std::filesystem::path& path) {
  const Result<std::string> text = readFile(path, kMaxWallFileBytes);
  if (!text) return text.error();
  return parseWall(*text, path.string());
}

Result<Wall> parseWall(std::string_view text, const std::string& sourceName) {
  const Result<JsonDocument> document = JsonDocument::parse(text, sourceName);
  if (!document) return document.error();
  return WallReader(sourceName).read(*document);
}

}  // namespace tessera
