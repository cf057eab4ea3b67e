// Tide and DisplayCluster: walls measured in pixels.

#include "tests/common/wall/import/imported.h"

namespace tessera {
namespace {

using test::contains;
using test::errorOf;
using test::expectPair;
using test::expectPoint;
using test::imported;
using test::warningsOf;
using test::with;
using Json = nlohmann::json;

const char* const kTide = R"({
  "master": {"host": "m"},
  "processes": [
    {"host": "a", "screens": [
      {"display": ":0", "x": 10, "y": 20},
      {"display": ":0.1", "i": 1, "fullscreen": true}]},
    {"host": "b", "screens": [{"i": 0, "j": 1}, {"i": 1, "j": 1, "x": 5}]}
  ],
  "surfaces": [
    {"displayWidth": 400, "displayHeight": 300, "screenCountX": 2, "screenCountY": 2,
     "bezelWidth": 50, "bezelHeight": 30, "background": {"color": "#000000"}}
  ]
}
)";

TEST(ImportTide, surfacesAreGrids) {
  const Json wall = imported(kTide, "t.json");
  const Json& grid = wall["grid"];
  EXPECT_EQ(grid["columns"], 2);
  EXPECT_EQ(grid["rows"], 2);
  EXPECT_EQ(grid["tile_px"], Json({400, 300}));
  expectPair(grid["tile_mm"], 400, 300);
  expectPair(grid["bezel_mm"], 25, 15);
  EXPECT_FALSE(grid.contains("missing"));
  EXPECT_FALSE(wall.contains("observer"));
  EXPECT_EQ(wall["tiles"]["r0c0"]["host"], "a");
  EXPECT_EQ(wall["tiles"]["r0c0"]["window_px"], Json({10, 20}));
  EXPECT_FALSE(wall["tiles"]["r0c1"].contains("window_px")) << "full screen";
  EXPECT_EQ(wall["tiles"]["r1c1"]["host"], "b");
  EXPECT_EQ(wall["tiles"]["r1c1"]["window_px"], Json({5, 0}));
  const std::string warnings = warningsOf(kTide, "t.json");
  EXPECT_TRUE(contains(warnings, "t.json:2: master: ")) << warnings;
  EXPECT_TRUE(contains(warnings, "t.json:11: background of a surface: ")) << warnings;
  EXPECT_TRUE(contains(warnings, "t.json:6: X display of a screen: ")) << warnings;
}

TEST(ImportTide, negativeBezelsAreOverlaps) {
  const Json grid = imported(with(with(kTide, "\"bezelWidth\": 50", "\"bezelWidth\": -60"),
                                  "\"bezelHeight\": 30", "\"bezelHeight\": 0"),
                             "t.json")["grid"];
  EXPECT_EQ(grid["overlap_px"], Json({60, 0}));
  EXPECT_FALSE(grid.contains("bezel_mm"));
}

TEST(ImportTide, overlapAcrossAndBezelsDownArePlacedFreely) {
  const Json wall = imported(with(kTide, "\"bezelWidth\": 50", "\"bezelWidth\": -60"), "t.json");
  ASSERT_EQ(wall["screens"].size(), 1u);
  EXPECT_EQ(wall["screens"][0]["tiles"].size(), 4u);
  expectPair(wall["screens"][0]["tiles"][3]["at_mm"], 340, 330);
  EXPECT_FALSE(wall.contains("observer"));
}

TEST(ImportTide, severalDisplaysAScreenHideTheBezelsBetweenThem) {
  const Json grid = imported(
      with(kTide, "\"screenCountX\": 2", "\"screenCountX\": 2, \"displaysPerScreenX\": 3"), "t.json")["grid"];
  EXPECT_EQ(grid["tile_px"], Json({3 * 400 + 2 * 50, 300}));
  expectPair(grid["bezel_mm"], 25, 15);
}

TEST(ImportTide, aSurfaceMayHaveASizeInMetres) {
  // 850 x 630 pixels.
  const Json grid = imported(with(kTide, "\"bezelWidth\"", "\"dimensions\": [1.7, 1.26], \"bezelWidth\""),
                             "t.json")["grid"];
  expectPair(grid["tile_mm"], 800, 600);
  expectPair(grid["bezel_mm"], 50, 30);
}

TEST(ImportTide, placesWithoutAProcessAreMissing) {
  const std::string text = with(kTide, "{\"i\": 0, \"j\": 1}, ", "");
  EXPECT_EQ(imported(text, "t.json")["grid"]["missing"], Json({"r1c0"}));
  EXPECT_TRUE(contains(warningsOf(text, "t.json"), "t.json:10: place of the wall that no process shows: "));
  const std::string twice = with(kTide, "\"i\": 0, \"j\": 1", "\"i\": 1, \"j\": 1");
  EXPECT_TRUE(contains(warningsOf(twice, "t.json"), "t.json:7: second screen at the same place"));
}

