#include "common/base/pixel_place.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(PixelPlace, IsReadWithAndWithoutASize) {
  const auto place = parsePixelPlace("--window", "1920,-5");
  ASSERT_TRUE(place);
  EXPECT_EQ(place->xPx, 1920);
  EXPECT_EQ(place->yPx, -5);
  EXPECT_FALSE(place->size);
  const auto sized = parsePixelPlace("--window", "0,7,640x480");
  ASSERT_TRUE(sized);
  EXPECT_EQ(sized->yPx, 7);
  EXPECT_EQ(sized->size, (PixelSize{640, 480}));
}

TEST(PixelPlace, AnythingElseIsOneErrorThatNamesTheFlag) {
  for (const char* text : {"",
                           "1",
                           "1,",
                           ",1",
                           "1,2,",
                           "1,2,3",
                           "1,2,3x",
                           "1,2,x3",
                           "1,2,0x3",
                           "1,2,3x0",
                           "1,2,-3x4",
                           "1,2,3x4,5",
                           "1,2 ",
                           " 1,2",
                           "1;2",
                           "1.5,2",
                           "65537,0",
                           "0,-65537",
                           "1,2,16385x1",
                           "1,2,1x16385",
                           "a,b",
                           "99999999999999999999,0",
                           "1x2",
                           "1,2x3"}) {
    const auto place = parsePixelPlace("--window", text);
    ASSERT_FALSE(place) << text;
    EXPECT_EQ(place.error().exitStatus(), 2) << text;
    EXPECT_EQ(place.error().where, "--window") << text;
  }
}

TEST(PixelPlace, SizesAreWrittenAsTheyAreRead) {
  EXPECT_EQ(textOf(PixelSize{1920, 1080}), "1920x1080");
}

}  // namespace
}  // namespace tessera
