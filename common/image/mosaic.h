#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/image/picture.h"

namespace tessera {

/// Where a part lies in a larger picture, in its pixels from its upper left corner, y down: the corner (0, 0)
/// of the part's first pixel, and a step along its rows and down its columns for each of its pixels.
struct MosaicPlace {
  double x = 0, y = 0;
  double acrossX = 1, acrossY = 0;
  double downX = 0, downY = 1;
};

/// Puts pictures of tiles together into one, turned and scaled as they are mounted. Parts whose pixels lie on
/// the picture's are copied exactly; others are interpolated between the nearest four pixels.
class Mosaic {
 public:
  Mosaic() = default;
  /// Black. `gamma` > 0: where parts overlap their light (value ^ gamma) adds, as that of projectors; 0: the
  /// last one hides the others.
  Mosaic(int widthPx, int heightPx, double gamma);

  /// `part`: width x height x 3 bytes, rows from the top. What lies outside the picture is left out.
  void add(const MosaicPlace& place, int width, int height, std::span<const std::uint8_t> part);
  [[nodiscard]] Picture finish();

 private:
  double gamma_ = 0;
  Picture picture_;
  std::vector<float> light_;  ///< as many as the picture's bytes, where light adds
  std::vector<float> lightOf_;
};

}  // namespace tessera
