#include "common/wall/import/wall_text.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

namespace tessera {

namespace {

using Json = nlohmann::ordered_json;

// The limits of wall files.
constexpr std::size_t kMaxTiles = 4096;
constexpr std::size_t kMaxScreens = 256;
constexpr int kMaxTilePx = 16384;
constexpr int kMaxGridSide = 256;
constexpr int kMaxWallPx = 65535;
constexpr double kLeastScreenM = 1e-3;
constexpr double kLeastTileMm = 1e-3;
constexpr double kLeastEyeDistanceM = 0.01;
constexpr double kMaxCoordinateM = 1e6;
constexpr std::size_t kMaxNameBytes = 256;
constexpr std::size_t kMaxHostBytes = 253;
constexpr int kMaxWindowPx = 32767;

/// Nine decimals, so that sums of decimal fractions look as people would write them.
Json number(double value) {
  const double rounded = std::round(value * 1e9) / 1e9;
  if (rounded == std::floor(rounded) && std::abs(rounded) < 1e15) return static_cast<std::int64_t>(rounded);
  return rounded;
}

Json pair(const std::array<double, 2>& values) {
  return Json::array({number(values[0]), number(values[1])});
}

Json point(const Vec3& p) {
  return Json::array({number(p.x()), number(p.y()), number(p.z())});
}

std::string dumped(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// On one line, with a space behind commas and colons.
std::string inlineText(const Json& json) {
  if (!json.is_structured()) return dumped(json);
  std::string text;
  for (const auto& item : json.items()) {
    if (!text.empty()) text += ", ";
    if (json.is_object()) text += dumped(item.key()) + ": ";
    text += inlineText(item.value());
  }
  return json.is_object() ? '{' + text + '}' : '[' + text + ']';
}

/// What fits on a line of 120 columns stands on one.
std::string prettyText(const Json& json, std::size_t indent, std::size_t used) {
  std::string flat = inlineText(json);
  if (!json.is_structured() || json.empty() || (indent > 0 && used + flat.size() <= 120)) return flat;
  const std::string margin(indent + 2, ' ');
  std::string text(1, json.is_object() ? '{' : '[');
  bool first = true;
  for (const auto& item : json.items()) {
    text += first ? "\n" : ",\n";
    first = false;
    const std::string key = json.is_object() ? dumped(item.key()) + ": " : "";
    text += margin + key + prettyText(item.value(), indent + 2, margin.size() + key.size() + 1);
  }
  text += '\n' + std::string(indent, ' ') + (json.is_object() ? '}' : ']');
  return text;
}

void addSettings(Json& json, const walltext::Settings& settings) {
  if (!settings.host.empty()) json["host"] = settings.host;
  if (settings.windowPx) json["window_px"] = *settings.windowPx;
  if (settings.eye != walltext::Eye::Both) {
    json["eye"] = settings.eye == walltext::Eye::Left ? "left" : "right";
  }
  if (settings.warp) {
    json["warp"] = Json{{"mpcdi", settings.warp->mpcdiFile}, {"region", settings.warp->region}};
  }
}

std::string_view stereoName(walltext::Stereo stereo) {
  switch (stereo) {
    case walltext::Stereo::None:
      return "none";
    case walltext::Stereo::SideBySide:
      return "side-by-side";
    case walltext::Stereo::TopBottom:
      return "top-bottom";
    case walltext::Stereo::Tiles:
      return "tiles";
    case walltext::Stereo::QuadBuffer:
      return "quad-buffer";
  }
  return "none";
}

Json gridJson(const walltext::Grid& grid) {
  Json json;
  json["columns"] = grid.columns;
  json["rows"] = grid.rows;
  json["tile_px"] = grid.tilePx;
  if (!grid.missing.empty()) json["missing"] = grid.missing;
  json["tile_mm"] = pair(grid.tileMm);
  if (grid.bezelMm[0] != 0 || grid.bezelMm[1] != 0) json["bezel_mm"] = pair(grid.bezelMm);
  if (grid.overlapPx[0] != 0 || grid.overlapPx[1] != 0) json["overlap_px"] = grid.overlapPx;
  return json;
}

Json screenJson(const walltext::Screen& screen) {
  Json json;
  json["name"] = screen.name;
  if (screen.corners) {
    // Sources give their numbers to few digits; exactly at right angles it is a rectangle.
    const Vec3 right = screen.corners->lowerRight - screen.corners->lowerLeft;
    Vec3 up = screen.corners->upperLeft - screen.corners->lowerLeft;
    up -= right * (up.dot(right) / right.squaredNorm());
    json["corners_m"] = Json{{"lower_left", point(screen.corners->lowerLeft)},
                             {"lower_right", point(screen.corners->lowerRight)},
                             {"upper_left", point(screen.corners->lowerLeft + up)}};
  }
  if (screen.sizeMm) json["size_mm"] = pair(*screen.sizeMm);
  Json tiles = Json::array();
  for (const walltext::Tile& tile : screen.tiles) {
    Json one;
    one["name"] = tile.name;
    one["px"] = tile.px;
    one["at_mm"] = pair(tile.atMm);
    one["size_mm"] = pair(tile.sizeMm);
    addSettings(one, tile.settings);
    tiles.push_back(std::move(one));
  }
  json["tiles"] = std::move(tiles);
  return json;
}

/// What is wrong with it; empty: nothing.
std::string faultOf(const std::string& tile, std::array<int, 2> px, const std::array<double, 2>& sizeMm) {
  if (px[0] < 1 || px[1] < 1 || px[0] > kMaxTilePx || px[1] > kMaxTilePx) {
    return "the tile " + tile + " has " + std::to_string(px[0]) + " x " + std::to_string(px[1]) +
           " pixels; 1 to " + std::to_string(kMaxTilePx) + " a side are possible";
  }
  const auto isLength = [](double mm) { return mm >= kLeastTileMm && mm <= kMaxCoordinateM * 1000; };
  if (!isLength(sizeMm[0]) || !isLength(sizeMm[1])) return "the tile " + tile + " has no possible size";
  return {};
}

std::string faultOf(const std::string& tile, const walltext::Settings& settings) {
  if (settings.host.size() > kMaxHostBytes) {
    return "the host of tile " + tile + " is longer than " + std::to_string(kMaxHostBytes) + " bytes";
  }
  if (settings.windowPx && (std::abs((*settings.windowPx)[0]) > kMaxWindowPx ||
                            std::abs((*settings.windowPx)[1]) > kMaxWindowPx)) {
    return "the window of tile " + tile + " lies more than " + std::to_string(kMaxWindowPx) + " pixels away";
  }
  return {};
}

std::string faultOf(const walltext::Screen& screen) {
  if (screen.corners) {
    const auto isNear = [](const Vec3& p) {
      return isFinite(p) && p.cwiseAbs().maxCoeff() <= kMaxCoordinateM;
    };
    const Vec3 right = screen.corners->lowerRight - screen.corners->lowerLeft;
    const Vec3 up = screen.corners->upperLeft - screen.corners->lowerLeft;
    if (!isNear(screen.corners->lowerLeft) || !isNear(screen.corners->lowerRight) ||
        !isNear(screen.corners->upperLeft)) {
      return "a corner of the screen " + screen.name + " is further away than 1000 km";
    }
    if (lengthOf(right) < kLeastScreenM || lengthOf(up) < kLeastScreenM) {
      return "the screen " + screen.name + " is smaller than a millimetre";
    }
    if (std::abs(right.dot(up)) > 1e-3 * lengthOf(right) * lengthOf(up)) {
      return "the corners of the screen " + screen.name + " make no rectangle";
    }
  }
  for (const walltext::Tile& tile : screen.tiles) {
    const auto isPlace = [](double mm) { return std::abs(mm) <= kMaxCoordinateM * 1000; };
    if (!isPlace(tile.atMm[0]) || !isPlace(tile.atMm[1])) return "the tile " + tile.name + " is out of reach";
    if (std::string fault = faultOf(tile.name, tile.px, tile.sizeMm); !fault.empty()) return fault;
    if (std::string fault = faultOf(tile.name, tile.settings); !fault.empty()) return fault;
    if (!screen.corners) continue;
    const double width = lengthOf(screen.corners->lowerRight - screen.corners->lowerLeft) * 1000;
    const double height = lengthOf(screen.corners->upperLeft - screen.corners->lowerLeft) * 1000;
    const double slack = 1e-6 * std::max(width, height);
    if (tile.atMm[0] < -slack || tile.atMm[1] < -slack || tile.atMm[0] + tile.sizeMm[0] > width + slack ||
        tile.atMm[1] + tile.sizeMm[1] > height + slack) {
      return "the tile " + tile.name + " reaches over the edge of the screen " + screen.name;
    }
  }
  return {};
}

/// Whether an eye that is not well before `screen` looks at it.
bool isBehind(const walltext::Screen& screen, const walltext::Observer& observer) {
  if (!screen.corners) return false;
  const Vec3 right = screen.corners->lowerRight - screen.corners->lowerLeft;
  const Vec3 normal = right.cross(screen.corners->upperLeft - screen.corners->lowerLeft).normalized();
  const double distance = normal.dot(observer.eyeM - screen.corners->lowerLeft);
  const bool isStereo = observer.stereo != walltext::Stereo::None;
  return !(distance - (isStereo ? std::abs(normal.x()) * observer.separationMm / 2000 : 0) >=
           kLeastEyeDistanceM);
}

std::string faultOf(const walltext::Wall& wall) {
  std::size_t tiles = 0;
  if (wall.grid) {
    tiles = static_cast<std::size_t>(wall.grid->columns) * static_cast<std::size_t>(wall.grid->rows);
    if (std::string fault = faultOf("r0c0", wall.grid->tilePx, wall.grid->tileMm); !fault.empty())
      return fault;
    if (wall.grid->columns > kMaxGridSide || wall.grid->rows > kMaxGridSide) {
      return "describes more than " + std::to_string(kMaxGridSide) + " tiles side by side";
    }
    if (wall.grid->columns * wall.grid->tilePx[0] > kMaxWallPx ||
        wall.grid->rows * wall.grid->tilePx[1] > kMaxWallPx) {
      return "describes a wall of more than " + std::to_string(kMaxWallPx) + " pixels a side";
    }
    if (tiles <= wall.grid->missing.size()) tiles = 0;
    for (const auto& [name, settings] : wall.grid->settings) {
      if (std::string fault = faultOf(name, settings); !fault.empty()) return fault;
    }
  }
  for (const walltext::Screen& screen : wall.screens) {
    tiles += screen.tiles.size();
    if (std::string fault = faultOf(screen); !fault.empty()) return fault;
  }
  if (tiles == 0) return "describes no tile of a wall";
  if (tiles > kMaxTiles) return "describes more than " + std::to_string(kMaxTiles) + " tiles";
  if (wall.screens.size() > kMaxScreens) {
    return "describes more than " + std::to_string(kMaxScreens) + " flat screens";
  }
  if (wall.observer &&
      !(isFinite(wall.observer->eyeM) && wall.observer->eyeM.cwiseAbs().maxCoeff() <= kMaxCoordinateM)) {
    return "the eye is further away than 1000 km";
  }
  if (wall.observer && wall.observer->stereo != walltext::Stereo::None &&
      !(wall.observer->separationMm >= 0 && wall.observer->separationMm <= 10'000)) {
    return "the eyes are further than 10 m apart";
  }
  for (const walltext::Screen& screen : wall.screens) {
    if (wall.observer && isBehind(screen, *wall.observer)) {
      return "the eye does not stand before the screen " + screen.name;
    }
    for (const walltext::Tile& tile : screen.tiles) {
      const walltext::Stereo stereo = wall.observer ? wall.observer->stereo : walltext::Stereo::None;
      if ((stereo == walltext::Stereo::SideBySide && tile.px[0] % 2 != 0) ||
          (stereo == walltext::Stereo::TopBottom && tile.px[1] % 2 != 0)) {
        return "the pixels of the tile " + tile.name + " cannot be halved for two eyes";
      }
    }
  }
  return {};
}

std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; },
      ' ');
  return text;
}

/// As many whole UTF-8 characters as fit.
std::string cut(const std::string& text, std::size_t longestBytes) {
  std::size_t end = std::min(text.size(), longestBytes);
  while (end > 0 && end < text.size() && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80)
    --end;
  return text.substr(0, end);
}

}  // namespace

