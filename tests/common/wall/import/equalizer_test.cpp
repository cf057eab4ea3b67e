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

const char* const kTwoWindows = R"(#Equalizer 1.1 ascii
global { EQ_CONFIG_FATTR_EYE_BASE 0.06 }
server
{
  connection { hostname "127.0.0.1" }
  config
  {
    appNode
    {
      connection { hostname "north" }
      pipe
      {
        window { name "l" viewport [ 100 50 480 300 ] channel { name "c1" } }
      }
    }
    node
    {
      connection { hostname "south" }
      pipe
      {
        viewport [ 0 0 1000 800 ]
        window { viewport [ .25 .5 .5 .25 ] channel { name "c2" viewport [ 0 0 .5 1 ] }
                                            channel { name "c3" viewport [ 250 0 250 100 ] } }
      }
    }
    observer {}
    layout { name "one" view { observer 0 } }
    canvas
    {
      layout "one"
      wall { bottom_left [ -2 0 -1 ] bottom_right [ 2 0 -1 ] top_left [ -2 1 -1 ] }
      segment { channel "c1" viewport [ 0 0 .5 1 ] }
      segment { channel "c2" viewport [ .5 .5 .25 .5 ] }
      segment { name "low" channel "c3" viewport [ .75 0 .25 .25 ] }
    }
  }
}
)";

TEST(ImportEqualizer, placesSegmentsOnTheCanvasWall) {
  const Json wall = imported(kTwoWindows, "dir/two.walls.eqc");
  EXPECT_EQ(wall["name"], "two.walls");
  ASSERT_EQ(wall["screens"].size(), 1u);
  const Json& screen = wall["screens"][0];
  expectPoint(screen["corners_m"]["lower_left"], -2, 0, -1);
  expectPoint(screen["corners_m"]["lower_right"], 2, 0, -1);
  expectPoint(screen["corners_m"]["upper_left"], -2, 1, -1);
  ASSERT_EQ(screen["tiles"].size(), 3u);
  const Json& c1 = screen["tiles"][0];
  EXPECT_EQ(c1["name"], "c1");
  EXPECT_EQ(c1["host"], "north");
  EXPECT_EQ(c1["px"], Json({480, 300}));
  EXPECT_EQ(c1["window_px"], Json({100, 50}));
  expectPair(c1["at_mm"], 0, 0);
  expectPair(c1["size_mm"], 2000, 1000);
  // The window is 500 x 200 at (250, 400) of the pipe; the channel's y counts from the window's bottom.
  const Json& c2 = screen["tiles"][1];
  EXPECT_EQ(c2["host"], "south");
  EXPECT_EQ(c2["px"], Json({250, 200}));
  EXPECT_EQ(c2["window_px"], Json({250, 400}));
  expectPair(c2["at_mm"], 2000, 0);
  expectPair(c2["size_mm"], 1000, 500);
  const Json& c3 = screen["tiles"][2];
  EXPECT_EQ(c3["name"], "low");
  EXPECT_EQ(c3["px"], Json({250, 100}));
  EXPECT_EQ(c3["window_px"], Json({500, 500}));
  expectPair(c3["at_mm"], 3000, 750);
  expectPoint(wall["observer"]["eye_m"], 0, 0, 0);
  EXPECT_FALSE(wall["observer"].contains("stereo"));
}

TEST(ImportEqualizer, assumesPixelsWhereNoneAreSaid) {
  const std::string text = with(kTwoWindows, "viewport [ 100 50 480 300 ]", "");
  const Json wall = imported(text, "a.eqc");
  EXPECT_EQ(wall["screens"][0]["tiles"][0]["px"], Json({1920, 1080}));
  EXPECT_FALSE(wall["screens"][0]["tiles"][0].contains("window_px"));
  EXPECT_TRUE(contains(warningsOf(text, "a.eqc"), "a.eqc:13: channel without a size in pixels: "))
      << warningsOf(text, "a.eqc");
  EXPECT_FALSE(contains(warningsOf(kTwoWindows, "a.eqc"), "without a size"));
}

