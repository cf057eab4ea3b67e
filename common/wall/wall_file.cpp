#include "common/wall/wall_file.h"

#include <algorithm>
#include <numbers>
#include <unordered_map>

#include "common/base/file.h"
#include "common/wall/json_document.h"
#include "common/wall/json_reader.h"

namespace tessera {

namespace {

constexpr NumberRange kClipRangeM{1e-9, 1e15};

bool isTileName(std::string_view name) {
  constexpr std::string_view kAllowed = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_.-";
  return !name.empty() && name.size() <= kMaxTileNameBytes &&
         name.find_first_not_of(kAllowed) == std::string_view::npos;
}

std::string sizeText(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

std::string defaultName(int column, int row) {
  return std::string("r").append(std::to_string(row)).append("c").append(std::to_string(column));
}

/// Builds one Wall; each function reads one part of the file.
class WallReader {
 public:
  explicit WallReader(const std::string& sourceName) : json_(sourceName) { wall_.source = sourceName; }

  Result<Wall> read(const JsonDocument& document) {
    const JsonValue root = document.root();
    wall_.fovYRad = radians(kDefaultFovYDeg);
    if (json_.object(root, "wall", {"$schema", "name", "grid", "camera"})) {
      if (const auto schema = root.find("$schema")) json_.string(*schema, "$schema", kMaxWallNameBytes);
      if (const auto name = root.find("name")) wall_.name = json_.string(*name, "name", kMaxWallNameBytes);
      if (const auto grid = json_.required(root, "wall", "grid")) readGrid(*grid);
      if (const auto camera = root.find("camera")) readCamera(*camera);
    }
    if (json_.error()) return *json_.error();
    return std::move(wall_);
  }

 private:
  static double radians(double degrees) { return degrees * (std::numbers::pi / 180); }

  void readGrid(const JsonValue& grid) {
    if (!json_.object(grid, "grid", {"columns", "rows", "tile_px", "names"})) return;
    const NumberRange side{1, kMaxGridSide};
    if (const auto columns = json_.required(grid, "grid", "columns")) {
      wall_.columns = json_.integer(*columns, "columns", side);
    }
    if (const auto rows = json_.required(grid, "grid", "rows")) {
      wall_.rows = json_.integer(*rows, "rows", side);
    }
    const auto tilePx = json_.required(grid, "grid", "tile_px");
    if (tilePx) readTilePx(*tilePx);
    if (!json_.ok()) return;
    checkSize(grid, *tilePx);
    if (!json_.ok()) return;
    makeTiles();
    if (const auto names = grid.find("names")) readNames(*names);
    warnOfOddTiles();
  }

  void readTilePx(const JsonValue& tilePx) {
    if (!json_.array(tilePx, "tile_px")) return;
    const std::vector<JsonValue> sides = tilePx.children();
    if (sides.size() != 2) {
      return json_.fail(tilePx.line(),
                        "\"tile_px\" must be an array of 2 numbers, not of " + std::to_string(sides.size()),
                        "write [width, height]");
    }
    wall_.tileWidthPx = json_.integer(sides[0], "tile_px", {1, kMaxTilePx});
    wall_.tileHeightPx = json_.integer(sides[1], "tile_px", {1, kMaxTilePx});
  }

  void checkSize(const JsonValue& grid, const JsonValue& tilePx) {
    const int tileCount = wall_.columns * wall_.rows;
    if (tileCount > kMaxTiles) {
      json_.fail(grid.line(), "the grid has " + std::to_string(tileCount) + " tiles",
                 "a wall has at most " + std::to_string(kMaxTiles));
    }
    if (wall_.widthPx() > kMaxWallPx || wall_.heightPx() > kMaxWallPx) {
      json_.fail(tilePx.line(), "the wall has " + sizeText(wall_.widthPx(), wall_.heightPx()) + " pixels",
                 "a wall has at most " + std::to_string(kMaxWallPx) + " each way");
    }
  }

  void makeTiles() {
    for (int row = 0; row < wall_.rows; ++row) {
      for (int column = 0; column < wall_.columns; ++column) {
        wall_.tiles.push_back({defaultName(column, row), column, row, column * wall_.tileWidthPx,
                               row * wall_.tileHeightPx, wall_.tileWidthPx, wall_.tileHeightPx});
      }
    }
  }

  void readNames(const JsonValue& names) {
    if (!json_.array(names, "names")) return;
    const std::vector<JsonValue> rows = names.children();
    if (rows.size() != static_cast<std::size_t>(wall_.rows)) {
      return json_.fail(
          names.line(),
          "\"names\" has " + std::to_string(rows.size()) + " rows, the grid " + std::to_string(wall_.rows),
          "name every tile, row by row from the top");
    }
    auto tile = wall_.tiles.begin();
    for (const JsonValue& row : rows) {
      if (!json_.array(row, "names")) return;
      const std::vector<JsonValue> columns = row.children();
      if (columns.size() != static_cast<std::size_t>(wall_.columns)) {
        return json_.fail(row.line(),
                          "a row of \"names\" has " + std::to_string(columns.size()) +
                              " names, the grid has " + std::to_string(wall_.columns) + " columns",
                          "name every tile, from the left");
      }
      for (const JsonValue& name : columns)
        readName(name, *tile++);
    }
  }

  void readName(const JsonValue& value, Tile& tile) {
    if (value.kind() != JsonKind::String || !isTileName(value.string())) {
      const std::string shown = value.kind() == JsonKind::String ? excerpt(value.string(), 64) : "no string";
      return json_.fail(
          value.line(), "a tile cannot be named \"" + shown + "\"",
          "a name is 1 to " + std::to_string(kMaxTileNameBytes) + " of the characters A-Z a-z 0-9 _ . -");
    }
    tile.name = value.string();
    const Named here{tile.column, tile.row, value.line()};
    const auto [first, isNew] = named_.emplace(tile.name, here);
    if (isNew) return;
    json_.fail(here.line,
               "two tiles are named \"" + tile.name + "\": " + placeText(here) + " and " +
                   placeText(first->second) + " on line " + std::to_string(first->second.line),
               "rename one of them");
  }

  void readCamera(const JsonValue& camera) {
    if (!json_.object(camera, "camera", {"fov_y_deg", "near_m", "far_m"})) return;
    if (const auto fov = camera.find("fov_y_deg")) {
      wall_.fovYRad = radians(json_.number(*fov, "fov_y_deg", {kMinFovYDeg, kMaxFovYDeg}));
    }
    if (const auto near = camera.find("near_m")) wall_.near = json_.number(*near, "near_m", kClipRangeM);
    const auto far = camera.find("far_m");
    if (far) wall_.far = json_.number(*far, "far_m", kClipRangeM);
    if (wall_.near && wall_.far && !(*wall_.near < *wall_.far)) {
      json_.fail(far->line(),
                 "\"far_m\" (" + numberText(*wall_.far) + ") must be greater than \"near_m\" (" +
                     numberText(*wall_.near) + ")",
                 "leave both out to have them fitted to the scene");
    }
  }

  void warnOfOddTiles() {
    const bool isOddAcross = wall_.columns > 1 && wall_.tileWidthPx % 2 != 0;
    const bool isOddDown = wall_.rows > 1 && wall_.tileHeightPx % 2 != 0;
    if (!isOddAcross && !isOddDown) return;
    wall_.warnings.push_back(
        "tiles of " + sizeText(wall_.tileWidthPx, wall_.tileHeightPx) +
        " pixels start at odd pixels of the wall, where texture mip-maps may shift at the seams by up to a "
        "quad of pixels; even tile sizes avoid it");
  }

  struct Named {
    int column, row, line;
  };
  static std::string placeText(const Named& named) {
    return "the one of row " + std::to_string(named.row) + ", column " + std::to_string(named.column);
  }

  JsonReader json_;
  Wall wall_;
  std::unordered_map<std::string, Named> named_;
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