void settleEyes(walltext::Wall& wall, WarningList& warnings) {
  if (!wall.observer || wall.observer->stereo != walltext::Stereo::Tiles) return;
  for (walltext::Screen& screen : wall.screens) {
    for (walltext::Tile& tile : screen.tiles) {
      if (tile.settings.eye != walltext::Eye::Both) continue;
      tile.settings.eye = walltext::Eye::Left;
      warnings.add("picture for both eyes on a wall whose other pictures are for one", 0,
                   "the first is " + tile.name + "; shows the left eye's");
    }
  }
}

Result<std::string> wallText(const walltext::Wall& wall, const std::string& sourceName) {
  if (std::string fault = faultOf(wall); !fault.empty()) return inputError(sourceName, std::move(fault));
  Json json;
  json["$schema"] = "wall.schema.json";
  json["name"] = cut(oneLine(wall.name), kMaxNameBytes);
  if (wall.grid) {
    json["grid"] = gridJson(*wall.grid);
    Json tiles = Json::object();
    for (const auto& [name, settings] : wall.grid->settings) {
      Json one = Json::object();
      addSettings(one, settings);
      if (!one.empty()) tiles[name] = std::move(one);
    }
    if (!tiles.empty()) json["tiles"] = std::move(tiles);
  } else {
    json["screens"] = Json::array();
    for (const walltext::Screen& screen : wall.screens)
      json["screens"].push_back(screenJson(screen));
  }
  if (wall.observer) {
    Json observer;
    observer["eye_m"] = point(wall.observer->eyeM);
    if (wall.observer->stereo != walltext::Stereo::None) {
      observer["stereo"] = Json{{"mode", stereoName(wall.observer->stereo)},
                                {"separation_mm", number(wall.observer->separationMm)}};
    }
    json["observer"] = std::move(observer);
  }
  // The comment goes through the JSON writer as well, which mends UTF-8 that is none.
  const std::string comment = dumped(cut(oneLine(wall.origin), 300));
  return "// " + comment.substr(1, comment.size() - 2) + '\n' + prettyText(json, 0, 0) + '\n';
}

std::string NameMaker::make(std::string_view wanted) {
  constexpr std::size_t kLongest = 64;
  std::string base;
  for (const char c : wanted.substr(0, kLongest)) {
    const bool isFine = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                        c == '_' || c == '.' || c == '-';
    base += isFine ? c : '-';
  }
  if (base.empty()) base = "tile";
  std::string name = base;
  for (int i = 2; !taken_.insert(name).second; ++i) {
    const std::string suffix = '-' + std::to_string(i);
    name = base.substr(0, kLongest - suffix.size()) + suffix;
  }
  return name;
}

}  // namespace tessera
