#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/result.h"
#include "common/geometry/vec.h"
#include "common/wall/import/warning_list.h"

namespace tessera {

/// What a foreign format said about a wall, as plain values, and the wall file that says the same.
namespace walltext {

enum class Eye : std::uint8_t { Both, Left, Right };
enum class Stereo : std::uint8_t { None, SideBySide, TopBottom, Tiles, QuadBuffer };

struct Warp {
  std::string mpcdiFile;
  std::string region;
};

struct Settings {
  std::string host;  ///< may be empty
  std::optional<std::array<int, 2>> windowPx;
  Eye eye = Eye::Both;
  std::optional<Warp> warp;
};

struct Tile {
  std::string name;
  std::array<int, 2> px = {0, 0};
  std::array<double, 2> atMm = {0, 0};  ///< upper left corner from the screen's upper left corner, y down
  std::array<double, 2> sizeMm = {0, 0};
  Settings settings;
};

/// Metres in the room: x right, y up, z towards the viewer.
struct Corners {
  Vec3 lowerLeft, lowerRight, upperLeft;
};

struct Screen {
  std::string name;
  std::optional<Corners> corners;               ///< only the single screen of a wall may lack them
  std::optional<std::array<double, 2>> sizeMm;  ///< of a screen without corners
  std::vector<Tile> tiles;
};

/// One planar wall of equal tiles. A tile's name is r<row>c<column>, the upper left r0c0.
struct Grid {
  int columns = 1, rows = 1;
  std::array<int, 2> tilePx = {0, 0};
  std::array<double, 2> tileMm = {0, 0};
  std::array<double, 2> bezelMm = {0, 0};  ///< of one panel on each side
  std::array<int, 2> overlapPx = {0, 0};
  std::vector<std::string> missing;
  std::vector<std::pair<std::string, Settings>> settings;
};

struct Observer {
  Vec3 eyeM = Vec3::Zero();
  Stereo stereo = Stereo::None;
  double separationMm = 65;
};

/// Either `grid` or `screens`.
struct Wall {
  std::string name;
  std::string origin;  ///< one line for the comment on top
  std::optional<Grid> grid;
  std::vector<Screen> screens;
  std::optional<Observer> observer;
};

}  // namespace walltext

/// With stereo by tiles every tile shows one eye: those that show both become the left eye's.
void settleEyes(walltext::Wall& wall, WarningList& warnings);

/// The wall file of `wall`. Fails where the wall is beyond the limits of wall files, is no rectangle or has
/// no tile; `sourceName` stands for the file it came from in the error.
[[nodiscard]] Result<std::string> wallText(const walltext::Wall& wall, const std::string& sourceName);

/// Makes names for screens and tiles out of foreign ones: letters, digits and _.- only, at most 64 bytes,
/// each given once.
class NameMaker {
 public:
  [[nodiscard]] std::string make(std::string_view wanted);

 private:
  std::set<std::string> taken_;
};

}  // namespace tessera
