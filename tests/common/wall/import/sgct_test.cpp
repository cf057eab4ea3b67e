#include <cmath>

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

const char* const kSgct = R"({
  "version": 1,
  "masteraddress": "localhost",
  "settings": {"display": {"swapinterval": 0}},
  "nodes": [
    {"address": "north", "port": 20401, "windows": [
      {"fullscreen": false, "msaa": 4, "pos": {"x": 10, "y": 20}, "size": {"x": 640, "y": 400}, "viewports": [
        {"pos": {"x": 0, "y": 0}, "size": {"x": 0.5, "y": 0.25},
         "projection": {"type": "ProjectionPlane",
           "lowerleft": {"x": -1, "y": 0, "z": 0},
           "upperleft": {"x": -1, "y": 2, "z": 0.5},
           "upperright": {"x": 3, "y": 2, "z": 0.5}}},
        {"pos": {"x": 0.5, "y": 0}, "size": {"x": 0.5, "y": 1},
         "projection": {"type": "PlanarProjection", "fov": {"hfov": 80, "vfov": 60},
           "orientation": {"yaw": 20, "pitch": 0, "roll": 0}}}]}]}
  ],
  "users": [{"eyeseparation": 0.06, "pos": {"x": 0, "y": 0.5, "z": 4}}]
}
)";

TEST(ImportSgct, viewportsAreScreens) {
  const Json wall = imported(kSgct, "s.json");
  ASSERT_EQ(wall["screens"].size(), 2u);
  const Json& plane = wall["screens"][0];
  expectPoint(plane["corners_m"]["lower_left"], -1, 0, 0);
  expectPoint(plane["corners_m"]["lower_right"], 3, 0, 0);
  expectPoint(plane["corners_m"]["upper_left"], -1, 2, 0.5);
  const Json& tile = plane["tiles"][0];
  EXPECT_EQ(tile["px"], Json({320, 100}));
  EXPECT_EQ(tile["window_px"], Json({10, 20 + 300})) << "a viewport's y counts from the bottom";
  EXPECT_EQ(tile["host"], "north");
  expectPair(tile["at_mm"], 0, 0);
  expectPair(tile["size_mm"], 4000, std::hypot(2, 0.5) * 1000);
  expectPoint(wall["observer"]["eye_m"], 0, 0.5, 4);
  EXPECT_FALSE(wall["observer"].contains("stereo"));

  // 10 m down the z axis from the room's origin, turned to the right.
  const double w = 10 * std::tan(40 * M_PI / 180), h = 10 * std::tan(30 * M_PI / 180);
  const double c = std::cos(20 * M_PI / 180), s = std::sin(20 * M_PI / 180);
  const Json& planar = wall["screens"][1]["corners_m"];
  expectPoint(planar["lower_left"], -w * c + 10 * s, -h, -w * s - 10 * c);
  expectPoint(planar["lower_right"], w * c + 10 * s, -h, w * s - 10 * c);
  expectPoint(planar["upper_left"], -w * c + 10 * s, h, -w * s - 10 * c);
  EXPECT_EQ(wall["screens"][1]["tiles"][0]["px"], Json({320, 400}));
}

