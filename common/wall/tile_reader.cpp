#include "common/wall/tile_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "common/wall/wall_file.h"

namespace tessera {

namespace {

constexpr std::size_t kMostTextBytes = 256;
constexpr std::size_t kMostPathBytes = 4096;

bool isName(std::string_view name) {
  constexpr std::string_view kAllowed = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_.-";
  return !name.empty() && name.size() <= kMaxTileNameBytes &&
         name.find_first_not_of(kAllowed) == std::string_view::npos;
}

std::string defaultName(int column, int row) {
  return std::string("r").append(std::to_string(row)).append("c").append(std::to_string(column));
}

std::string sizeText(long long width, long long height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

}  // namespace

void TileReader::pixels(const JsonValue& value, const char* label, int& width, int& height) {
  if (!json_.array(value, label)) return;
  const std::vector<JsonValue> sides = value.children();
  if (sides.size() != 2) {
    return json_.fail(value.line(),
                      std::string("\"") + label + "\" must be an array of 2 numbers, not of " +
                          std::to_string(sides.size()),
                      "write [width, height]");
  }
  width = json_.integer(sides[0], label, {1, kMaxTilePx});
  height = json_.integer(sides[1], label, {1, kMaxTilePx});
}

std::array<double, 2> TileReader::pair(const JsonValue& value, const char* label, NumberRange range) {
  if (value.kind() == JsonKind::Number) {
    const double both = json_.number(value, label, range);
    return {both, both};
  }
  const std::vector<double> two = json_.numbers(value, label, 2, range);
  return {two[0], two[1]};
}

Sides<double> TileReader::sides(const JsonValue& value, const char* label, double most) {
  const NumberRange range{0, most};
  if (value.kind() != JsonKind::Object) {
    const std::array<double, 2> both = pair(value, label, range);
    return {both[0], both[0], both[1], both[1]};
  }
  Sides<double> sides;
  if (!json_.object(value, label, {"left", "right", "bottom", "top"})) return sides;
  const auto side = [&](const char* key, double& of) {
    if (const auto found = value.find(key)) of = json_.number(*found, key, range);
  };
  side("left", sides.left);
  side("right", sides.right);
  side("bottom", sides.bottom);
  side("top", sides.top);
  return sides;
}

std::string TileReader::name(const JsonValue& value, const char* what) {
  if (value.kind() == JsonKind::String && isName(value.string())) {
    std::string name(value.string());
    claimName(name, value.line());
    return name;
  }
  const std::string shown = value.kind() == JsonKind::String ? excerpt(value.string(), 64) : "no string";
  json_.fail(value.line(), std::string("a ") + what + " cannot be named \"" + shown + "\"",
             "a name is 1 to " + std::to_string(kMaxTileNameBytes) + " of the characters A-Z a-z 0-9 _ . -");
  return "?";
}

void TileReader::claimName(const std::string& name, int line) {
  const auto [first, isNew] = lines_.emplace(name, line);
  if (isNew) return;
  json_.fail(line, "two tiles are named \"" + name + "\": here and on line " + std::to_string(first->second),
             "rename one of them");
}

int TileReader::lineOf(const std::string& name) const {
  const auto found = lines_.find(name);
  return found == lines_.end() ? 1 : found->second;
}

GridSpec TileReader::grid(const JsonValue& grid) {
  GridSpec spec;
  if (!json_.object(grid, "grid",
                    {"columns", "rows", "tile_px", "names", "missing", "tile_mm", "bezel_mm", "bezel",
                     "overlap_px", "overlap_mm", "rotation_deg", "tile"}))
    return spec;
  const NumberRange side{1, kMaxGridSide};
  if (const auto columns = json_.required(grid, "grid", "columns"))
    spec.columns = json_.integer(*columns, "columns", side);
  if (const auto rows = json_.required(grid, "grid", "rows")) spec.rows = json_.integer(*rows, "rows", side);
  const auto tilePx = json_.required(grid, "grid", "tile_px");
  if (tilePx) pixels(*tilePx, "tile_px", spec.tileWidthPx, spec.tileHeightPx);
  if (const auto rotation = grid.find("rotation_deg")) {
    const double degrees = json_.number(*rotation, "rotation_deg", {0, 270});
    if (std::fmod(degrees, 90) != 0) {
      json_.fail(rotation->line(),
                 "the tiles of a grid cannot be turned by " + numberText(degrees) + " degrees",
                 "0, 90, 180 or 270; tiles that are turned freely are placed one by one, in \"tiles\"");
    }
    spec.quarterTurns = static_cast<int>(degrees / 90);
  }
  if (const auto tileMm = grid.find("tile_mm")) spec.tileMm = pair(*tileMm, "tile_mm", {1e-3, kMostMm});
  if (json_.ok()) gridSize(grid, *tilePx, spec);
  if (json_.ok()) gridGaps(grid, spec);
  if (json_.ok()) gridNames(grid, spec);
  if (const auto tile = grid.find("tile")) {
    if (json_.object(
            *tile, "tile",
            {"host", "monitor", "window_px", "eye", "gain_rgb", "black_rgb", "gamma", "blend_px", "warp"})) {
      if (tile->find("blend_px") || tile->find("warp") || tile->find("eye")) {
        json_.fail(tile->line(), "\"eye\", \"blend_px\" and \"warp\" are of one tile, not of all of a grid",
                   "say them in \"tiles\" by the tile's name");
      }
      TileEye none = TileEye::Both;
      settings(*tile, spec.output, none);
    }
  }
  return spec;
}

void TileReader::gridSize(const JsonValue& grid, const JsonValue& tilePx, const GridSpec& spec) {
  const int tileCount = spec.columns * spec.rows;
  if (tileCount > kMaxTiles) {
    json_.fail(grid.line(), "the grid has " + std::to_string(tileCount) + " tiles",
               "a wall has at most " + std::to_string(kMaxTiles));
  }
  const bool isTurned = spec.quarterTurns % 2 != 0;
  const long long width =
      static_cast<long long>(spec.columns) * (isTurned ? spec.tileHeightPx : spec.tileWidthPx);
  const long long height =
      static_cast<long long>(spec.rows) * (isTurned ? spec.tileWidthPx : spec.tileHeightPx);
  if (width > kMaxWallPx || height > kMaxWallPx) {
    json_.fail(tilePx.line(), "the wall has " + sizeText(width, height) + " pixels",
               "a wall has at most " + std::to_string(kMaxWallPx) + " each way");
  }
}

void TileReader::gridGaps(const JsonValue& grid, GridSpec& spec) {
  const auto bezelMm = grid.find("bezel_mm"), overlapPx = grid.find("overlap_px"),
             overlapMm = grid.find("overlap_mm");
  if (bezelMm) spec.bezelMm = sides(*bezelMm, "bezel_mm", kMostMm);
  if (const auto bezel = grid.find("bezel"))
    spec.compresses = json_.choice(*bezel, "bezel", {"hide", "compress"}) == 1;
  if (overlapPx && overlapMm) {
    return json_.fail(overlapMm->line(), "\"overlap_px\" and \"overlap_mm\" say the same thing twice",
                      "keep one of them");
  }
  const auto overlap = overlapPx ? overlapPx : overlapMm;
  if (!overlap) return;
  if (bezelMm) {
    return json_.fail(overlap->line(), "tiles cannot have bezels and overlap",
                      "\"bezel_mm\" is for panels, \"overlap_px\" for projectors");
  }
  const std::array<double, 2> most = {kMaxTilePx, kMostMm};
  const std::array<double, 2> both =
      pair(*overlap, overlapPx ? "overlap_px" : "overlap_mm", {0, overlapPx ? most[0] : most[1]});
  const bool isTurned = spec.quarterTurns % 2 != 0;
  const std::array<double, 2> px = {static_cast<double>(isTurned ? spec.tileHeightPx : spec.tileWidthPx),
                                    static_cast<double>(isTurned ? spec.tileWidthPx : spec.tileHeightPx)};
  const std::array<double, 2> mm =
      spec.tileMm ? std::array<double, 2>{(*spec.tileMm)[isTurned ? 1 : 0], (*spec.tileMm)[isTurned ? 0 : 1]}
                  : px;
  for (std::size_t i = 0; i < 2; ++i) {
    const double tile = overlapPx ? px[i] : mm[i];
    if (both[i] < tile) continue;
    const char* unit = overlapPx ? " px" : " mm";
    return json_.fail(overlap->line(),
                      std::string("tiles overlap by ") + numberText(both[i]) + unit +
                          (i == 0 ? " across" : " down") + ", which is more than a tile has (" +
                          numberText(tile) + unit + ")",
                      "an overlap is smaller than a tile");
  }
  if (!overlapPx && !spec.tileMm) {
    return json_.fail(overlap->line(), "\"overlap_mm\" means nothing without the size of a tile",
                      "add \"tile_mm\", or say the overlap in pixels: \"overlap_px\"");
  }
  if (overlapPx) spec.overlapPx = both;
  if (!overlapPx) spec.overlapMm = both;
}

void TileReader::gridNames(const JsonValue& grid, GridSpec& spec) {
  const auto names = grid.find("names");
  if (!names) {
    for (int row = 0; row < spec.rows; ++row) {
      for (int column = 0; column < spec.columns; ++column)
        spec.names.push_back(defaultName(column, row));
    }
    if (const auto missing = grid.find("missing")) gridMissing(*missing, spec);
    for (const std::string& name : spec.names) {
      if (!name.empty()) claimName(name, grid.line());
    }
    return;
  }
  if (const auto missing = grid.find("missing")) {
    return json_.fail(missing->line(), "\"missing\" and \"names\" cannot both be there",
                      "write null in \"names\" where no tile is");
  }
  if (!json_.array(*names, "names")) return;
  const std::vector<JsonValue> rows = names->children();
  if (rows.size() != static_cast<std::size_t>(spec.rows)) {
    return json_.fail(
        names->line(),
        "\"names\" has " + std::to_string(rows.size()) + " rows, the grid " + std::to_string(spec.rows),
        "name every tile, row by row from the top");
  }
  for (const JsonValue& row : rows) {
    if (!json_.array(row, "names")) return;
    const std::vector<JsonValue> columns = row.children();
    if (columns.size() != static_cast<std::size_t>(spec.columns)) {
      return json_.fail(row.line(),
                        "a row of \"names\" has " + std::to_string(columns.size()) + " names, the grid has " +
                            std::to_string(spec.columns) + " columns",
                        "name every tile, from the left");
    }
    for (const JsonValue& value : columns)
      spec.names.push_back(value.kind() == JsonKind::Null ? std::string() : name(value, "tile"));
  }
}

void TileReader::gridMissing(const JsonValue& missing, GridSpec& spec) {
  if (!json_.array(missing, "missing")) return;
  for (const JsonValue& value : missing.children()) {
    const std::string name = json_.string(value, "missing", kMaxTileNameBytes);
    const auto found = std::find(spec.names.begin(), spec.names.end(), name);
    if (found == spec.names.end() || name.empty()) {
      return json_.fail(
          value.line(), "the grid has no tile \"" + excerpt(name, 64) + "\" that could be missing",
          "its tiles are " + spec.names.front() + " to " + defaultName(spec.columns - 1, spec.rows - 1));
    }
    found->clear();
  }
}

void TileReader::turnTo(const JsonValue& value, Tile& tile) {
  const double degrees = json_.number(value, "rotation_deg", {-360, 360});
  const double positive = degrees < 0 ? degrees + 360 : degrees;
  const double quarters = std::floor(positive / 90);
  if (positive == quarters * 90) {
    tile.quarterTurns = static_cast<int>(quarters) % 4;
  } else {
    tile.freeTurnRad = positive * (std::numbers::pi / 180);
  }
}

TileReader::Placed TileReader::place(const JsonValue& value, Tile& tile) {
  if (const auto px = json_.required(value, "tile", "px")) pixels(*px, "px", tile.widthPx, tile.heightPx);
  if (const auto sizeMm = json_.required(value, "tile", "size_mm")) {
    const std::array<double, 2> size = pair(*sizeMm, "size_mm", {1e-3, kMostMm});
    tile.widthMm = size[0];
    tile.heightMm = size[1];
  }
  if (const auto rotation = value.find("rotation_deg")) turnTo(*rotation, tile);
  const bool isTurned = tile.quarterTurns % 2 != 0;
  const double width = isTurned ? tile.heightMm : tile.widthMm,
               height = isTurned ? tile.widthMm : tile.heightMm;
  const auto atMm = value.find("at_mm"), centerMm = value.find("center_mm");
  if ((atMm && centerMm) || (!atMm && !centerMm)) {
    json_.fail(value.line(), "a tile's place is said once, by \"at_mm\" or by \"center_mm\"",
               atMm ? "remove one of them" : "add one of them");
    return {};
  }
  const std::vector<double> at =
      json_.numbers(atMm ? *atMm : *centerMm, atMm ? "at_mm" : "center_mm", 2, {-kMostMm, kMostMm});
  if (atMm && tile.freeTurnRad != 0) {
    json_.fail(atMm->line(), "a tile that is turned freely has no upper left corner to place it by",
               "place it by \"center_mm\"");
  }
  if (atMm) return {at[0], at[1], at[0] + width, at[1] + height};
  return {at[0] - width / 2, at[1] - height / 2, at[0] + width / 2, at[1] + height / 2};
}

void TileReader::tiles(const JsonValue& value, std::uint32_t screenIndex, Screen& screen,
                       std::vector<Tile>& tiles) {
  if (!json_.array(value, "tiles")) return;
  const std::vector<JsonValue> values = value.children();
  if (values.empty() || tiles.size() + values.size() > static_cast<std::size_t>(kMaxTiles)) {
    return json_.fail(value.line(), values.empty() ? "a screen without tiles" : "there are too many tiles",
                      "a wall has 1 to " + std::to_string(kMaxTiles));
  }
  std::vector<Placed> places;
  double left = INFINITY, top = INFINITY, right = -INFINITY, bottom = -INFINITY;
  for (const JsonValue& entry : values) {
    if (!json_.object(entry, "tile",
                      {"name", "px", "at_mm", "center_mm", "size_mm", "rotation_deg", "host", "monitor",
                       "window_px", "eye", "gain_rgb", "black_rgb", "gamma", "blend_px", "warp"}))
      return;
    Tile tile;
    tile.screen = screenIndex;
    if (const auto named = json_.required(entry, "tile", "name")) tile.name = name(*named, "tile");
    const Placed place = this->place(entry, tile);
    settings(entry, tile.output, tile.eye);
    if (!json_.ok()) return;
    const double x = (place.left + place.right) / 2, y = (place.top + place.bottom) / 2;
    const double c = std::abs(std::cos(tile.freeTurnRad)), s = std::abs(std::sin(tile.freeTurnRad));
    const double halfWidth = (place.right - place.left) / 2, halfHeight = (place.bottom - place.top) / 2;
    const double reachX = tile.freeTurnRad == 0 ? halfWidth : c * halfWidth + s * halfHeight,
                 reachY = tile.freeTurnRad == 0 ? halfHeight : s * halfWidth + c * halfHeight;
    left = std::min(left, x - reachX), right = std::max(right, x + reachX);
    top = std::min(top, y - reachY), bottom = std::max(bottom, y + reachY);
    const double slack = 1e-6 * std::max(screen.widthMm, screen.heightMm);
    if (screen.widthMm > 0 && (x - reachX < -slack || y - reachY < -slack ||
                               x + reachX > screen.widthMm + slack || y + reachY > screen.heightMm + slack)) {
      return json_.fail(entry.line(),
                        "tile \"" + tile.name + "\" lies outside its screen: it reaches from " +
                            numberText(x - reachX) + ", " + numberText(y - reachY) + " to " +
                            numberText(x + reachX) + ", " + numberText(y + reachY) + " mm, the screen to " +
                            numberText(screen.widthMm) + ", " + numberText(screen.heightMm),
                        "move it or enlarge the screen");
    }
    places.push_back(place);
    tiles.push_back(std::move(tile));
  }
  const bool hasSize = screen.widthMm > 0;
  const double originX = hasSize ? 0 : left, originY = hasSize ? 0 : top;
  if (!hasSize) screen.widthMm = right - left, screen.heightMm = bottom - top;
  screen.tileCount = static_cast<std::uint32_t>(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    Tile& tile = tiles[screen.firstTile + i];
    const auto x = [&](double mm) { return (2 * (mm - originX) - screen.widthMm) / screen.widthMm; };
    const auto y = [&](double mm) { return (screen.heightMm - 2 * (mm - originY)) / screen.heightMm; };
    const Placed& at = places[i];
    tile.corners = {Vec2(x(at.left), y(at.bottom)), Vec2(x(at.right), y(at.bottom)),
                    Vec2(x(at.right), y(at.top)), Vec2(x(at.left), y(at.top))};
    tile.mountMm = Vec2((at.left + at.right) / 2 - originX - screen.widthMm / 2,
                        screen.heightMm / 2 - ((at.top + at.bottom) / 2 - originY));
    if (tile.freeTurnRad == 0) continue;
    const double c = std::cos(tile.freeTurnRad), s = std::sin(tile.freeTurnRad);
    const double halfWidth = tile.widthMm / 2, halfHeight = tile.heightMm / 2;
    const std::array<Vec2, 4> signs = {Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1)};
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const double across = signs[corner].x() * halfWidth, up = signs[corner].y() * halfHeight;
      const Vec2 mm = tile.mountMm + Vec2(c * across + s * up, c * up - s * across);
      tile.corners[corner] = Vec2(2 * mm.x() / screen.widthMm, 2 * mm.y() / screen.heightMm);
    }
  }
}