TEST(ImportTide, eyesBecomeStereoTiles) {
  std::string text = with(kTide, "\"screenCountY\": 2", "\"screenCountY\": 1");
  text = with(text, "{\"i\": 0, \"j\": 1}, {\"i\": 1, \"j\": 1, \"x\": 5}",
              "{\"stereo\": \"right\"}, {\"i\": 1, \"stereo\": \"right\"}");
  text = with(text, "\"x\": 10", "\"stereo\": \"left\", \"x\": 10");
  text = with(text, "\"i\": 1, \"fullscreen\"", "\"i\": 1, \"stereo\": \"left\", \"fullscreen\"");
  const Json wall = imported(text, "t.json");
  ASSERT_EQ(wall["screens"].size(), 1u);
  const Json& screen = wall["screens"][0];
  expectPoint(screen["corners_m"]["lower_right"], 0.85, 0, 0);
  expectPoint(screen["corners_m"]["upper_left"], 0, 0.3, 0);
  ASSERT_EQ(screen["tiles"].size(), 4u);
  EXPECT_EQ(screen["tiles"][0]["eye"], "left");
  EXPECT_EQ(screen["tiles"][3]["eye"], "right");
  expectPair(screen["tiles"][3]["at_mm"], 450, 0);
  EXPECT_EQ(wall["observer"]["stereo"]["mode"], "tiles");
  expectPoint(wall["observer"]["eye_m"], 0.425, 0.15, 0.85);
  EXPECT_TRUE(contains(warningsOf(text, "t.json"), "no eye: "));
}

TEST(ImportTide, severalSurfacesStandSideBySide) {
  std::string text =
      with(kTide, "\"surfaces\": [", "\"surfaces\": [ {\"displayWidth\": 1000, \"displayHeight\": 500},");
  text = with(text, "{\"display\": \":0\", \"x\": 10, \"y\": 20}", "{\"surface\": 0}, {\"surface\": 1}");
  text = with(text, "\":0.1\", \"i\": 1", "\":0.1\", \"surface\": 1, \"i\": 1");
  text = with(text, "{\"i\": 0, \"j\": 1}, {\"i\": 1,",
              "{\"surface\": 1, \"i\": 0, \"j\": 1}, {\"surface\": 1, \"i\": 1,");
  const Json wall = imported(text, "t.json");
  ASSERT_EQ(wall["screens"].size(), 2u);
  expectPoint(wall["screens"][0]["corners_m"]["lower_right"], 1, 0, 0);
  expectPoint(wall["screens"][1]["corners_m"]["lower_left"], 1.1, 0, 0);
  EXPECT_EQ(wall["screens"][1]["tiles"].size(), 4u);
  EXPECT_EQ(wall["screens"][1]["tiles"][0]["name"], "s1-r0c0");
  EXPECT_TRUE(wall.contains("observer"));
  EXPECT_TRUE(contains(warningsOf(text, "t.json"), "several surfaces: "));
}

TEST(ImportTide, saysWhereAnErrorIs) {
  EXPECT_TRUE(contains(errorOf(with(kTide, "\"displayWidth\": 400", "\"displayWidth\": 0"), "t.json"),
                       "t.json:10: the displays have no possible size"));
  EXPECT_TRUE(contains(errorOf(with(kTide, "\"displayWidth\": 400, ", ""), "t.json"),
                       "t.json:10: the displays have no possible size"));
  EXPECT_TRUE(contains(errorOf(with(kTide, "\"i\": 1, \"j\": 1", "\"i\": 2, \"j\": 1"), "t.json"),
                       "t.json:7: column 2, row 1 lies outside"));
  EXPECT_TRUE(contains(errorOf(with(kTide, "\"i\": 0, \"j\": 1", "\"surface\": 3"), "t.json"),
                       "lies on surface 3 of 1"));
  EXPECT_TRUE(contains(errorOf(with(kTide, "\"screenCountX\": 2", "\"screenCountX\": 2.5"), "t.json"),
                       "whole number"));
  EXPECT_TRUE(contains(errorOf(with(kTide, "\"screenCountX\": 2", "\"screenCountX\": 4000"), "t.json"),
                       "more than 4096 tiles"));
  EXPECT_TRUE(contains(errorOf(with(kTide, "\"bezelWidth\": 50", "\"bezelWidth\": -400"), "t.json"),
                       "overlap wholly"));
  EXPECT_TRUE(contains(errorOf("{\"surfaces\": []}", "t.json"), "no surface"));
  EXPECT_TRUE(contains(errorOf("{\"surfaces\": 3}", "t.json"), "must be an array"));
  EXPECT_TRUE(contains(errorOf("{\"surfaces\": [3]}", "t.json"), "must hold objects"));
}