TEST(ImportSgct, planarProjectionsInAllTheirForms) {
  const auto cornersOf = [](const std::string& fov, const std::string& orientation) {
    return imported(with(with(kSgct, "{\"hfov\": 80, \"vfov\": 60}", fov),
                         "\"orientation\": {\"yaw\": 20, \"pitch\": 0, \"roll\": 0}", orientation),
                    "s.json")["screens"][1]["corners_m"];
  };
  const auto tangent = [](double deg) { return std::tan(deg * M_PI / 180); };
  // Angles to the left and down count positive; the offset moves the plane.
  Json corners = cornersOf(R"({"left": 10, "right": 30, "down": 20, "up": 25, "distance": 2})",
                           R"("offset": {"x": 1, "y": 2, "z": 3})");
  expectPoint(corners["lower_left"], 1 - 2 * tangent(10), 2 - 2 * tangent(20), 3 - 2);
  expectPoint(corners["upper_left"], 1 - 2 * tangent(10), 2 + 2 * tangent(25), 3 - 2);
  expectPoint(corners["lower_right"], 1 + 2 * tangent(30), 2 - 2 * tangent(20), 3 - 2);
  // A pitch looks up, a roll turns clockwise.
  corners = cornersOf(R"({"hfov": 90, "vfov": 90, "distance": 1})",
                      R"("orientation": {"yaw": 0, "pitch": 90, "roll": 0})");
  expectPoint(corners["lower_left"], -1, 1, -1);
  expectPoint(corners["upper_left"], -1, 1, 1);
  corners = cornersOf(R"({"hfov": 90, "vfov": 90})",
                      R"("distance": 1, "orientation": {"yaw": 0, "pitch": 0, "roll": 90})");
  expectPoint(corners["lower_left"], -1, 1, -1);
  expectPoint(corners["upper_left"], 1, 1, -1);
  // The same as a quaternion about z.
  corners = cornersOf(R"({"hfov": 90, "vfov": 90, "distance": 1})",
                      R"("orientation": {"x": 0, "y": 0, "z": -0.70710678118, "w": 0.70710678118})");
  expectPoint(corners["lower_left"], -1, 1, -1);
}

TEST(ImportSgct, stereoModes) {
  const auto stereo = [](const std::string& mode) {
    return with(kSgct, "\"msaa\": 4", "\"stereo\": \"" + mode + "\"");
  };
  EXPECT_EQ(imported(stereo("side_by_side"), "s.json")["observer"]["stereo"]["mode"], "side-by-side");
  EXPECT_NEAR(imported(stereo("active"), "s.json")["observer"]["stereo"]["separation_mm"], 60, 1e-9);
  EXPECT_EQ(imported(stereo("active"), "s.json")["observer"]["stereo"]["mode"], "quad-buffer");
  EXPECT_EQ(imported(stereo("top_bottom_inverted"), "s.json")["observer"]["stereo"]["mode"], "top-bottom");
  EXPECT_TRUE(
      contains(warningsOf(stereo("top_bottom_inverted"), "s.json"), "stereo mode top_bottom_inverted"));
  EXPECT_FALSE(imported(stereo("anaglyph_red_cyan"), "s.json")["observer"].contains("stereo"));
  EXPECT_TRUE(contains(warningsOf(stereo("anaglyph_red_cyan"), "s.json"), "stereo mode anaglyph_red_cyan"));
  const std::string eye = with(kSgct, "{\"pos\": {\"x\": 0, ", "{\"eye\": \"right\", \"pos\": {\"x\": 0, ");
  const Json wall = imported(eye, "s.json");
  EXPECT_EQ(wall["observer"]["stereo"]["mode"], "tiles");
  EXPECT_EQ(wall["screens"][0]["tiles"][0]["eye"], "right");
  EXPECT_EQ(wall["screens"][1]["tiles"][0]["eye"], "left");
}

TEST(ImportSgct, namesWhatIsNoWall) {
  std::string text = with(kSgct, "\"users\": [",
                          "\"users\": [{\"pos\": {\"x\": 0, \"y\": 0, \"z\": 9}, \"tracking\": {}}, ");
  text = with(text, "{\"pos\": {\"x\": 0.5", "{\"mesh\": \"m.obj\", \"pos\": {\"x\": 0.5");
  const std::string warnings = warningsOf(text, "s.json");
  for (const char* kind :
       {"s.json:3: masteraddress: ", "s.json:4: settings: ", "s.json:6: port of a node: ",
        "s.json:7: msaa of a window: ", "further user: ", "tracking of a user: ", "mesh of a viewport: "})
    EXPECT_TRUE(contains(warnings, kind)) << kind << '\n' << warnings;
  expectPoint(imported(text, "s.json")["observer"]["eye_m"], 0, 0, 9);
}

