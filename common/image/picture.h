#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"

namespace tessera {

/// An 8-bit RGB raster; rows from the top, no padding.
struct Picture {
  int widthPx = 0, heightPx = 0;
  std::vector<std::uint8_t> rgb;  ///< widthPx * heightPx * 3

  Picture() = default;
  Picture(int width, int height)
      : widthPx(width),
        heightPx(height),
        rgb(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3) {}

  /// Copies `part` (width x height x 3 bytes, rows from the top) with its upper left corner at (x, y). The
  /// part must lie inside.
  void paste(int x, int y, int width, int height, std::span<const std::uint8_t> part);
};

/// Compresses lightly: pictures of a run are many, and speed matters more than size.
[[nodiscard]] Result<std::string> encodePng(const Picture& picture);
/// Reads an 8-bit PNG of any colour type as RGB; sides of at most 65,536 pixels.
[[nodiscard]] Result<Picture> readPng(const std::filesystem::path& path);

/// How two pictures of one size differ, by the largest difference of a pixel's three channels.
struct PictureDifference {
  std::size_t pixels = 0;         ///< in the picture
  std::size_t differing = 0;      ///< that differ at all
  std::size_t differingMuch = 0;  ///< that differ by more than 8 of 255
  int largest = 0;
};
[[nodiscard]] Result<PictureDifference> compare(const Picture& a, const Picture& b);

}  // namespace tessera