const char* const kDisplayCluster = R"(<?xml version="1.0"?>
<configuration>
  <dimensions numTilesWidth="3" numTilesHeight="1" screenWidth="400" screenHeight="300" mullionWidth="50" mullionHeight="40" fullscreen="0"/>
  <background uri="x.png"/>
  <process host="a" display=":0">
    <screen x="0" y="7" i="0" j="0"/>
    <screen x="400" y="7" i="1" j="0"/>
  </process>
  <process host="b" display=":1">
    <screen x="1" y="2" i="2" j="0"/>
  </process>
</configuration>
)";

TEST(ImportDisplayCluster, dimensionsAreAGrid) {
  const Json wall = imported(kDisplayCluster, "d.xml");
  EXPECT_EQ(wall["grid"]["columns"], 3);
  EXPECT_EQ(wall["grid"]["tile_px"], Json({400, 300}));
  expectPair(wall["grid"]["bezel_mm"], 25, 20);
  EXPECT_EQ(wall["tiles"]["r0c1"]["window_px"], Json({400, 7}));
  EXPECT_EQ(wall["tiles"]["r0c2"]["host"], "b");
  const std::string warnings = warningsOf(kDisplayCluster, "d.xml");
  EXPECT_TRUE(contains(warnings, "d.xml:4: background: ")) << warnings;
  EXPECT_TRUE(contains(warnings, "d.xml:9: X display: ")) << warnings;
}

TEST(ImportDisplayCluster, fullScreenHasNoWindowPosition) {
  const Json wall = imported(with(kDisplayCluster, "fullscreen=\"0\"", "fullscreen=\"1\""), "d.xml");
  EXPECT_FALSE(wall["tiles"]["r0c0"].contains("window_px"));
}

TEST(ImportDisplayCluster, tidesXmlHasOtherNames) {
  const Json wall = imported(R"(<configuration>
    <dimensions numScreensX="2" numScreensY="1" displaysPerScreenX="2" displayWidth="100" displayHeight="100"
                bezelWidth="10" bezelHeight="0" physicalWidth="4.3" physicalHeight="1"/>
    <process host="a"><screen display=":0" i="0" j="0" stereo="left"/><screen i="1"/></process>
  </configuration>)",
                             "t.xml");
  // 210 pixels a screen, 430 in all, on 4.3 m.
  ASSERT_EQ(wall["screens"].size(), 1u);
  EXPECT_EQ(wall["screens"][0]["tiles"][0]["px"], Json({210, 100}));
  expectPair(wall["screens"][0]["tiles"][1]["at_mm"], 2200, 0);
  EXPECT_EQ(wall["screens"][0]["tiles"][1]["eye"], "left") << "shows both, but others show one";
}

TEST(ImportDisplayCluster, saysWhereAnErrorIs) {
  EXPECT_TRUE(contains(errorOf(with(kDisplayCluster, "\"400\"", "\"4x0\""), "d.xml"),
                       "d.xml:3: \"screenWidth\" must be a whole number"));
  EXPECT_TRUE(contains(errorOf("<configuration/>", "d.xml"), "no <dimensions>"));
  EXPECT_TRUE(contains(errorOf("<configuration>\n<a></b>", "d.xml"), "d.xml:2: is no XML"));
  EXPECT_TRUE(contains(errorOf("<!DOCTYPE a [<!ENTITY b 'c'>]><configuration/>", "d.xml"), "document type"));
}

TEST(ImportPixelWalls, everyTruncationAndDamageIsAnErrorOrAWall) {
  for (const char* whole : {kTide, kDisplayCluster}) {
    const std::string text = whole;
    for (std::size_t size = 0; size < text.size(); ++size)
      (void)importWallText(std::string_view(text).substr(0, size), "t");
    for (std::size_t i = 0; i < text.size(); ++i) {
      for (const char damage : {'\0', '{', '"', '9', '-', '<', '\xff'}) {
        std::string damaged = text;
        damaged[i] = damage;
        const Result<ImportedWall> wall = importWallText(damaged, "t");
        if (wall) {
          EXPECT_TRUE(Json::accept(wall->json, true)) << i;
        }
      }
    }
    EXPECT_FALSE(importWallText(std::string_view(text).substr(0, text.size() / 2), "t").ok());
  }
}

}  // namespace
}  // namespace tessera
