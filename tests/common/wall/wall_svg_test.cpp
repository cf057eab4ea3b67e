#include "common/wall/wall_svg.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "common/wall/wall_file.h"

namespace tessera {
namespace {

Wall parsed(const std::string& text) {
  Result<Wall> wall = parseWall(text, "dir/w&w.json");
  EXPECT_TRUE(wall.ok()) << wall.error().text();
  return *wall;
}

std::size_t countOf(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

TEST(WallSvg, showsTilesSizesAndFieldOfView) {
  const std::string svg = wallSvg(parsed(
      R"({"grid": {"columns": 3, "rows": 2, "tile_px": [321, 240]}, "camera": {"fov_y_deg": 50, "near_m": 0.1}})"));
  for (const char* part :
       {">r0c0<", ">r1c2<", ">321 x 240 px<", "3 x 2 tiles of 321 x 240 pixels, 963 x 480 in all",
        "50 deg vertical, 86.184 deg horizontal", "Near 0.1 m, far fitted to the scene",
        "Warning: tiles of 321 x 240", "dir/w&amp;w.json"}) {
    EXPECT_NE(svg.find(part), std::string::npos) << part << " in\n" << svg;
  }
  EXPECT_EQ(countOf(svg, "class=\"tile\""), 6u);
  EXPECT_EQ(countOf(svg, "<text"), countOf(svg, "</text>"));
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(WallSvg, escapesXml) {
  const std::string svg = wallSvg(parsed(
      R"({"name": "<a href='x'>&\"\u0001\ufffe", "grid": {"columns": 1, "rows": 1, "tile_px": [8, 8]}})"));
  EXPECT_NE(svg.find("&lt;a href=&apos;x&apos;&gt;&amp;&quot;?"
                     "?<"),
            std::string::npos)
      << svg;
  EXPECT_TRUE(std::none_of(svg.begin(), svg.end(), [](char c) { return c > 0 && c < ' ' && c != '\n'; }));
}

TEST(WallSvg, drawsTheLargestWalls) {
  const std::string svg =
      wallSvg(parsed(R"({"grid": {"columns": 64, "rows": 64, "tile_px": [1023, 1023]}})"));
  EXPECT_EQ(countOf(svg, "class=\"tile\""), 4096u);
  // Tiles too small for any name.
  const std::string narrow = wallSvg(parsed(R"({"grid": {"columns": 1, "rows": 256, "tile_px": [1, 255]}})"));
  EXPECT_EQ(countOf(narrow, "class=\"tile\""), 256u);
  EXPECT_EQ(narrow.find("r0c0"), std::string::npos);
}

}  // namespace
}  // namespace tessera
