#include "client/overlay.h"

#include <algorithm>
#include <cstdio>

#include "client/text.h"

namespace tessera {

namespace {

constexpr Rgb8 kWhite = {255, 255, 255}, kName = {255, 220, 110};
constexpr int kLinePx = 10, kMarginPx = 4;
// At scale 1 text is readable on a picture of this height.
constexpr int kHeightOfScalePx = 480;

std::string decimal(double value, const char* unit) {
  char text[64];
  std::snprintf(text, sizeof text, "%.1f %s", value, unit);
  return text;
}

}  // namespace

void FrameRate::shown(std::int64_t ns) {
  shownNs_[count_++ % kFrames] = ns;
}

double FrameRate::framesPerS() const {
  if (count_ < 2) return 0;
  const std::size_t kept = std::min(count_, kFrames);
  const std::int64_t last = shownNs_[(count_ - 1) % kFrames], first = shownNs_[(count_ - kept) % kFrames];
  return last > first ? static_cast<double>(kept - 1) * 1e9 / static_cast<double>(last - first) : 0;
}

std::vector<std::string> overlayLines(const OverlayFacts& facts) {
  return {facts.tileName,
          decimal(facts.framesPerS, "frames/s"),
          std::to_string(facts.drawnLeaves) + " leaves drawn",
          std::to_string(facts.keptLeaves) + " leaves, " + std::to_string(facts.keptAssets) + " assets kept",
          decimal(static_cast<double>(facts.bytesReceived) / 1e6, "MB received"),
          "skew " + decimal(facts.skewUs / 1000.0, "ms")};
}

Picture overlayPicture(const std::vector<std::string>& lines, int heightPx) {
  const int scale = std::max(1, heightPx / kHeightOfScalePx);
  int widthPx = 0;
  for (const std::string& line : lines)
    widthPx = std::max(widthPx, textWidthPx(line, scale));
  Picture picture(widthPx + 2 * kMarginPx * scale,
                  (static_cast<int>(lines.size()) * kLinePx + 2 * kMarginPx) * scale);
  int yPx = kMarginPx * scale;
  for (const std::string& line : lines) {
    drawText(picture, kMarginPx * scale, yPx, line, yPx == kMarginPx * scale ? kName : kWhite, scale);
    yPx += kLinePx * scale;
  }
  return picture;
}

}  // namespace tessera
