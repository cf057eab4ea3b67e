#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/wall/wall.h"

namespace tessera {

/// Limits of a wall file; configs/wall.schema.json states the same.
inline constexpr std::uintmax_t kMaxWallFileBytes = std::uintmax_t{1} << 20;
inline constexpr int kMaxGridSide = 256;  ///< columns, rows
inline constexpr int kMaxTiles = 4096;    ///< of a wall
inline constexpr int kMaxScreens = 256;
inline constexpr double kMaxRoomM = 1e6;  ///< any coordinate in the room
inline constexpr int kMaxTilePx = 16384;  ///< each side of a tile
inline constexpr int kMaxWallPx = 65535;  ///< each side of the whole wall
inline constexpr int kMaxTileNameBytes = 64;
inline constexpr int kMaxWallNameBytes = 256;
inline constexpr double kDefaultFovYDeg = 50;

/// Reads and validates a wall file: JSON with comments, described by configs/wall.schema.json. The error
/// names the file and the line. What is allowed but unwise is in Wall::warnings. Safe on hostile files.
[[nodiscard]] Result<Wall> readWallFile(const std::filesystem::path& path);

/// The same for text already in memory; `sourceName` stands for the file in messages.
[[nodiscard]] Result<Wall> parseWall(std::string_view text, const std::string& sourceName);

}  // namespace tessera
