#include "client/test_pattern.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <Eigen/LU>

#include "client/text.h"

namespace tessera {

namespace {

using Mat2 = Eigen::Matrix2d;

constexpr Rgb8 kGround = {20, 20, 24}, kThin = {78, 78, 86}, kBold = {190, 190, 190};
constexpr Rgb8 kDiagonal = {60, 150, 200}, kCircle = {230, 190, 60}, kWhite = {255, 255, 255},
               kBlack = {0, 0, 0};
constexpr double kThinPx = 1.5, kBoldPx = 2.5;
constexpr double kLinesOnShortSide = 20;

/// Metres on the screen for a step of a pixel to the right and for one down, by column.
Mat2 pixelSteps(const TilePlace& tile) {
  const double x = tile.widthPx / 2.0, y = tile.heightPx / 2.0;
  Mat2 steps;
  steps.col(0) = tile.onScreen(x + 0.5, y) - tile.onScreen(x - 0.5, y);
  steps.col(1) = tile.onScreen(x, y + 0.5) - tile.onScreen(x, y - 0.5);
  return steps;
}

void blend(Rgb8& pixel, const Rgb8& colour, double coverage) {
  for (std::size_t i = 0; i < 3; ++i)
    pixel[i] = static_cast<std::uint8_t>(std::lround(pixel[i] + coverage * (colour[i] - pixel[i])));
}

/// How much of a pixel a line covers whose middle is so far from the pixel's.
double coverage(double distancePx, double lineWidthPx) {
  return std::clamp(lineWidthPx / 2 + 0.5 - distancePx, 0.0, 1.0);
}

/// Draws what is placed on the screen into the pixels of one tile.
class ScreenPainter {
 public:
  explicit ScreenPainter(const TilePlace& tile)
      : tile_(tile),
        steps_(pixelSteps(tile)),
        spacingM_(gridSpacingM(tile.screenWidthM, tile.screenHeightM)),
        centreM_(tile.screenWidthM / 2, tile.screenHeightM / 2) {}

  void paint(Picture& picture) const {
    for (int y = 0; y < tile_.heightPx; ++y) {
      for (int x = 0; x < tile_.widthPx; ++x)
        paintPixel(tile_.onScreen(x + 0.5, y + 0.5), pixelAt(picture, x, y));
    }
  }

 private:
  void paintPixel(const Vec2& atM, Rgb8& pixel) const {
    grid(atM, 1, kThin, kThinPx, pixel);
    grid(atM, 5, kBold, kBoldPx, pixel);
    const Vec2 rising = Vec2(-tile_.screenHeightM, tile_.screenWidthM).normalized();
    const Vec2 fromCentre = atM - centreM_;
    line(fromCentre, rising, kDiagonal, pixel);
    line(fromCentre, Vec2(-rising.x(), rising.y()), kDiagonal, pixel);
    const double radius = fromCentre.norm(), step = std::min(tile_.screenWidthM, tile_.screenHeightM) / 4;
    const double nearest = std::max(1.0, std::round(radius / step)) * step;
    if (radius > 0) stroke(radius - nearest, fromCentre / radius, kCircle, kBoldPx, pixel);
  }

  /// The lines of which `every` spacings apart there is one.
  void grid(const Vec2& atM, int every, const Rgb8& colour, double lineWidthPx, Rgb8& pixel) const {
    const double spacing = every * spacingM_;
    for (const int axis : {0, 1}) {
      const double offset = atM[axis] - std::round(atM[axis] / spacing) * spacing;
      stroke(offset, Vec2::Unit(axis), colour, lineWidthPx, pixel);
    }
  }

  void line(const Vec2& fromLine, const Vec2& normal, const Rgb8& colour, Rgb8& pixel) const {
    stroke(fromLine.dot(normal), normal, colour, kThinPx, pixel);
  }

