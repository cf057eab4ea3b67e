#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/image/picture.h"

namespace tessera {

/// What the statistics in the corner of a tile say.
struct OverlayFacts {
  std::string tileName = {};
  double framesPerS = 0;
  std::uint64_t drawnLeaves = 0, bytesReceived = 0;
  std::size_t keptLeaves = 0, keptAssets = 0;  ///< in this tile's memory
  std::uint32_t skewUs = 0;                    ///< between the wall's tiles at the last swap
};

/// Frames in a second, over the last ones.
class FrameRate {
 public:
  /// `ns`: monotonic time at which a frame was shown, never less than that before.
  void shown(std::int64_t ns);
  /// 0 until there are two frames.
  [[nodiscard]] double framesPerS() const;

 private:
  static constexpr std::size_t kFrames = 64;
  std::array<std::int64_t, kFrames> shownNs_ = {};
  std::size_t count_ = 0;
};

/// The statistics as lines of text.
[[nodiscard]] std::vector<std::string> overlayLines(const OverlayFacts& facts);

/// Lines of text on black, to be laid translucently over a picture that is `heightPx` high.
[[nodiscard]] Picture overlayPicture(const std::vector<std::string>& lines, int heightPx);

}  // namespace tessera
