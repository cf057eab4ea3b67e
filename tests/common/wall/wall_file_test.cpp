#include "common/wall/wall_file.h"

#include <clocale>
#include <locale>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

namespace tessera {
namespace {

constexpr std::string_view kSmallest =
    R"({"grid": {"columns": 2, "rows": 2, "tile_px": [480, 270]}, "camera": {"fov_y_deg": 50}})";

std::string errorOf(std::string_view text) {
  const Result<Wall> wall = parseWall(text, "w.json");
  return wall ? "no error" : wall.error().text();
}

void expectError(std::string_view text, int line, std::string_view part) {
  const Result<Wall> wall = parseWall(text, "w.json");
  ASSERT_FALSE(wall.ok()) << text;
  EXPECT_EQ(wall.error().kind, ErrorKind::Input);
  EXPECT_EQ(wall.error().where, "w.json:" + std::to_string(line)) << wall.error().text();
  EXPECT_NE(wall.error().text().find(part), std::string::npos) << wall.error().text();
}

/// A whole wall file with the part to be tried on line 2.
std::string withGrid(const std::string& grid) {
  return "{\"grid\":\n{" + grid + "}\n}";
}
std::string withCamera(const std::string& camera) {
  return "{\"grid\": {\"columns\": 1, \"rows\": 1, \"tile_px\": [8, 8]}, \"camera\":\n{" + camera + "}\n}";
}

TEST(WallFile, readsTheSmallestWall) {
  const Result<Wall> wall = parseWall(kSmallest, "w.json");
  ASSERT_TRUE(wall.ok()) << wall.error().text();
  EXPECT_EQ(wall->source, "w.json");
  ASSERT_EQ(wall->screens.size(), 1u);
  EXPECT_EQ(wall->screens[0].columns, 2);
  EXPECT_EQ(wall->screens[0].rows, 2);
  EXPECT_EQ(wall->tiles[0].canvasWidthPx, 960);
  EXPECT_EQ(wall->tiles[0].canvasHeightPx, 540);
  EXPECT_DOUBLE_EQ(wall->fovYRad, 50 * std::numbers::pi / 180);
  EXPECT_FALSE(wall->near.has_value());
  EXPECT_FALSE(wall->far.has_value());
  EXPECT_TRUE(wall->warnings.empty());
  ASSERT_EQ(wall->tiles.size(), 4u);
  EXPECT_EQ(wall->tiles[1].name, "r0c1");
  EXPECT_EQ(wall->tiles[1].xPx, 480);
  EXPECT_EQ(wall->tiles[1].yPx, 0);
  EXPECT_EQ(wall->tiles[2].name, "r1c0");
  EXPECT_EQ(wall->tiles[2].xPx, 0);
  EXPECT_EQ(wall->tiles[2].yPx, 270);
  EXPECT_EQ(wall->tiles[2].widthPx, 480);
}

TEST(WallFile, takesNamesDistancesAndDefaults) {
  const Result<Wall> wall = parseWall(
      R"({"name": "lab", "$schema": "x", "camera": {"near_m": 0.5, "far_m": 20},
          "grid": {"columns": 2, "rows": 1, "tile_px": [4.0, 4], "names": [["a.b", "C-_9"]]}})",
      "w.json");
  ASSERT_TRUE(wall.ok()) << wall.error().text();
  EXPECT_EQ(wall->name, "lab");
  EXPECT_EQ(wall->tiles[0].name, "a.b");
  EXPECT_EQ(wall->tiles[1].name, "C-_9");
  EXPECT_EQ(wall->near, 0.5);
  EXPECT_EQ(wall->far, 20);
  EXPECT_DOUBLE_EQ(wall->fovYRad, kDefaultFovYDeg * std::numbers::pi / 180);
}

TEST(WallFile, everyTruncationIsACleanError) {
  for (std::size_t length = 0; length < kSmallest.size(); ++length) {
    // A copy of its own, so that a sanitizer sees any read behind its end.
    const std::string prefix(kSmallest.substr(0, length));
    expectError(prefix, 1, "");
  }
}

TEST(WallFile, everySingleByteChangeIsACleanErrorOrAWall) {
  for (std::size_t i = 0; i < kSmallest.size(); ++i) {
    for (const char byte : {'\0', '"', '{', '}', '[', ',', '9', '-', '/', '\xff'}) {
      std::string text(kSmallest);
      text[i] = byte;
      const Result<Wall> wall = parseWall(text, "w.json");
      if (wall.ok()) continue;
      EXPECT_EQ(wall.error().where, "w.json:1") << text;
    }
  }
}

TEST(WallFile, namesMissingFilesAndTooLargeOnes) {
  const Result<Wall> missing = readWallFile("/no/such/wall.json");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().where, "/no/such/wall.json");
  EXPECT_EQ(missing.error().exitStatus(), 2);
  EXPECT_FALSE(readWallFile("/dev/zero").ok());
  EXPECT_FALSE(readWallFile("/").ok());
}

