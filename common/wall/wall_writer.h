#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/wall/wall.h"

namespace tessera {

/// The wall as a wall file that says everything: every tile by its place, every default. Reading it gives the
/// same frusta, but for the last digits; bezels over which the picture is pushed together are not told any
/// more.
[[nodiscard]] std::string writeWall(const Wall& wall);

/// What somebody asks for who wants a new wall file.
struct WallRequest {
  int columns = 1, rows = 1;
  int tileWidthPx = 1920, tileHeightPx = 1080;
  std::string name;
  std::optional<std::array<double, 2>> tileMm;  ///< visible area of a panel
  std::optional<double> bezelMm;
  bool compresses = false;
  std::optional<std::array<double, 2>> overlapPx;
  int rotationDeg = 0;
  double fovYDeg = 50;
};

/// A short wall file for people to go on from.
[[nodiscard]] std::string writeNewWall(const WallRequest& request);

/// "4x3" as two numbers; `what` names it in the error.
[[nodiscard]] Result<std::array<double, 2>> parsePair(std::string_view text, const std::string& what);
/// "12mm", "1.2cm", "0.012m" or "0.5in" in millimetres; a bare number is in `bareMm` millimetres.
[[nodiscard]] Result<double> parseLengthMm(std::string_view text, const std::string& what, double bareMm);

}  // namespace tessera