TEST(ImportEqualizer, fullScreenWindowsFillTheirDisplay) {
  const std::string full = with(kTwoWindows, "global {", "global { EQ_WINDOW_IATTR_HINT_FULLSCREEN ON ");
  const Json wall = imported(full, "a.eqc");
  EXPECT_EQ(wall["screens"][0]["tiles"][0]["px"], Json({1920, 1080}));
  EXPECT_EQ(wall["screens"][0]["tiles"][1]["px"], Json({500, 800})) << "half of the pipe's 1000 x 800";
  const std::string but =
      with(full, "window { name \"l\"", "window { attributes { hint_fullscreen OFF } name \"l\"");
  EXPECT_EQ(imported(but, "a.eqc")["screens"][0]["tiles"][0]["px"], Json({480, 300}));
}

TEST(ImportEqualizer, everySegmentMayHaveItsOwnWall) {
  const std::string text =
      with(kTwoWindows, "segment { channel \"c1\" viewport [ 0 0 .5 1 ] }",
           "segment { channel \"c1\" viewport [ 0 0 .5 1 ]"
           " wall { bottom_left [ -2 0 1 ] bottom_right [ -2 0 -1 ] top_left [ -2 1 1 ] } }");
  const Json wall = imported(text, "a.eqc");
  ASSERT_EQ(wall["screens"].size(), 2u);
  EXPECT_EQ(wall["screens"][0]["tiles"].size(), 2u);
  const Json& own = wall["screens"][1];
  EXPECT_EQ(own["name"], "c1");
  expectPoint(own["corners_m"]["lower_right"], -2, 0, -1);
  ASSERT_EQ(own["tiles"].size(), 1u);
  expectPair(own["tiles"][0]["size_mm"], 2000, 1000);
}

TEST(ImportEqualizer, emptyWallIsEqualizersOwn) {
  const std::string text =
      with(kTwoWindows, "wall { bottom_left [ -2 0 -1 ] bottom_right [ 2 0 -1 ] top_left [ -2 1 -1 ] }",
           "wall {}");
  const Json corners = imported(text, "a.eqc")["screens"][0]["corners_m"];
  expectPoint(corners["lower_left"], -0.8, -0.5, -1);
  expectPoint(corners["lower_right"], 0.8, -0.5, -1);
  expectPoint(corners["upper_left"], -0.8, 0.5, -1);
}

std::string projected(const std::string& fields) {
  return with(kTwoWindows, "wall { bottom_left [ -2 0 -1 ] bottom_right [ 2 0 -1 ] top_left [ -2 1 -1 ] }",
              "projection { " + fields + " }");
}

// Equalizer puts the surface at origin + distance * (its z axis, turned) and, as the eye is behind it, draws
// as if it were turned half around the eye: straight ahead for a heading of 0, to the left for a positive
// one.
TEST(ImportEqualizer, projectionsBecomeCorners) {
  const double half = 3 * std::tan(27 * M_PI / 180), high = 3 * std::tan(20 * M_PI / 180);
  const std::string ahead = projected("origin [ 0 0 0 ] distance 3 fov [ 54 40 ] hpr [ 0 0 0 ]");
  Json corners = imported(ahead, "a.eqc")["screens"][0]["corners_m"];
  expectPoint(corners["lower_left"], -half, -high, -3);
  expectPoint(corners["lower_right"], half, -high, -3);
  expectPoint(corners["upper_left"], -half, high, -3);
  EXPECT_TRUE(contains(warningsOf(ahead, "a.eqc"), "faces away from the eye"));

  corners = imported(projected("origin [ 0 0 0 ] distance 3 fov [ 54 40 ] hpr [ 90 0 0 ]"),
                     "a.eqc")["screens"][0]["corners_m"];
  expectPoint(corners["lower_left"], -3, -high, half);
  expectPoint(corners["lower_right"], -3, -high, -half);
  expectPoint(corners["upper_left"], -3, high, half);

  // Behind the eye by its origin: the surface faces the eye as it is.
  const std::string behind = projected("origin [ 0 0 -5 ] distance 3 fov [ 54 40 ] hpr [ 0 0 0 ]");
  corners = imported(behind, "a.eqc")["screens"][0]["corners_m"];
  expectPoint(corners["lower_left"], -half, -high, -2);
  EXPECT_FALSE(contains(warningsOf(behind, "a.eqc"), "faces away from the eye"));
}