TEST(WallFile, refusesWrongTypes) {
  expectError("[]", 1, "\"wall\" must be an object, not an array");
  expectError("\n3", 2, "\"wall\" must be an object, not a number");
  expectError("{\n\"name\": 3, \"grid\": {}}", 2, "\"name\" must be a string");
  expectError("{\n\"grid\": []}", 2, "\"grid\" must be an object");
  expectError(withGrid(R"("columns": "2", "rows": 1, "tile_px": [8, 8])"), 2, "\"columns\" must be a whole");
  expectError(withGrid(R"("columns": null, "rows": 1, "tile_px": [8, 8])"), 2, "not null");
  expectError(withGrid(R"("columns": 1.5, "rows": 1, "tile_px": [8, 8])"), 2, "not 1.5");
  expectError(withGrid(R"("columns": 1, "rows": true, "tile_px": [8, 8])"), 2, "\"rows\" must be");
  expectError(withGrid(R"("columns": 1, "rows": 1, "tile_px": 8)"), 2, "\"tile_px\" must be an array");
  expectError(withGrid(R"("columns": 1, "rows": 1, "tile_px": [8])"), 2, "2 numbers, not of 1");
  expectError(withGrid(R"("columns": 1, "rows": 1, "tile_px": [8, "8"])"), 2, "not a string");
  expectError(withGrid(R"("columns": 1, "rows": 1, "tile_px": [8, 8], "names": {})"), 2, "an array");
  expectError(withGrid(R"("columns": 1, "rows": 1, "tile_px": [8, 8], "names": ["a"])"), 2, "an array");
  expectError(withCamera(R"("fov_y_deg": "50")"), 2, "\"fov_y_deg\" must be a number, not a string");
  expectError(withCamera(R"("near_m": null)"), 2, "\"near_m\" must be a number");
}

TEST(WallFile, refusesUnknownKeysAndSuggestsTheNearest) {
  expectError("{\n\"grd\": {}}", 2, "unknown key \"grd\" in \"wall\"; did you mean \"grid\"?");
  expectError(withGrid("\"rows\": 1,\n\"colums\": 2"), 3, "did you mean \"columns\"?");
  expectError(withGrid(R"("tilePx": [1, 1])"), 2, "did you mean \"tile_px\"?");
  expectError(withCamera(R"("fov_deg": 50)"), 2, "did you mean \"fov_y_deg\"?");
}

TEST(WallFile, refusesMissingKeys) {
  expectError("\n{}", 2, "\"wall\" lacks \"grid\"");
  expectError(withGrid(R"("rows": 1, "tile_px": [8, 8])"), 2, "\"grid\" lacks \"columns\"");
  expectError(withGrid(R"("columns": 1, "tile_px": [8, 8])"), 2, "\"grid\" lacks \"rows\"");
  expectError(withGrid(R"("columns": 1, "rows": 1)"), 2, "\"grid\" lacks \"tile_px\"");
}

TEST(WallFile, boundsSizes) {
  expectError(withGrid(R"("columns": 0, "rows": 1, "tile_px": [8, 8])"), 2, "1 to 256, not 0");
  expectError(withGrid(R"("columns": -1, "rows": 1, "tile_px": [8, 8])"), 2, "1 to 256, not -1");
  expectError(withGrid(R"("columns": 1, "rows": 257, "tile_px": [8, 8])"), 2, "1 to 256, not 257");
  expectError(withGrid(R"("columns": 1, "rows": 99999999999999999999, "tile_px": [8, 8])"), 2, "1 to 256");
  expectError(withGrid(R"("columns": 1, "rows": 1, "tile_px": [0, 8])"), 2, "1 to 16384, not 0");
  expectError(withGrid(R"("columns": 1, "rows": 1, "tile_px": [8, 16385])"), 2, "1 to 16384, not 16385");
  expectError(withGrid(R"("columns": 65, "rows": 64, "tile_px": [8, 8])"), 2, "4160 tiles");
  expectError(withGrid("\"columns\": 1, \"rows\": 4,\n\"tile_px\": [8, 16384]"), 3, "8 x 65536 pixels");
  EXPECT_EQ(errorOf(withGrid(R"("columns": 64, "rows": 64, "tile_px": [1, 1])")), "no error");
  EXPECT_EQ(errorOf(withGrid(R"("columns": 5, "rows": 1, "tile_px": [13107, 1])")), "no error");
}

