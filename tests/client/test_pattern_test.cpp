#include "client/test_pattern.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "client/text.h"

namespace tessera::test {
namespace {

int brightnessAt(const Picture& picture, int x, int y) {
  const auto at = (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.widthPx) +
                   static_cast<std::size_t>(x)) *
                  3;
  return picture.rgb[at] + picture.rgb[at + 1] + picture.rgb[at + 2];
}

Rgb8 colourAt(const Picture& picture, int x, int y) {
  const auto at = (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.widthPx) +
                   static_cast<std::size_t>(x)) *
                  3;
  return {picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]};
}

/// A screen of 4 x 2.2 m with two tiles of different pixels side by side, a bezel of 30 mm between them.
TilePlace place(const std::string& name, int widthPx, int heightPx, const Vec2& lowerLeft, const Vec2& size) {
  return {.tileName = name,
          .screenName = "front",
          .widthPx = widthPx,
          .heightPx = heightPx,
          .screenWidthM = 4,
          .screenHeightM = 2.2,
          .cornersM = {lowerLeft, lowerLeft + Vec2(size.x(), 0), lowerLeft + size,
                       lowerLeft + Vec2(0, size.y())}};
}

TilePlace leftTile() {
  return place("left", 960, 540, {0.1, 0.2}, {1.6, 0.9});
}

TilePlace rightTile() {
  return place("right", 640, 360, {1.73, 0.2}, {1.6, 0.9});
}

/// As leftTile() with its panel turned clockwise: the picture's left edge is the screen's upper one.
TilePlace turnedTile() {
  TilePlace tile = place("turned", 960, 540, {2.5, 0.3}, {0.9, 1.6});
  const auto c = tile.cornersM;  // lower left, lower right, upper right, upper left on the screen
  tile.cornersM = {c[3], c[0], c[1], c[2]};
  return tile;
}

/// Where along a straight run of pixels the picture is brighter than the ground, as the middles of what is
/// bright. In pixels from the run's start; `count` pixels by (dx, dy) from (x, y).
std::vector<double> linesAlong(const Picture& picture, int x, int y, int dx, int dy, int count) {
  std::vector<double> middles;
  double weight = 0, moment = 0;
  constexpr int kGround = 20 + 20 + 24;
  for (int i = 0; i < count; ++i) {
    const double above = brightnessAt(picture, x + i * dx, y + i * dy) - kGround;
    if (above > 0) {
      weight += above;
      moment += above * (i + 0.5);
    } else if (weight > 0) {
      middles.push_back(moment / weight);
      weight = moment = 0;
    }
  }
  return middles;
}

/// Every whole multiple of the spacing that the run crosses must have its line, at most a pixel away.
void expectGridAlong(const TilePlace& tile, const Picture& picture, int x, int y, int dx, int dy, int count) {
  const double spacing = gridSpacingM(tile.screenWidthM, tile.screenHeightM);
  const std::vector<double> lines = linesAlong(picture, x, y, dx, dy, count);
  const Vec2 from = tile.onScreen(x, y + 0.5 * std::abs(dx)),
             to = tile.onScreen(x + dx * count, y + dy * count);
  const int axis = std::abs(to.x() - from.x()) > std::abs(to.y() - from.y()) ? 0 : 1;
  const double metresPerPixel = (to[axis] - from[axis]) / count;
  int found = 0;
  const double low = std::min(from[axis], to[axis]), high = std::max(from[axis], to[axis]);
  for (double line = std::ceil(low / spacing) * spacing; line < high; line += spacing) {
    const double at = (line - from[axis]) / metresPerPixel;
    if (at < 3 || at > count - 3) continue;
    const bool isThere =
        std::any_of(lines.begin(), lines.end(), [&](double middle) { return std::abs(middle - at) < 1; });
    EXPECT_TRUE(isThere) << tile.tileName << ": no line at " << line << " m, pixel " << at;
    ++found;
  }
  EXPECT_GE(found, 6);
}

TEST(Pattern, SpacingIsRound) {
  EXPECT_DOUBLE_EQ(gridSpacingM(4, 2.2), 0.1);
  EXPECT_DOUBLE_EQ(gridSpacingM(1, 100), 0.05);
  EXPECT_DOUBLE_EQ(gridSpacingM(0.5, 0.4), 0.02);
  EXPECT_DOUBLE_EQ(gridSpacingM(3000, 3000), 200);
}

TEST(Pattern, PlacesPixelsInMetres) {
  const TilePlace left = leftTile();
  EXPECT_TRUE(left.onScreen(0, 540).isApprox(Vec2(0.1, 0.2)));
  EXPECT_TRUE(left.onScreen(960, 0).isApprox(Vec2(1.7, 1.1)));
  const TilePlace turned = turnedTile();
  EXPECT_TRUE(turned.onScreen(0, 540).isApprox(turned.cornersM[0]));
  EXPECT_TRUE(turned.onScreen(960, 540).isApprox(turned.cornersM[1]));
}