TEST(ImportEqualizer, turnsByPitchAndRollAreTheMatrixOfEqualizer) {
  // Origin far before the eye, so that the corners stand as Equalizer's own matrix puts them.
  const double h = 30 * M_PI / 180, p = 20 * M_PI / 180, r = 10 * M_PI / 180;
  const double w = 2 * std::tan(15 * M_PI / 180), v = 2 * std::tan(10 * M_PI / 180);
  const double cosH = std::cos(h), sinH = std::sin(h), cosP = std::cos(p), sinP = std::sin(p),
               cosR = std::cos(r), sinR = std::sin(r);
  const Json corners = imported(projected("origin [ 0 0 -20 ] distance 2 fov [ 30 20 ] hpr [ 30 20 10 ]"),
                                "a.eqc")["screens"][0]["corners_m"];
  const double x[3] = {cosH * cosR, -cosH * sinR, -sinH};
  const double y[3] = {-sinP * sinH * cosR + cosP * sinR, sinP * sinH * sinR + cosP * cosR, -sinP * cosH};
  const double z[3] = {cosP * sinH * cosR + sinP * sinR, -cosP * sinH * sinR + sinP * cosR, cosP * cosH};
  const auto at = [&](double a, double b, int i) {
    return a * x[i] + b * y[i] + 2 * z[i] + (i == 2 ? -20 : 0);
  };
  expectPoint(corners["lower_left"], at(-w, -v, 0), at(-w, -v, 1), at(-w, -v, 2));
  expectPoint(corners["lower_right"], at(w, -v, 0), at(w, -v, 1), at(w, -v, 2));
  // The upper left corner is squared up; the matrix is not exactly one of a rotation in Equalizer either.
  EXPECT_NEAR(corners["upper_left"][1].get<double>(), at(-w, v, 1), 2e-2);
}

TEST(ImportEqualizer, headMountedWallsAreSaidToStandStill) {
  const std::string text = with(kTwoWindows, "wall { bottom_left", "wall { type HMD bottom_left");
  EXPECT_TRUE(contains(warningsOf(text, "a.eqc"), "a.eqc:31: wall of the type HMD: moves with the head"))
      << warningsOf(text, "a.eqc");
  EXPECT_EQ(imported(text, "a.eqc")["screens"].size(), 1u);
}

TEST(ImportEqualizer, eyesOfTheObserver) {
  const std::string stereo = with(kTwoWindows, "view { observer 0 }", "view { mode STEREO observer 0 }");
  Json observer = imported(stereo, "a.eqc")["observer"];
  EXPECT_EQ(observer["stereo"]["mode"], "quad-buffer");
  EXPECT_NEAR(observer["stereo"]["separation_mm"], 60, 1e-9);

  const std::string base = with(with(stereo, "global { EQ_CONFIG_FATTR_EYE_BASE 0.06 }", ""), "config\n  {",
                                "config\n  { attributes { eye_base 0.07 }");
  EXPECT_NEAR(imported(base, "a.eqc")["observer"]["stereo"]["separation_mm"], 70, 1e-9);

  const std::string eyes =
      with(stereo, "observer {}",
           "observer { eye_left [ -0.04 1.5 1 ] eye_right [ 0.04 1.5 1 ] vrpn_tracker \"t@h\" }");
  observer = imported(eyes, "a.eqc")["observer"];
  expectPoint(observer["eye_m"], 0, 1.5, 1);
  EXPECT_NEAR(observer["stereo"]["separation_mm"], 80, 1e-9);
  EXPECT_TRUE(contains(warningsOf(eyes, "a.eqc"), "vrpn_tracker of an observer"));
}