void TileReader::settings(const JsonValue& value, TileOutput& output, TileEye& eye) {
  if (const auto host = value.find("host")) output.host = json_.string(*host, "host", kMostTextBytes);
  if (const auto monitor = value.find("monitor"))
    output.monitor = json_.string(*monitor, "monitor", kMostTextBytes);
  if (const auto window = value.find("window_px")) {
    if (!output.monitor.empty()) {
      json_.fail(window->line(), "\"monitor\" is full screen, \"window_px\" a window", "keep one of them");
    }
    const std::vector<double> at = json_.numbers(*window, "window_px", 2, {-65536, 65536});
    output.windowPx = {static_cast<int>(at[0]), static_cast<int>(at[1])};
  }
  if (const auto found = value.find("eye"))
    eye = static_cast<TileEye>(json_.choice(*found, "eye", {"both", "left", "right"}));
  const auto three = [&](const char* key, NumberRange range, std::array<double, 3>& to) {
    const auto found = value.find(key);
    if (!found) return;
    const Vec3 v = json_.vec3(*found, key, range);
    to = {v.x(), v.y(), v.z()};
  };
  three("gain_rgb", {0, 4}, output.gainRgb);
  three("black_rgb", {0, 1}, output.blackRgb);
  if (const auto gamma = value.find("gamma")) output.gamma = json_.number(*gamma, "gamma", {0.5, 5});
  if (const auto blend = value.find("blend_px")) {
    const Sides<double> ramps = sides(*blend, "blend_px", kMaxTilePx);
    output.blendPx = {ramps.left, ramps.right, ramps.bottom, ramps.top};
  }
  if (const auto found = value.find("warp")) warp(*found, output);
}

