#include "client/overlay.h"

#include <gtest/gtest.h>

#include "tests/client/osmesa_tile.h"

namespace tessera::test {
namespace {

OverlayFacts facts() {
  return {.tileName = "r0c1",
          .framesPerS = 59.94,
          .drawnLeaves = 1234,
          .bytesReceived = 12'345'678,
          .keptLeaves = 5678,
          .keptAssets = 90,
          .skewUs = 420};
}

TEST(Overlay, SaysWhatItIsTold) {
  EXPECT_EQ(overlayLines(facts()),
            (std::vector<std::string>{"r0c1", "59.9 frames/s", "1234 leaves drawn",
                                      "5678 leaves, 90 assets kept", "12.3 MB received", "skew 0.4 ms"}));
}

TEST(Overlay, GrowsWithThePicture) {
  const Picture small = overlayPicture(overlayLines(facts()), 300),
                large = overlayPicture(overlayLines(facts()), 1080);
  EXPECT_EQ(large.widthPx, 2 * small.widthPx);
  EXPECT_EQ(large.heightPx, 2 * small.heightPx);
  EXPECT_EQ(coloursIn(small), 3U) << "ground, name, the other lines";
}

TEST(Overlay, FrameRateIsThatOfTheLastFrames) {
  FrameRate rate;
  EXPECT_EQ(rate.framesPerS(), 0);
  std::int64_t ns = 1'000'000'000'000;
  rate.shown(ns);
  EXPECT_EQ(rate.framesPerS(), 0);
  rate.shown(ns);
  EXPECT_EQ(rate.framesPerS(), 0) << "no time has passed";
  for (int i = 0; i < 100; ++i)
    rate.shown(ns += 100'000'000);
  EXPECT_NEAR(rate.framesPerS(), 10, 1e-9);
  for (int i = 0; i < 100; ++i)
    rate.shown(ns += 20'000'000);
  EXPECT_NEAR(rate.framesPerS(), 50, 1e-9);
}

TEST(Overlay, ShowsInTheUpperLeftCornerAndGoesAgain) {
  OsMesaTile tile(320, 240);
  const Picture before = tile.draw(testFrame());
  proto::Frame frame = testFrame();
  frame.overlay = true;
  const Picture with = tile.draw(frame, facts());
  const Picture text = overlayPicture(overlayLines(facts()), 240);
  int white = 0;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const bool isInBox = x < text.widthPx && y < text.heightPx;
      for (int c = 0; c < 3; ++c) {
        const int value = channelAt(with, x, y, c), former = channelAt(before, x, y, c);
        if (!isInBox) {
          ASSERT_EQ(value, former) << x << " " << y;
        } else if (channelAt(text, x, y, c) == 255 && channelAt(text, x, y, 2) == 255) {
          ASSERT_EQ(value, 255) << x << " " << y;
          ++white;
        } else if (channelAt(text, x, y, 0) == 0) {
          ASSERT_NEAR(value, former * 0.35, 1.5) << x << " " << y;
        }
      }
    }
  }
  EXPECT_GT(white, 1000);
  EXPECT_EQ(tile.draw(testFrame()).rgb, before.rgb);
  EXPECT_EQ(tile.draw(frame, facts()).rgb, with.rgb);
}

// Statistics are read, not corrected: a blended edge would hide them.
TEST(Overlay, IsNotDimmedByTheOutputPass) {
  OsMesaTile tile(320, 240);
  ASSERT_TRUE(tile.configure({.gainRgb = {0, 0, 0}}).ok());
  proto::Frame frame = testFrame();
  frame.overlay = true;
  const Picture picture = tile.draw(frame, facts());
  EXPECT_EQ(*std::max_element(picture.rgb.begin(), picture.rgb.end()), 255);
  EXPECT_EQ(channelAt(picture, 310, 230, 0), 0);
}

}  // namespace
}  // namespace tessera::test