TEST(ImportEqualizer, segmentsForSingleEyesBecomeStereoTiles) {
  std::string text = with(kTwoWindows, "view { observer 0 }", "view { mode STEREO observer 0 }");
  text = with(text, "segment { channel \"c1\"", "segment { eye [ LEFT CYCLOP ] channel \"c1\"");
  text = with(text, "segment { channel \"c2\"", "segment { eye [ RIGHT ] channel \"c2\"");
  std::string middle = with(text, "segment { name \"low\"", "segment { eye [ CYCLOP ] name \"low\"");
  Json wall = imported(middle, "a.eqc");
  ASSERT_EQ(wall["screens"][0]["tiles"].size(), 2u);
  EXPECT_EQ(wall["screens"][0]["tiles"][0]["eye"], "left");
  EXPECT_EQ(wall["screens"][0]["tiles"][1]["eye"], "right");
  EXPECT_EQ(wall["observer"]["stereo"]["mode"], "tiles");
  EXPECT_TRUE(contains(warningsOf(middle, "a.eqc"), "a.eqc:34: segment for the middle eye: "));
  // One that shows both becomes the left eye's, for tiles show one eye each.
  wall = imported(text, "a.eqc");
  EXPECT_EQ(wall["screens"][0]["tiles"][2]["eye"], "left");
  EXPECT_TRUE(contains(warningsOf(text, "a.eqc"), "picture for both eyes"));
  // Without a view in stereo the segments of single eyes are off.
  const std::string mono = with(text, "mode STEREO", "mode MONO");
  wall = imported(mono, "a.eqc");
  EXPECT_EQ(wall["screens"][0]["tiles"].size(), 2u);
  EXPECT_FALSE(wall["observer"].contains("stereo"));
  EXPECT_TRUE(contains(warningsOf(mono, "a.eqc"), "segment for single eyes"));
}

TEST(ImportEqualizer, namesWhatIsNoWallWithCountAndFirstLine) {
  const std::string text = with(kTwoWindows, "  }\n}\n",
                                "  compound {\n channel ( segment 0 view 0 )\n load_equalizer { mode 2D }\n"
                                " compound { channel \"c1\" range [ 0 .5 ] outputframe { name \"f\" } }\n"
                                " compound { eye [ LEFT ] }\n wall {} }\n  }\n}\n");
  const std::string warnings = warningsOf(text, "a.eqc");
  EXPECT_TRUE(contains(warnings, "a.eqc:36: compound (3 times): ")) << warnings;
  EXPECT_TRUE(contains(warnings, "a.eqc:38: load_equalizer: ")) << warnings;
  EXPECT_TRUE(contains(warnings, "a.eqc:39: outputframe: ")) << warnings;
  EXPECT_TRUE(contains(warnings, "a.eqc:41: wall of a compound: ")) << warnings;
  EXPECT_TRUE(contains(warnings, "a.eqc:5: connection of the server: ")) << warnings;
}

TEST(ImportEqualizer, namesLayoutsViewsAndUnusedChannels) {
  std::string text =
      with(kTwoWindows, "layout \"one\"", "layout \"one\" layout \"two\" layout OFF swapbarrier {}");
  text = with(text, "view { observer 0 }",
              "view { viewport [ 0 0 .5 1 ] wall {} attributes { deflect_host \"h\" } }");
  text = with(text, "segment { channel \"c2\" viewport [ .5 .5 .25 .5 ] }", "");
  const std::string warnings = warningsOf(text, "a.eqc");
  for (const char* kind : {":30: further layout of a canvas (2 times): ", "viewport of a view: ",
                           "wall of a view: ", "attribute of a view (deflect_host): ",
                           "channel that no segment of a canvas shows: ", "swapbarrier of a canvas: "})
    EXPECT_TRUE(contains(warnings, kind)) << kind << '\n' << warnings;
}