TEST(WallFile, boundsTheCamera) {
  for (const char* fov : {"0", "-50", "180", "0.0009", "179.95", "1e300"}) {
    expectError(withCamera(std::string("\"fov_y_deg\": ") + fov), 2, "0.001 to 179.9");
  }
  for (const char* number : {"1e999", "-1e999", "NaN", "Infinity", "nan"}) {
    expectError(withCamera(std::string("\"fov_y_deg\": ") + number), 2, "");
  }
  expectError(withCamera(R"("near_m": -0.1)"), 2, "\"near_m\" must be from");
  expectError(withCamera(R"("near_m": 0)"), 2, "\"near_m\" must be from");
  expectError(withCamera(R"("far_m": 0)"), 2, "\"far_m\" must be from");
  expectError(withCamera("\"near_m\": 2,\n\"far_m\": 2"), 3, "\"far_m\" (2) must be greater");
  expectError(withCamera("\"far_m\": 1,\n\"near_m\": 2"), 2, "\"far_m\" (1) must be greater");
  EXPECT_EQ(errorOf(withCamera(R"("fov_y_deg": 0.001)")), "no error");
  EXPECT_EQ(errorOf(withCamera(R"("fov_y_deg": 179.9)")), "no error");
}

TEST(WallFile, boundsNames) {
  const auto named = [](const std::string& names) {
    return withGrid(R"("columns": 2, "rows": 2, "tile_px": [8, 8], "names":)" + names);
  };
  expectError(named("[[\"a\", \"b\"],\n[\"c\", \"a\"]]"), 3, "two tiles are named \"a\": here and on line 2");
  expectError(named(R"([["a", "b"]])"), 2, "has 1 rows, the grid 2");
  expectError(named(R"([])"), 2, "has 0 rows, the grid 2");
  expectError(named("[[\"a\", \"b\"],\n[\"c\"]]"), 3, "has 1 names, the grid has 2 columns");
  expectError(named("[[\"a\", \"b\"],\n[\"c\", \"\"]]"), 3, "cannot be named \"\"");
  expectError(named(R"([["a", "b"], ["c", "d e"]])"), 2, "cannot be named \"d e\"");
  expectError(named(R"([["a", "b"], ["c", "\u00e4"]])"), 2, "cannot be named");
  expectError(named(R"([["a", "b"], ["c", 4]])"), 2, "cannot be named \"no string\"");
  expectError(named(R"([["a", "b"], ["c", ")" + std::string(65, 'x') + "\"]]"), 2, "1 to 64");
  EXPECT_EQ(errorOf(named(R"([["a", "b"], ["c", ")" + std::string(64, 'x') + "\"]]")), "no error");
}

TEST(WallFile, warnsOfOddTilesOnlyWhereTheyMakeSeams) {
  const auto warnings = [](int columns, int rows, int width, int height) {
    const Result<Wall> wall =
        parseWall(withGrid("\"columns\":" + std::to_string(columns) + ",\"rows\":" + std::to_string(rows) +
                           ",\"tile_px\":[" + std::to_string(width) + "," + std::to_string(height) + "]"),
                  "w.json");
    return wall.ok() ? static_cast<int>(wall->warnings.size()) : -1;
  };
  EXPECT_EQ(warnings(2, 2, 480, 270), 0);
  EXPECT_EQ(warnings(2, 2, 481, 270), 1);
  EXPECT_EQ(warnings(2, 2, 481, 271), 1);
  EXPECT_EQ(warnings(1, 2, 481, 270), 0);
  EXPECT_EQ(warnings(2, 1, 480, 271), 0);
  EXPECT_EQ(warnings(1, 1, 481, 271), 0);
}

/// std::locale's own comma; needs no locale to be installed.
struct CommaPoint : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(WallFile, streamLocaleDoesNotMatter) {
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new CommaPoint));
  const Result<Wall> wall = parseWall(withCamera(R"("fov_y_deg": 50.5)"), "w.json");
  const std::string error = errorOf(withCamera(R"("fov_y_deg": 1000.5)"));
  std::locale::global(before);
  ASSERT_TRUE(wall.ok()) << wall.error().text();
  EXPECT_DOUBLE_EQ(wall->fovYRad, 50.5 * std::numbers::pi / 180);
  EXPECT_NE(error.find("1000.5"), std::string::npos) << error;
}

TEST(WallFile, programLocaleDoesNotMatter) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  const char* comma = nullptr;
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "de_DE", "fr_FR.UTF-8", "nl_NL.UTF-8"}) {
    if (!comma) comma = std::setlocale(LC_ALL, name);
  }
  if (!comma) GTEST_SKIP() << "no locale with a decimal comma is installed (de_DE, fr_FR, nl_NL)";
  const Result<Wall> wall = parseWall(withCamera(R"("fov_y_deg": 50.5)"), "w.json");
  std::setlocale(LC_ALL, before.c_str());
  ASSERT_TRUE(wall.ok()) << wall.error().text();
  EXPECT_DOUBLE_EQ(wall->fovYRad, 50.5 * std::numbers::pi / 180);
}

}  // namespace
}  // namespace tessera
