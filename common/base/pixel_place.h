#pragma once

#include <optional>
#include <string>

#include "common/base/result.h"

namespace tessera {

struct PixelSize {
  int widthPx = 0, heightPx = 0;
  friend bool operator==(const PixelSize&, const PixelSize&) = default;
};

/// "1920x1080".
[[nodiscard]] std::string textOf(PixelSize size);

/// A rectangle on a desktop, in its pixels from the upper left.
struct PixelPlace {
  int xPx = 0, yPx = 0;
  std::optional<PixelSize> size = {};  ///< absent: that of what is shown there
};

/// "X,Y" or "X,Y,WxH": X and Y from -65536 to 65536, W and H from 1 to 16384. An error names `flag`.
[[nodiscard]] Result<PixelPlace> parsePixelPlace(const std::string& flag, const std::string& text);

}  // namespace tessera
