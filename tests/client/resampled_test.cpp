#include <gtest/gtest.h>

#include "client/surface.h"

namespace tessera {
namespace {

/// A picture whose pixels each say where they are.
std::vector<std::uint8_t> chart(PixelSize size) {
  std::vector<std::uint8_t> rgb;
  for (int y = 0; y < size.heightPx; ++y) {
    for (int x = 0; x < size.widthPx; ++x)
      rgb.insert(rgb.end(), {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), 99});
  }
  return rgb;
}

TEST(Resampled, TheSameSizeIsTheSamePicture) {
  const PixelSize size{5, 3};
  EXPECT_EQ(resampled(chart(size), size, size), chart(size));
}

TEST(Resampled, TwiceAsLargeShowsEachPixelFourTimes) {
  const PixelSize from{3, 2}, to{6, 4};
  const auto large = resampled(chart(from), from, to);
  ASSERT_EQ(large.size(), 6U * 4U * 3U);
  for (std::size_t y = 0; y < 4; ++y) {
    for (std::size_t x = 0; x < 6; ++x) {
      EXPECT_EQ(large[(y * 6 + x) * 3], x / 2);
      EXPECT_EQ(large[(y * 6 + x) * 3 + 1], y / 2);
    }
  }
}

TEST(Resampled, SmallerTakesThePixelInTheMiddle) {
  const PixelSize from{9, 6}, to{3, 2};
  const auto small = resampled(chart(from), from, to);
  ASSERT_EQ(small.size(), 3U * 2U * 3U);
  for (std::size_t x = 0; x < 3; ++x)
    EXPECT_EQ(small[x * 3], 3 * x + 1);
  EXPECT_EQ(resampled(chart(from), from, {1, 1})[0], 4);
}

}  // namespace
}  // namespace tessera
