#pragma once

#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/wall/grid_layout.h"
#include "common/wall/json_reader.h"
#include "common/wall/wall.h"

namespace tessera {

inline constexpr double kMostMm = 1e9;  ///< of any length on a screen

/// Reads screens' grids and tiles and what is said of single tiles, for the wall reader; errors go to `json`.
/// Every name is checked against those before.
class TileReader {
 public:
  /// `sourceName`: files are named relative to its folder.
  TileReader(JsonReader& json, const std::string& sourceName) : json_(json), source_(sourceName) {}

  [[nodiscard]] GridSpec grid(const JsonValue& value);
  /// Tiles that are placed one by one, at the end of `tiles`; a screen of unknown size becomes what they
  /// cover.
  void tiles(const JsonValue& value, std::uint32_t screenIndex, Screen& screen, std::vector<Tile>& tiles);
  /// "tiles" of the whole file: settings by name.
  void overrides(const JsonValue& value, std::vector<Tile>& tiles);
  /// A tile's or a screen's name, which must be new.
  std::string name(const JsonValue& value, const char* what);
  void claimName(const std::string& name, int line);
  /// Where a name was given, for errors about its tile.
  [[nodiscard]] int lineOf(const std::string& name) const;

 private:
  struct Placed {
    double left, top, right, bottom;  ///< millimetres, y down, before a free turn
  };
  void gridSize(const JsonValue& grid, const JsonValue& tilePx, const GridSpec& spec);
  void gridNames(const JsonValue& grid, GridSpec& spec);
  void gridMissing(const JsonValue& missing, GridSpec& spec);
  void gridGaps(const JsonValue& grid, GridSpec& spec);
  void settings(const JsonValue& value, TileOutput& output, TileEye& eye);
  void warp(const JsonValue& value, TileOutput& output);
  Placed place(const JsonValue& value, Tile& tile);
  void turnTo(const JsonValue& value, Tile& tile);
  Sides<double> sides(const JsonValue& value, const char* label, double most);
  std::array<double, 2> pair(const JsonValue& value, const char* label, NumberRange range);
  void pixels(const JsonValue& value, const char* label, int& width, int& height);

  JsonReader& json_;
  const std::string& source_;
  std::unordered_map<std::string, int> lines_;
};

}  // namespace tessera