void TileReader::warp(const JsonValue& value, TileOutput& output) {
  if (!json_.object(value, "warp", {"mpcdi", "region"})) return;
  const auto file = json_.required(value, "warp", "mpcdi"), region = json_.required(value, "warp", "region");
  if (!file || !region) return;
  const std::filesystem::path path = json_.string(*file, "mpcdi", kMostPathBytes);
  output.warpFile = path.is_absolute() ? path : std::filesystem::path(source_).parent_path() / path;
  output.warpRegion = json_.string(*region, "region", kMostTextBytes);
}

void TileReader::overrides(const JsonValue& value, std::vector<Tile>& tiles) {
  if (value.kind() != JsonKind::Object) return static_cast<void>(json_.object(value, "tiles", {}));
  for (const JsonValue& entry : value.children()) {
    const auto tile =
        std::find_if(tiles.begin(), tiles.end(), [&](const Tile& t) { return t.name == entry.key(); });
    if (tile == tiles.end()) {
      std::string_view nearest = tiles.front().name;
      for (const Tile& t : tiles)
        nearest = nearestWord(excerpt(entry.key(), kMaxTileNameBytes), {nearest, t.name});
      return json_.fail(entry.keyLine(),
                        "there is no tile \"" + excerpt(entry.key(), kMaxTileNameBytes) + "\"",
                        "did you mean \"" + std::string(nearest) + "\"?");
    }
    if (!json_.object(
            entry, "tile",
            {"host", "monitor", "window_px", "eye", "gain_rgb", "black_rgb", "gamma", "blend_px", "warp"}))
      return;
    settings(entry, tile->output, tile->eye);
  }
}

}  // namespace tessera
