#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "common/image/picture.h"

namespace tessera {

// Text in pictures with a font of our own: ASCII, 5 x 7 pixels, in whole multiples. Any other character is
// drawn as a question mark. Positions are in pixels from the picture's upper left corner; what lies outside
// of the picture is cut off.

using Rgb8 = std::array<std::uint8_t, 3>;

/// From the left edge of a character to that of the next, at scale 1.
inline constexpr int kCharacterWidthPx = 6;

/// The pixel at (x, y), which must lie inside.
[[nodiscard]] inline Rgb8& pixelAt(Picture& picture, int x, int y) {
  static_assert(sizeof(Rgb8) == 3);
  const std::size_t index =
      static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.widthPx) + static_cast<std::size_t>(x);
  return reinterpret_cast<Rgb8*>(picture.rgb.data())[index];
}

void fillBox(Picture& picture, int xPx, int yPx, int widthPx, int heightPx, const Rgb8& colour);

[[nodiscard]] int textWidthPx(std::string_view text, int scale);
[[nodiscard]] int textHeightPx(int scale);

/// The largest scale at which the text fits into a box; 1 where none does.
[[nodiscard]] int largestScale(std::string_view text, int widthPx, int heightPx);

/// Draws one line with its upper left corner at (xPx, yPx).
void drawText(Picture& picture, int xPx, int yPx, std::string_view text, const Rgb8& colour, int scale);

}  // namespace tessera