TEST(ImportEqualizer, saysWhereAnErrorIs) {
  EXPECT_EQ(errorOf(with(kTwoWindows, "[ 100 50 480 300 ]", "[ 100 50 480 ]"), "a.eqc")
                .rfind("a.eqc:13: \"viewport\"", 0),
            0u);
  EXPECT_TRUE(
      contains(errorOf(with(kTwoWindows, "segment { channel \"c2\"", "segment { channel \"c9\""), "a.eqc"),
               "a.eqc:33: no window has a channel named \"c9\""));
  EXPECT_TRUE(contains(errorOf(with(kTwoWindows, "top_left [ -2 1 -1 ]", "top_left [ 2 1 -1 ]"), "a.eqc"),
                       "rectangle"));
  EXPECT_TRUE(contains(errorOf(with(kTwoWindows, "top_left [ -2 1 -1 ]", "top_left [ -2 0 -1 ]"), "a.eqc"),
                       "smaller than a millimetre"));
  EXPECT_TRUE(
      contains(errorOf(with(kTwoWindows, ".75 0 .25 .25", ".75 0 .5 .25"), "a.eqc"), "edge of the screen"));
  EXPECT_TRUE(
      contains(errorOf(with(kTwoWindows, ".75 0 .25 .25", ".75 0 1e-7 .25"), "a.eqc"), "no possible size"));
  EXPECT_TRUE(contains(errorOf(projected("fov [ 54 40 ]"), "a.eqc"), "needs a distance"));
  EXPECT_TRUE(contains(errorOf("#Equalizer\nserver { config { appNode { } } }", "a.eqc"), "no canvas"));
  EXPECT_TRUE(contains(errorOf("server { }", "a.eqc"), "no config"));
  EXPECT_TRUE(
      contains(errorOf("server { config { observer {} }", "a.eqc"), "\"server\" that begins on line 1"));
  EXPECT_TRUE(
      contains(errorOf("config { canvas { wall \"x }\n", "a.eqc"), "a.eqc:1: the quotes are not closed"));
  EXPECT_TRUE(contains(errorOf("config { canvas }", "a.eqc"), "\"canvas\" has no value"));
  EXPECT_TRUE(contains(errorOf("config { } }", "a.eqc"), "closes nothing"));
  EXPECT_TRUE(contains(errorOf("config { a [ 1 2 { ] }", "a.eqc"), "is not closed with ]"));
  EXPECT_TRUE(contains(errorOf("config { a 1e999 }", "a.eqc"), "no number"));
  EXPECT_TRUE(contains(errorOf("config {\n ; }", "a.eqc"), "a.eqc:2: the character with the code 59"));
}

TEST(ImportEqualizer, boundsNesting) {
  std::string text = "config { ";
  for (int i = 0; i < 40; ++i)
    text += "compound { ";
  EXPECT_TRUE(contains(errorOf(text, "a.eqc"), "nested deeper than 32"));
  std::string endless;
  for (int i = 0; i < 200'000; ++i)
    endless += "a{";
  EXPECT_TRUE(contains(errorOf("config{" + endless, "a.eqc"), "nested deeper than 32"));
}

TEST(ImportEqualizer, everyTruncationIsAnErrorOrAWall) {
  const std::string text = kTwoWindows;
  int walls = 0;
  for (std::size_t size = 0; size < text.size(); ++size) {
    const Result<ImportedWall> wall = importWallText(std::string_view(text).substr(0, size), "a.eqc");
    if (wall) {
      ++walls;
      EXPECT_TRUE(Json::accept(wall->json, true));
    } else {
      EXPECT_FALSE(wall.error().what.empty());
    }
  }
  EXPECT_LE(walls, 1) << "only the closing line break may be missing";
}

TEST(ImportEqualizer, everyDamagedByteIsAnErrorOrAWall) {
  const std::string text = kTwoWindows;
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (const char damage : {'\0', '{', '}', '[', '"', '9', '\xff', '#'}) {
      std::string damaged = text;
      damaged[i] = damage;
      const Result<ImportedWall> wall = importWallText(damaged, "a.eqc");
      if (wall) {
        EXPECT_TRUE(Json::accept(wall->json, true)) << i;
      }
    }
  }
}

}  // namespace
}  // namespace tessera