TEST(Pattern, LinesLieAtTheSameMetresOnAllTiles) {
  for (const TilePlace& tile : {leftTile(), rightTile(), turnedTile()}) {
    const Picture picture = alignmentPattern(tile);
    // Rows and columns without text and bars, a little beside lines that run along them.
    int row = tile.heightPx * 3 / 10, column = tile.widthPx / 6;
    const double spacing = gridSpacingM(tile.screenWidthM, tile.screenHeightM);
    const auto isBesideLines = [&](const Vec2& at, int axis) {
      const double phase = std::abs(std::remainder(at[axis], spacing));
      return phase > 0.3 * spacing;
    };
    const int across = std::abs(tile.cornersM[1].x() - tile.cornersM[0].x()) > 0.01 ? 1 : 0;
    while (!isBesideLines(tile.onScreen(tile.widthPx / 2.0, row + 0.5), across))
      ++row;
    while (!isBesideLines(tile.onScreen(column + 0.5, tile.heightPx / 2.0), 1 - across))
      ++column;
    expectGridAlong(tile, picture, 0, row, 1, 0, tile.widthPx);
    expectGridAlong(tile, picture, column, 0, 0, 1, tile.heightPx);
  }
}

// A pixel on a circle is yellowish on every tile that the circle crosses.
TEST(Pattern, CirclesGoOnAcrossTheBezel) {
  int checked = 0;
  for (const TilePlace& tile : {leftTile(), rightTile(), turnedTile()}) {
    const Picture picture = alignmentPattern(tile);
    const Vec2 right = (tile.cornersM[1] - tile.cornersM[0]) / tile.widthPx;
    const Vec2 up = (tile.cornersM[3] - tile.cornersM[0]) / tile.heightPx;
    for (const double radius : {0.55, 1.1}) {
      for (double angle = 0; angle < 6.28; angle += 0.01) {
        const Vec2 at = Vec2(2, 1.1) + radius * Vec2(std::cos(angle), std::sin(angle)) - tile.cornersM[0];
        const int x = static_cast<int>(std::floor(at.dot(right) / right.squaredNorm()));
        const int y = tile.heightPx - 1 - static_cast<int>(std::floor(at.dot(up) / up.squaredNorm()));
        const bool isFree =
            x > 2 && x < tile.widthPx - 3 && y > tile.heightPx / 5 && y < tile.heightPx * 3 / 4;
        if (!isFree) continue;
        const Rgb8 colour = colourAt(picture, x, y);
        EXPECT_GT(colour[0], colour[2] + 60) << tile.tileName << " " << x << " " << y;
        ++checked;
      }
    }
  }
  EXPECT_GT(checked, 200);
}

TEST(Pattern, CornersAreMarkedOnTheOutermostPixels) {
  for (const TilePlace& tile : {leftTile(), turnedTile()}) {
    for (const Picture& picture : {alignmentPattern(tile), identifyPattern(tile)}) {
      const int right = tile.widthPx - 1, bottom = tile.heightPx - 1;
      for (const int x : {0, right}) {
        for (const int y : {0, bottom}) {
          EXPECT_EQ(brightnessAt(picture, x, y), 3 * 255);
          const int insideX = x == 0 ? 1 : right - 1, insideY = y == 0 ? 1 : bottom - 1;
          EXPECT_EQ(brightnessAt(picture, insideX, y), 3 * 255);
          EXPECT_EQ(brightnessAt(picture, x, insideY), 3 * 255);
          EXPECT_EQ(brightnessAt(picture, insideX, insideY), 0);
        }
      }
    }
  }
}

TEST(Pattern, HasAllColoursAndAllGreys) {
  const Picture picture = alignmentPattern(leftTile());
  std::set<Rgb8> colours;
  for (int y = 0; y < picture.heightPx; ++y) {
    for (int x = 0; x < picture.widthPx; ++x)
      colours.insert(colourAt(picture, x, y));
  }
  for (const int red : {0, 255}) {
    for (const int green : {0, 255}) {
      for (const int blue : {0, 255}) {
        const Rgb8 colour = {static_cast<std::uint8_t>(red), static_cast<std::uint8_t>(green),
                             static_cast<std::uint8_t>(blue)};
        EXPECT_TRUE(colours.contains(colour)) << red << " " << green << " " << blue;
      }
    }
  }
  for (int grey = 0; grey < 256; ++grey) {
    const auto value = static_cast<std::uint8_t>(grey);
    EXPECT_TRUE(colours.contains(Rgb8{value, value, value})) << grey;
  }
}

TEST(Pattern, TellsTilesApart) {
  TilePlace a = leftTile(), b = leftTile();
  b.tileName = "lefs";
  EXPECT_NE(colourAt(identifyPattern(a), 20, 20), colourAt(identifyPattern(b), 20, 20));
  EXPECT_NE(alignmentPattern(a).rgb, alignmentPattern(b).rgb);
  EXPECT_EQ(identifyPattern(a).rgb, identifyPattern(a).rgb);
}

