// Both eyes on one tile, and test patterns as a tile shows them.
#include <gtest/gtest.h>

#include "client/test_pattern.h"
#include "tests/client/osmesa_tile.h"

namespace tessera::test {
namespace {

using proto::StereoLayout;

constexpr int kWidthPx = 240, kHeightPx = 180;
constexpr double kLeftX = -0.3, kRightX = 0.4;

proto::Frame stereoFrame(StereoLayout layout) {
  proto::Frame frame = testFrame(kLeftX);
  const proto::Frame right = testFrame(kRightX);
  frame.rightEye = proto::RightEye{right.eye, right.corners};
  frame.stereo = layout;
  return frame;
}

Picture part(const Picture& from, int x, int y, int width, int height) {
  Picture out(width, height);
  for (int row = 0; row < height; ++row) {
    for (int i = 0; i < width * 3; ++i) {
      out.rgb[static_cast<std::size_t>(row * width * 3 + i)] =
          from.rgb[static_cast<std::size_t>(((y + row) * from.widthPx + x) * 3 + i)];
    }
  }
  return out;
}

/// That of the stitched wall: single pixels on edges may differ.
void expectSame(const Picture& a, const Picture& b) {
  const auto difference = compare(a, b);
  ASSERT_TRUE(difference.ok()) << difference.error().text();
  EXPECT_LE(difference->differing, difference->pixels / 1000);
  EXPECT_LE(difference->differingMuch, 10U);
}

TEST(Stereo, HalvesAreTheEyesPicturesSqueezed) {
  const Picture sides = drawn(kWidthPx, kHeightPx, {}, stereoFrame(StereoLayout::SideBySide));
  const Picture left = drawn(kWidthPx / 2, kHeightPx, {}, testFrame(kLeftX));
  const Picture right = drawn(kWidthPx / 2, kHeightPx, {}, testFrame(kRightX));
  EXPECT_GT(compare(left, right)->differingMuch, 1000U) << "the eyes see different pictures";
  expectSame(part(sides, 0, 0, kWidthPx / 2, kHeightPx), left);
  expectSame(part(sides, kWidthPx / 2, 0, kWidthPx / 2, kHeightPx), right);

  const Picture stacked = drawn(kWidthPx, kHeightPx, {}, stereoFrame(StereoLayout::TopBottom));
  expectSame(part(stacked, 0, 0, kWidthPx, kHeightPx / 2),
             drawn(kWidthPx, kHeightPx / 2, {}, testFrame(kLeftX)));
  expectSame(part(stacked, 0, kHeightPx / 2, kWidthPx, kHeightPx / 2),
             drawn(kWidthPx, kHeightPx / 2, {}, testFrame(kRightX)));
}

// The eyes of a tile that is a part of a wall are drawn with the wall's projection, squeezed.
TEST(Stereo, HalvesOfAPartOfAWall) {
  for (const int fromPx : {100, 101}) {
    const auto partOf = [&](int scale) {
      proto::Welcome welcome = welcomeOf(kWidthPx / scale, kHeightPx);
      welcome.xPx = fromPx / scale;
      welcome.yPx = 60;
      welcome.wallWidthPx = 480 / scale;
      welcome.wallHeightPx = 300;
      return welcome;
    };
    OsMesaTile both(partOf(1)), half(partOf(2));
    const Picture sides = both.draw(stereoFrame(StereoLayout::SideBySide));
    expectSame(part(sides, 0, 0, kWidthPx / 2, kHeightPx), half.draw(testFrame(kLeftX)));
    expectSame(part(sides, kWidthPx / 2, 0, kWidthPx / 2, kHeightPx), half.draw(testFrame(kRightX)));
  }
}

TEST(Stereo, FrameAfterFrameAndBackToOneEye) {
  OsMesaTile tile(kWidthPx, kHeightPx);
  const Picture mono = tile.draw(testFrame());
  const Picture sides = tile.draw(stereoFrame(StereoLayout::SideBySide));
  EXPECT_NE(mono.rgb, sides.rgb);
  EXPECT_EQ(tile.draw(stereoFrame(StereoLayout::SideBySide)).rgb, sides.rgb);
  const Picture stacked = tile.draw(stereoFrame(StereoLayout::TopBottom));
  EXPECT_EQ(tile.draw(testFrame()).rgb, mono.rgb);
  EXPECT_EQ(tile.draw(stereoFrame(StereoLayout::SideBySide)).rgb, sides.rgb);
  EXPECT_EQ(tile.draw(stereoFrame(StereoLayout::TopBottom)).rgb, stacked.rgb);
}

TEST(Stereo, OddSizesAreCoveredWhole) {
  OsMesaTile tile(241, 181);
  proto::Frame frame = stereoFrame(StereoLayout::SideBySide);
  (void)tile.draw(testFrame());
  for (const StereoLayout layout : {StereoLayout::SideBySide, StereoLayout::TopBottom}) {
    frame.stereo = layout;
    const Picture picture = tile.draw(frame);
    OsMesaTile fresh(241, 181);
    EXPECT_EQ(fresh.draw(frame).rgb, picture.rgb);
  }
}

// The correction is for a whole picture, of which each half is one.
TEST(Stereo, EachHalfIsCorrectedAsAWhole) {
  const proto::TileSetup setup = {.blendPx = {60, 0, 0, 40}};
  const Picture sides = drawn(kWidthPx, kHeightPx, setup, stereoFrame(StereoLayout::SideBySide));
  const proto::TileSetup narrow = {.blendPx = {30, 0, 0, 40}};
  expectSame(part(sides, 0, 0, kWidthPx / 2, kHeightPx),
             drawn(kWidthPx / 2, kHeightPx, narrow, testFrame(kLeftX)));
  expectSame(part(sides, kWidthPx / 2, 0, kWidthPx / 2, kHeightPx),
             drawn(kWidthPx / 2, kHeightPx, narrow, testFrame(kRightX)));
}

TEST(Stereo, OverlayIsInBothHalves) {
  proto::Frame frame = stereoFrame(StereoLayout::SideBySide);
  OsMesaTile tile(kWidthPx * 2, kHeightPx);
  const Picture before = tile.draw(frame);
  frame.overlay = true;
  const Picture with = tile.draw(frame, {.tileName = "r0c0"});
  for (const int x : {0, kWidthPx})
    EXPECT_GT(compare(part(before, x, 0, 80, 60), part(with, x, 0, 80, 60))->differingMuch, 1000U);
  EXPECT_EQ(part(before, 0, 120, kWidthPx * 2, 60).rgb, part(with, 0, 120, kWidthPx * 2, 60).rgb);
}

TEST(Stereo, WithoutBuffersForBothEyesIsOneError) {
  OsMesaTile tile(kWidthPx, kHeightPx);
  const Status status = tile.tryDraw(stereoFrame(StereoLayout::QuadBuffer));
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().text().find("side-by-side"), std::string::npos) << status.error().text();
}

TEST(Stereo, ATileOfOnePixelHasNoRoomForTwo) {
  OsMesaTile tile(1, 1);
  EXPECT_FALSE(tile.tryDraw(stereoFrame(StereoLayout::SideBySide)).ok());
  EXPECT_FALSE(tile.tryDraw(stereoFrame(StereoLayout::TopBottom)).ok());
}

TilePlace place() {
  return {.tileName = "r0c0",
          .screenName = "front",
          .widthPx = kWidthPx,
          .heightPx = kHeightPx,
          .screenWidthM = 8,
          .screenHeightM = 3,
          .cornersM = {Vec2(1, 0.5), Vec2(3, 0.5), Vec2(3, 2), Vec2(1, 2)}};
}

proto::TileSetup setupOf(const TilePlace& place) {
  return {.screenName = place.screenName,
          .screenWidthM = place.screenWidthM,
          .screenHeightM = place.screenHeightM,
          .cornersM = place.cornersM};
}

TEST(ShownPattern, IsThatOfTheSetup) {
  OsMesaTile tile(kWidthPx, kHeightPx);
  const Picture scene = tile.draw(testFrame());
  proto::Frame frame = testFrame();
  frame.pattern = proto::Pattern::Alignment;
  const Picture unknown = tile.draw(frame);
  EXPECT_GT(compare(unknown, alignmentPattern(place()))->differingMuch, 100U) << "nobody said where it hangs";
  ASSERT_TRUE(tile.configure(setupOf(place())).ok());
  EXPECT_EQ(tile.draw(frame).rgb, alignmentPattern(place()).rgb);
  frame.pattern = proto::Pattern::Identify;
  EXPECT_EQ(tile.draw(frame).rgb, identifyPattern(place()).rgb);
  EXPECT_EQ(tile.draw(testFrame()).rgb, scene.rgb);
}

TEST(ShownPattern, IsTheFirstThingThatATileDraws) {
  OsMesaTile tile(kWidthPx, kHeightPx);
  ASSERT_TRUE(tile.configure(setupOf(place())).ok());
  proto::Frame frame = testFrame();
  frame.pattern = proto::Pattern::Identify;
  EXPECT_EQ(tile.draw(frame).rgb, identifyPattern(place()).rgb);
}

TEST(ShownPattern, GoesThroughTheOutputPass) {
  proto::TileSetup setup = setupOf(place());
  setup.gainRgb = {0, 1, 1};
  proto::Frame frame = testFrame();
  frame.pattern = proto::Pattern::Alignment;
  const Picture picture = drawn(kWidthPx, kHeightPx, setup, frame);
  const Picture full = alignmentPattern(place());
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) {
    ASSERT_EQ(picture.rgb[i], 0);
    ASSERT_EQ(picture.rgb[i + 1], full.rgb[i + 1]);
  }
}

}  // namespace
}  // namespace tessera::test