  /// `offsetM`: from the line's middle along its normal.
  void stroke(double offsetM, const Vec2& normal, const Rgb8& colour, double lineWidthPx, Rgb8& pixel) const {
    const double metresPerPixel = (steps_.transpose() * normal).norm();
    const double covered = coverage(std::abs(offsetM) / metresPerPixel, lineWidthPx);
    if (covered > 0) blend(pixel, colour, covered);
  }

  const TilePlace& tile_;
  const Mat2 steps_;
  const double spacingM_;
  const Vec2 centreM_;
};

/// White on the tile's outermost pixels, a black line inside of it.
void drawCornerMarks(Picture& picture) {
  const int width = picture.widthPx, height = picture.heightPx;
  const int across = std::max(width / 8, 4), down = std::max(height / 8, 4);
  for (const int inset : {1, 0}) {
    const Rgb8& colour = inset == 0 ? kWhite : kBlack;
    const int right = width - 1 - inset, bottom = height - 1 - inset;
    for (const int x : {inset, width - inset - across}) {
      fillBox(picture, x, inset, across, 1, colour);
      fillBox(picture, x, bottom, across, 1, colour);
    }
    for (const int y : {inset, height - inset - down}) {
      fillBox(picture, inset, y, 1, down, colour);
      fillBox(picture, right, y, 1, down, colour);
    }
  }
}

void drawBarsAndRamp(Picture& picture) {
  const int left = picture.widthPx * 3 / 10, width = picture.widthPx * 4 / 10;
  const int top = picture.heightPx * 8 / 10, height = std::max(picture.heightPx / 16, 1);
  for (int bar = 0; bar < 8; ++bar) {  // white, yellow, cyan, green, magenta, red, blue, black
    const auto channel = [&](int bit) { return static_cast<std::uint8_t>((bar & bit) == 0 ? 255 : 0); };
    const int from = left + width * bar / 8, to = left + width * (bar + 1) / 8;
    fillBox(picture, from, top, to - from, height, {channel(2), channel(4), channel(1)});
  }
  for (int x = 0; x < width; ++x) {
    const auto grey = static_cast<std::uint8_t>(width > 1 ? x * 255 / (width - 1) : 0);
    fillBox(picture, left + x, top + height, 1, height, {grey, grey, grey});
  }
}

/// A line of text with its middle at (xPx, yPx).
void drawCentred(Picture& picture, int xPx, int yPx, const std::string& text, const Rgb8& colour, int scale) {
  drawText(picture, xPx - textWidthPx(text, scale) / 2, yPx - textHeightPx(scale) / 2, text, colour, scale);
}

std::string resolutionOf(const TilePlace& tile) {
  return std::to_string(tile.widthPx) + " x " + std::to_string(tile.heightPx);
}

std::string sizeOf(const TilePlace& tile) {
  char text[64];
  std::snprintf(text, sizeof text, "%.3f x %.3f m", (tile.cornersM[1] - tile.cornersM[0]).norm(),
                (tile.cornersM[3] - tile.cornersM[0]).norm());
  return text;
}

/// A colour by the name: names that are alike get colours far apart.
Rgb8 colourOf(const std::string& name) {
  std::uint32_t hash = 2166136261U;  // FNV-1a
  for (const char c : name)
    hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  constexpr double kGoldenAngle = 0.6180339887498949;
  const double hue = std::fmod(hash % 4096 * kGoldenAngle, 1.0) * 2 * std::numbers::pi;
  Rgb8 colour = {};
  for (std::size_t i = 0; i < 3; ++i) {
    const double wave = std::cos(hue - static_cast<double>(i) * 2 * std::numbers::pi / 3);
    colour[i] = static_cast<std::uint8_t>(std::lround(100 + 70 * wave));
  }
  return colour;
}

/// An arrow of the given length around (xPx, yPx) that points to the screen's top.
void drawUpArrow(Picture& picture, const TilePlace& tile, double xPx, double yPx, double lengthPx) {
  const Vec2 up = (pixelSteps(tile).inverse() * Vec2(0, 1)).normalized();
  const Vec2 side(-up.y(), up.x());
  const int reach = static_cast<int>(std::ceil(lengthPx));
  const int centreX = static_cast<int>(xPx), centreY = static_cast<int>(yPx);
  for (int y = std::max(centreY - reach, 0); y < std::min(centreY + reach, picture.heightPx); ++y) {
    for (int x = std::max(centreX - reach, 0); x < std::min(centreX + reach, picture.widthPx); ++x) {
      const Vec2 from(x + 0.5 - xPx, y + 0.5 - yPx);
      const double along = from.dot(up), across = std::abs(from.dot(side));
      const double toTip = lengthPx / 2 - along;
      const double head = std::min(0.5 + (toTip * 0.8 - across) / std::hypot(1, 0.8), along + 0.5);
      const double shaft = std::min({lengthPx / 8 - across + 0.5, along + lengthPx / 2 + 0.5, 0.5 - along});
      const double covered = std::clamp(std::max(head, shaft), 0.0, 1.0);
      if (covered > 0) blend(pixelAt(picture, x, y), kWhite, covered);
    }
  }
}

}  // namespace

Vec2 TilePlace::onScreen(double xPx, double yPx) const {
  const double u = xPx / widthPx, v = 1 - yPx / heightPx;
  return (1 - v) * ((1 - u) * cornersM[0] + u * cornersM[1]) + v * ((1 - u) * cornersM[3] + u * cornersM[2]);
}

double gridSpacingM(double screenWidthM, double screenHeightM) {
  const double wanted = std::min(screenWidthM, screenHeightM) / kLinesOnShortSide;
  const double power = std::pow(10, std::floor(std::log10(wanted)));
  const double factor = wanted / power;
  return power * (factor < 1.5 ? 1 : factor < 3.5 ? 2 : factor < 7.5 ? 5 : 10);
}

Picture alignmentPattern(const TilePlace& tile) {
  Picture picture(tile.widthPx, tile.heightPx);
  fillBox(picture, 0, 0, tile.widthPx, tile.heightPx, kGround);
  ScreenPainter(tile).paint(picture);
  drawBarsAndRamp(picture);
  const std::string name = tile.tileName + "  " + resolutionOf(tile);
  const int scale = largestScale(name, tile.widthPx / 2, tile.heightPx / 16);
  const int width = textWidthPx(name, scale) + 4 * scale, height = textHeightPx(scale) + 4 * scale;
  const int middleX = tile.widthPx / 2, middleY = tile.heightPx / 8;
  fillBox(picture, middleX - width / 2, middleY - height / 2, width, height, kGround);
  drawCentred(picture, middleX, middleY, name, kWhite, scale);
  drawCornerMarks(picture);
  return picture;
}

Picture identifyPattern(const TilePlace& tile) {
  Picture picture(tile.widthPx, tile.heightPx);
  fillBox(picture, 0, 0, tile.widthPx, tile.heightPx, colourOf(tile.tileName));
  const int width = tile.widthPx, height = tile.heightPx;
  drawUpArrow(picture, tile, width / 2.0, height * 0.17, std::min(width, height) * 0.26);
  drawCentred(picture, width / 2, height / 2, tile.tileName, kWhite,
              largestScale(tile.tileName, width * 9 / 10, height * 3 / 10));
  const std::string lines[] = {tile.screenName.empty() ? "" : "screen " + tile.screenName, resolutionOf(tile),
                               sizeOf(tile)};
  int scale = height;
  for (const std::string& line : lines)
    scale = std::min(scale, largestScale(line, width * 6 / 10, height / 16));
  int y = height * 3 / 4;
  for (const std::string& line : lines) {
    drawCentred(picture, width / 2, y, line, kWhite, scale);
    y += textHeightPx(scale) * 3 / 2;
  }
  drawCornerMarks(picture);
  return picture;
}

}  // namespace tessera