// Its head is wider than its shaft.
TEST(Pattern, TheArrowPointsToTheScreensTop) {
  const auto widthsOf = [](const TilePlace& tile, const Vec2& direction) {
    // White pixels in the half before and behind the arrow's middle.
    const Picture picture = identifyPattern(tile);
    const Vec2 middle(tile.widthPx / 2.0, tile.heightPx * 0.17);
    const int reach = tile.heightPx / 6;
    std::array<int, 2> counts = {0, 0};
    for (int y = static_cast<int>(middle.y()) - reach + 2; y < static_cast<int>(middle.y()) + reach - 2;
         ++y) {
      for (int x = static_cast<int>(middle.x()) - reach; x < static_cast<int>(middle.x()) + reach; ++x) {
        if (x < 0 || y < 2 || brightnessAt(picture, x, y) < 3 * 250) continue;
        ++counts[(Vec2(x + 0.5, y + 0.5) - middle).dot(direction) > 0 ? 0 : 1];
      }
    }
    return counts;
  };
  const auto upright = widthsOf(leftTile(), Vec2(0, -1));
  EXPECT_GT(upright[0], 1.3 * upright[1]);
  EXPECT_GT(upright[1], 100);
  // The screen's top is where the turned picture's left edge is.
  const auto turned = widthsOf(turnedTile(), Vec2(-1, 0));
  EXPECT_GT(turned[0], 1.3 * turned[1]);
}

TEST(Pattern, TinyAndOddTilesDoNoHarm) {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 3}, {7, 5}, {1, 200}, {300, 2}}) {
    TilePlace tile = leftTile();
    tile.widthPx = width;
    tile.heightPx = height;
    tile.tileName = std::string(64, 'W');
    EXPECT_EQ(alignmentPattern(tile).rgb.size(), static_cast<std::size_t>(width * height * 3));
    EXPECT_EQ(identifyPattern(tile).rgb.size(), static_cast<std::size_t>(width * height * 3));
  }
}

std::vector<std::string> rowsOf(const Picture& picture) {
  std::vector<std::string> rows;
  for (int y = 0; y < picture.heightPx; ++y) {
    std::string& row = rows.emplace_back();
    for (int x = 0; x < picture.widthPx; ++x)
      row += brightnessAt(picture, x, y) > 0 ? '#' : '.';
  }
  return rows;
}

TEST(Text, IsDrawnPixelByPixel) {
  Picture picture(11, 7);
  drawText(picture, 0, 0, "L7", {255, 255, 255}, 1);
  EXPECT_EQ(rowsOf(picture),
            (std::vector<std::string>{"#.....#####", "#.........#", "#........#.", "#.......#..",
                                      "#......#...", "#......#...", "#####..#..."}));
}

TEST(Text, GrowsInWholeSteps) {
  Picture once(5, 7), twice(10, 14);
  drawText(once, 0, 0, "R", {255, 255, 255}, 1);
  drawText(twice, 0, 0, "R", {255, 255, 255}, 2);
  for (int y = 0; y < 14; ++y) {
    for (int x = 0; x < 10; ++x)
      EXPECT_EQ(brightnessAt(twice, x, y), brightnessAt(once, x / 2, y / 2));
  }
}

TEST(Text, EveryCharacterHasItsOwnLooks) {
  std::set<std::vector<std::string>> looks;
  for (char c = ' '; c <= '~'; ++c) {
    Picture picture(5, 7);
    drawText(picture, 0, 0, std::string(1, c), {255, 255, 255}, 1);
    looks.insert(rowsOf(picture));
  }
  EXPECT_EQ(looks.size(), 95U);
}

TEST(Text, OtherCharactersAreQuestionMarksAndCountOnce) {
  EXPECT_EQ(textWidthPx("a\xe2\x98\x83z", 1), textWidthPx("abc", 1));
  EXPECT_EQ(textWidthPx("", 3), 0);
  Picture snow(17, 7), mark(17, 7);
  drawText(snow, 0, 0, "a\xe2\x98\x83z", {255, 255, 255}, 1);
  drawText(mark, 0, 0, "a?z", {255, 255, 255}, 1);
  EXPECT_EQ(rowsOf(snow), rowsOf(mark));
}

TEST(Text, IsCutAtThePicturesEdges) {
  Picture picture(6, 6);
  drawText(picture, -7, -3, "WWW", {255, 255, 255}, 3);
  drawText(picture, 100, 100, "WWW", {255, 255, 255}, 3);
  EXPECT_GT(brightnessAt(picture, 0, 0) + brightnessAt(picture, 5, 5), 0);
}

TEST(Text, TheLargestScaleFits) {
  const int scale = largestScale("r0c1", 200, 40);
  EXPECT_EQ(scale, 5);
  EXPECT_LE(textWidthPx("r0c1", scale), 200);
  EXPECT_LE(textHeightPx(scale), 40);
  EXPECT_EQ(largestScale("a long name", 3, 3), 1);
}

}  // namespace
}  // namespace tessera::test