TEST(ImportSgct, curvedProjectionsAreNoWall) {
  const std::string one = with(kSgct, "\"type\": \"PlanarProjection\"", "\"type\": \"FisheyeProjection\"");
  EXPECT_EQ(imported(one, "s.json")["screens"].size(), 1u);
  EXPECT_TRUE(
      contains(warningsOf(one, "s.json"), "s.json:14: viewport with the projection FisheyeProjection: "))
      << warningsOf(one, "s.json");
  const std::string all = with(one, "\"type\": \"ProjectionPlane\"", "\"type\": \"CylindricalProjection\"");
  EXPECT_TRUE(contains(
      errorOf(all, "s.json"),
      "s.json:9: the pictures have the projection \"CylindricalProjection\", which shows no flat screen"))
      << errorOf(all, "s.json");
}

TEST(ImportSgct, windowsWithoutSizeAndPosition) {
  const std::string bare =
      with(with(kSgct, "\"size\": {\"x\": 640, \"y\": 400}, ", ""), "\"pos\": {\"x\": 10, \"y\": 20}, ", "");
  const Json wall = imported(bare, "s.json");
  EXPECT_EQ(wall["screens"][0]["tiles"][0]["px"], Json({960, 270}));
  EXPECT_FALSE(wall["screens"][0]["tiles"][0].contains("window_px"));
  EXPECT_TRUE(contains(warningsOf(bare, "s.json"), "s.json:7: window without a size in pixels: "));
  const std::string full = with(kSgct, "\"fullscreen\": false", "\"fullscreen\": true");
  EXPECT_FALSE(imported(full, "s.json")["screens"][0]["tiles"][0].contains("window_px"));
}

TEST(ImportSgct, saysWhereAnErrorIs) {
  EXPECT_TRUE(contains(errorOf(with(kSgct, "\"z\": 4", "\"z\": -4"), "s.json"),
                       "the eye does not stand before the screen screen0"));
  EXPECT_TRUE(contains(
      errorOf(with(kSgct, "\"x\": 3, \"y\": 2, \"z\": 0.5", "\"x\": 3, \"y\": 3, \"z\": 0.5"), "s.json"),
      "no rectangle"));
  EXPECT_TRUE(contains(errorOf(with(kSgct, "\"lowerleft\"", "\"lowleft\""), "s.json"),
                       "s.json:9: \"projection\" lacks \"lowerleft\""));
  EXPECT_TRUE(contains(errorOf(with(kSgct, "\"hfov\": 80", "\"hfov\": 180"), "s.json"),
                       "\"hfov\" must be from 0 to 179.98"));
  EXPECT_TRUE(contains(errorOf(with(kSgct, "\"hfov\": 80, ", ""), "s.json"), "field of view is empty"));
  EXPECT_TRUE(contains(errorOf(with(kSgct, "{\"x\": 0.5, \"y\": 0.25}", "{\"x\": 0, \"y\": 0.25}"), "s.json"),
                       "0 x 100 pixels"));
  EXPECT_TRUE(contains(errorOf(R"({"nodes": []})", "s.json"), "no window with a viewport"));
  EXPECT_TRUE(contains(errorOf(R"({"nodes": 7})", "s.json"), "must be an array"));
}

TEST(ImportSgct, everyTruncationAndDamageIsAnErrorOrAWall) {
  const std::string text = kSgct;
  for (std::size_t size = 0; size + 2 < text.size(); ++size)
    EXPECT_FALSE(importWallText(std::string_view(text).substr(0, size), "s.json").ok()) << size;
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (const char damage : {'\0', '{', '"', '9', '-', 'e', '\xff'}) {
      std::string damaged = text;
      damaged[i] = damage;
      const Result<ImportedWall> wall = importWallText(damaged, "s.json");
      if (wall) {
        EXPECT_TRUE(Json::accept(wall->json, true)) << i;
      }
    }
  }
}

}  // namespace
}  // namespace tessera
