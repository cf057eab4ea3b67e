// Walls of every shape as whole programs: what they draw, put together true to scale.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "common/image/picture.h"
#include "common/wall/wall_file.h"
#include "common/wall/wall_picture.h"
#include "tests/support/mpcdi_archive.h"
#include "tests/support/process.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;

struct Rgb {
  int r, g, b;
};

Rgb at(const Picture& picture, int x, int y) {
  const std::size_t i = (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.widthPx) +
                         static_cast<std::size_t>(x)) *
                        3;
  return {picture.rgb[i], picture.rgb[i + 1], picture.rgb[i + 2]};
}

bool isBackground(const Rgb& c) {
  return std::abs(c.r - 153) < 3 && std::abs(c.g - 173) < 3 && std::abs(c.b - 194) < 3;
}

bool isBlack(const Rgb& c) {
  return c.r + c.g + c.b == 0;
}

/// Writes OBJ: y up, faces as they come.
class ObjFile {
 public:
  void quad(const std::array<std::array<double, 3>, 4>& corners) {
    for (const auto& c : corners)
      text_ << "v " << c[0] << ' ' << c[1] << ' ' << c[2] << '\n';
    text_ << "f " << next_ << ' ' << next_ + 1 << ' ' << next_ + 2 << '\n';
    text_ << "f " << next_ << ' ' << next_ + 2 << ' ' << next_ + 3 << '\n';
    next_ += 4;
  }
  [[nodiscard]] std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  int next_ = 1;
};

class Walls : public ::testing::Test {
 protected:
  Picture draw(const std::string& wall, const std::string& scene, const std::vector<std::string>& more = {}) {
    const std::string out = folder_ / ("out" + std::to_string(runs_++));
    std::vector<std::string> arguments = {program("tessera"), "run", "--wall", wall, "--scene", scene,
                                          "--frames",         "1",   "--out",  out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run(arguments, seconds(120));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    auto picture = readPng(out + "/frame-000001.png");
    EXPECT_TRUE(picture.ok()) << (picture ? "" : picture.error().text());
    return picture ? std::move(*picture) : Picture(1, 1);
  }

  /// Looking along -z from the origin.
  std::string camera() {
    return folder_.write("ahead.camera.json", R"({"space": "world", "keyframes": [
        {"time_s": 0, "eye": [0, 0, 0], "target": [0, 0, -1]}]})");
  }

  /// A bar that goes across the picture at a slant, and posts behind it.
  std::string barScene() {
    ObjFile obj;
    obj.quad({{{-40, -12, -30}, {40, 11, -30}, {40, 13, -30}, {-40, -10, -30}}});
    for (int i = -15; i <= 15; ++i) {
      const double x = 2.7 * i;
      obj.quad({{{x, -25, -40}, {x + 0.5, -25, -40}, {x + 0.5, 25, -40}, {x, 25, -40}}});
    }
    return folder_.write("bars.obj", obj.text());
  }

  TemporaryFolder folder_;
  int runs_ = 0;
};

TEST_F(Walls, aStraightLineStaysStraightAcrossBezels) {
  // 20 mm between panels are 10 pixels.
  const std::string wall =
      folder_.write("bezels.json", R"({"grid": {"columns": 3, "rows": 2, "tile_px": [160, 120],
      "tile_mm": [320, 240], "bezel_mm": 10}, "camera": {"fov_y_deg": 60}})");
  const std::string scene = barScene();
  const Picture tiled = draw(wall, scene, {"--camera", camera()});
  const Picture whole = draw(wall, scene, {"--camera", camera(), "--untiled", "--algorithm", "none"});
  ASSERT_EQ(tiled.widthPx, 3 * 160 + 2 * 10);
  ASSERT_EQ(tiled.heightPx, 2 * 120 + 10);
  ASSERT_EQ(whole.widthPx, tiled.widthPx);
  ASSERT_EQ(whole.heightPx, tiled.heightPx);
  std::size_t differing = 0, drawn = 0;
  for (int y = 0; y < tiled.heightPx; ++y) {
    for (int x = 0; x < tiled.widthPx; ++x) {
      const Rgb a = at(tiled, x, y), b = at(whole, x, y);
      if (x % 170 >= 160 || y % 130 >= 120) {
        ASSERT_TRUE(isBlack(a)) << x << ", " << y;
        continue;
      }
      drawn += isBackground(b) ? 0 : 1;
      differing += std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b) > 24 ? 1 : 0;
    }
  }
  EXPECT_GT(drawn, 5000U);
  EXPECT_LE(differing, 10U);
}

TEST_F(Walls, blendedOverlapsSumToThePictureWithoutThem) {
  const std::string text =
      R"({"grid": {"columns": 2, "rows": 2, "tile_px": [160, 120], "overlap_px": [40, 24],
      "tile": {"gamma": 2.2}}, "camera": {"fov_y_deg": 60}})";
  const std::string wall = folder_.write("blend.json", text);
  const std::string scene = barScene();
  const Picture tiled = draw(wall, scene, {"--camera", camera()});
  const Picture whole = draw(wall, scene, {"--camera", camera(), "--untiled", "--algorithm", "none"});
  ASSERT_EQ(tiled.widthPx, 280);
  ASSERT_EQ(tiled.heightPx, 216);
  const auto difference = compare(tiled, whole);
  ASSERT_TRUE(difference.ok());
  std::size_t beyond = 0, inOverlap = 0;
  for (std::size_t i = 0; i < tiled.rgb.size(); ++i)
    beyond += std::abs(int{tiled.rgb[i]} - int{whole.rgb[i]}) > 1 ? 1 : 0;
  for (int y = 0; y < tiled.heightPx; ++y) {
    for (int x = 120; x < 160; ++x)
      inOverlap += isBackground(at(whole, x, y)) ? 0 : 1;
  }
  EXPECT_GT(inOverlap, 500U);
  // Single pixels at silhouettes may flip from tile to tile, as on walls without blending.
  EXPECT_LE(beyond, 30U) << "largest " << difference->largest;
}

TEST_F(Walls, facesOfACaveMeetWithinAPixel) {
  // A ring about the eye, and a path that runs from under the viewer to the front.
  ObjFile obj;
  constexpr int kSegments = 360;
  for (int i = 0; i < kSegments; ++i) {
    const double a = 2 * std::numbers::pi * i / kSegments, b = 2 * std::numbers::pi * (i + 1) / kSegments;
    const auto p = [](double angle, double y) {
      return std::array<double, 3>{20 * std::sin(angle), y, -20 * std::cos(angle)};
    };
    obj.quad({p(a, 1), p(b, 1), p(b, 4), p(a, 4)});
  }
  obj.quad({{{0.4, -3, 2}, {1.2, -3, 2}, {1.2, -3, -15}, {0.4, -3, -15}}});
  const std::string scene = folder_.write("ring.obj", obj.text());
  const Picture net = draw(config("wall-cave-4.json"), scene, {"--camera", camera()});
  ASSERT_EQ(net.widthPx, 1200);
  ASSERT_EQ(net.heightPx, 800);
  const auto extentInColumn = [&](int x) {
    int first = -1, last = -1;
    for (int y = 0; y < 250; ++y) {
      if (isBackground(at(net, x, y))) continue;
      if (first < 0) first = y;
      last = y;
    }
    return std::pair(first, last);
  };
  for (const auto& [one, other] : {std::pair(399, 400), std::pair(799, 800)}) {
    const auto a = extentInColumn(one), b = extentInColumn(other);
    ASSERT_GE(a.first, 0);
    EXPECT_GT(a.second - a.first, 10);
    EXPECT_LE(std::abs(a.first - b.first), 1);
    EXPECT_LE(std::abs(a.second - b.second), 1);
  }
  const auto extentInRow = [&](int y) {
    int first = -1, last = -1;
    for (int x = 400; x < 800; ++x) {
      if (isBackground(at(net, x, y))) continue;
      if (first < 0) first = x;
      last = x;
    }
    return std::pair(first, last);
  };
  const auto front = extentInRow(399), floor = extentInRow(400);
  ASSERT_GE(front.first, 0);
  EXPECT_GT(front.second - front.first, 10);
  EXPECT_LE(std::abs(front.first - floor.first), 1);
  EXPECT_LE(std::abs(front.second - floor.second), 1);
}

TEST_F(Walls, turnedPanelsShowWhatUprightOnesShow) {
  const std::string scene = barScene();
  const std::string upright =
      R"({"grid": {"columns": 2, "rows": 1, "tile_px": [120, 160]}, "camera": {"fov_y_deg": 60}})";
  const Picture expected = draw(folder_.write("upright.json", upright), scene, {"--camera", camera()});
  for (const char* degrees : {"90", "180", "270"}) {
    const bool isSide = std::string(degrees) != "180";
    const std::string wall =
        folder_.write(std::string("turned") + degrees + ".json",
                      std::string(R"({"grid": {"columns": 2, "rows": 1, "tile_px": )") +
                          (isSide ? "[160, 120]" : "[120, 160]") + ", \"rotation_deg\": " + degrees +
                          R"(}, "camera": {"fov_y_deg": 60}})");
    const Picture turned = draw(wall, scene, {"--camera", camera()});
    const auto difference = compare(turned, expected);
    ASSERT_TRUE(difference.ok()) << difference.error().text();
    // The same pixels, but which of two an edge between them belongs to depends on the direction.
    EXPECT_LE(static_cast<double>(difference->differingMuch), 0.02 * static_cast<double>(difference->pixels))
        << degrees;
  }
}

TEST_F(Walls, everyShippedWallIsDrawn) {
  const std::string scene = folder_ / "plant.glb";
  ASSERT_EQ(run({program("tessera"), "scene", "make", "powerplant", "--triangles", "150000", "--out", scene},
                seconds(60))
                .status,
            0);
  constexpr std::size_t kMostDrawn = 20;  // a process for each
  std::size_t drawn = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(TESSERA_SOURCE_DIR) / "configs")) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("wall-") || !name.ends_with(".json")) continue;
    SCOPED_TRACE(name);
    const auto wall = readWallFile(entry.path());
    ASSERT_TRUE(wall.ok());
    if (wall->tiles.size() > kMostDrawn) {
      const Outcome outcome = run({program("tessera"), "run", "--wall", entry.path().string(), "--scene",
                                   scene, "--frames", "2", "--surface", "none", "--tiles-per-process", "0"},
                                  seconds(120));
      EXPECT_EQ(outcome.status, 0) << outcome.err;
      continue;
    }
    ++drawn;
    const WallPicture layout = wallPicture(*wall);
    const Picture picture = draw(entry.path().string(), scene, {"--camera", config("fly.camera.json")});
    ASSERT_EQ(picture.widthPx, layout.widthPx);
    ASSERT_EQ(picture.heightPx, layout.heightPx);
    // The middle of every tile shows something: the scene or the sky, but no hole.
    for (std::size_t t = 0; t < wall->tiles.size(); ++t) {
      const PicturePlace& place = layout.tiles[t];
      const Vec2 middle = place.corner + place.across * (wall->tiles[t].widthPx / 2.0) +
                          place.down * (wall->tiles[t].heightPx / 2.0);
      EXPECT_FALSE(isBlack(at(picture, static_cast<int>(middle.x()), static_cast<int>(middle.y()))))
          << wall->tiles[t].name;
    }
    std::set<int> reds;
    for (int y = 0; y < picture.heightPx; y += 5) {
      for (int x = 0; x < picture.widthPx; x += 5)
        reds.insert(at(picture, x, y).r);
    }
    EXPECT_GT(reds.size(), 20U);
  }
  EXPECT_GE(drawn, 11U);
}

TEST_F(Walls, cullingIsAuditedOnEveryShippedWall) {
  const std::string scene = folder_ / "city.glb";
  ASSERT_EQ(run({program("tessera"), "scene", "make", "city", "--leaves", "600", "--out", scene}, seconds(60))
                .status,
            0);
  for (const auto& entry : fs::directory_iterator(fs::path(TESSERA_SOURCE_DIR) / "configs")) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("wall-") || !name.ends_with(".json")) continue;
    const Outcome outcome = run({program("tessera"), "cull", "--wall", entry.path().string(), "--scene",
                                 scene, "--camera", config("fly.camera.json"), "--frames", "6", "--audit"},
                                seconds(120));
    EXPECT_EQ(outcome.status, 0) << name << outcome.err;
    EXPECT_NE(outcome.out.find(" 0 dropped"), std::string::npos) << name << outcome.out;
  }
}

/// A projector whose archive mirrors the picture and masks its left half.
TEST_F(Walls, warpsAndMasksOfMpcdiArriveOnTheTile) {
  const auto mirrored = [](int column, int row) {
    return Sample{1 - (static_cast<float>(column) + 0.5F) / 200, 1 - (static_cast<float>(row) + 0.5F) / 100,
                  0};
  };
  const auto rightHalf = [](int x, int, int) { return static_cast<std::uint16_t>(x < 100 ? 0 : 65535); };
  writeArchive(folder_ / "p.mpcdi", {{"mpcdi.xml", R"(<?xml version="1.0" encoding="UTF-8"?>
<MPCDI profile="2d" geometry="1" level="1" date="2026-01-01 00:00:00" version="1.0">
  <display><buffer id="front" Xresolution="200" Yresolution="100">
    <region id="p" Xresolution="200" Yresolution="100" x="0" y="0" xsize="1" ysize="1"/>
  </buffer></display>
  <files><fileset region="p">
    <geometryWarpFile><path>p.pfm</path><interpolation>linear</interpolation></geometryWarpFile>
    <alphaMap><path>p.png</path><componentDepth>1</componentDepth><bitDepth>16</bitDepth>
      <gammaEmbedded>1</gammaEmbedded></alphaMap>
  </fileset></files>
</MPCDI>)"},
                                     {"p.pfm", pfm(200, 100, mirrored)},
                                     {"p.png", png(200, 100, 1, 16, false, rightHalf)}});
  const std::string wall = folder_ / "imported.json";
  const Outcome imported = run({program("tessera"), "wall", "import", folder_ / "p.mpcdi", "--out", wall});
  ASSERT_EQ(imported.status, 0) << imported.err;
  const std::string scene = barScene();
  const Picture warped = draw(wall, scene, {"--camera", camera()});
  const Picture plain =
      draw(folder_.write("plain.json", R"({"grid": {"columns": 1, "rows": 1, "tile_px": [200, 100]}})"),
           scene, {"--camera", camera()});
  ASSERT_EQ(warped.widthPx, 200);
  ASSERT_EQ(warped.heightPx, 100);
  std::size_t scenePixels = 0;
  int largest = 0;
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 200; ++x) {
      const Rgb a = at(warped, x, y), b = at(plain, 199 - x, y);
      if (x < 100) {
        ASSERT_TRUE(isBlack(a)) << x << ", " << y;
        continue;
      }
      scenePixels += isBackground(b) ? 0 : 1;
      largest = std::max({largest, std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
    }
  }
  EXPECT_GT(scenePixels, 500U);
  EXPECT_LE(largest, 1);
}

TEST_F(Walls, newWallsAreMadeDrawnAndPrinted) {
  const std::string file = folder_ / "made.json", svg = folder_ / "made.svg";
  const Outcome made = run({program("tessera"), "wall", "make", "4x3", "--bezel", "12mm", "--tile",
                            "1920x1080", "--size", "1.21x0.68", "--out", file});
  ASSERT_EQ(made.status, 0) << made.err;
  const Outcome checked = run({program("tessera"), "check", "--wall", file, "--svg", svg});
  EXPECT_EQ(checked.status, 0) << checked.err;
  EXPECT_NE(checked.out.find("4 x 3 tiles of 1920 x 1080 pixels"), std::string::npos) << checked.out;
  EXPECT_TRUE(fs::exists(svg));
  const Outcome printed = run({program("tessera"), "check", "--wall", file, "--print-config", "--fov", "33"});
  EXPECT_EQ(printed.status, 0);
  EXPECT_NE(printed.out.find("\"gamma\": 2.2"), std::string::npos) << printed.out;
  EXPECT_NE(printed.out.find("\"fov_y_deg\": 33"), std::string::npos) << printed.out;
  // An environment variable beats the file, a flag beats both.
  const std::map<std::string, std::string> environment = {{"TESSERA_FOV", "44"}};
  EXPECT_NE(run({program("tessera"), "check", "--wall", file, "--print-config"}, seconds(10), environment)
                .out.find("\"fov_y_deg\": 44"),
            std::string::npos);
  for (const std::vector<std::string>& bad : {std::vector<std::string>{"4"},
                                              {"4x3", "--bezel", "-1mm"},
                                              {"4x3", "--bezel", "12mm"},
                                              {"4x3", "--size", "1"},
                                              {"0x3"},
                                              {"4x3", "--overlap", "1920x0"}}) {
    std::vector<std::string> arguments = {program("tessera"), "wall", "make"};
    arguments.insert(arguments.end(), bad.begin(), bad.end());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << bad.back() << outcome.out;
    EXPECT_NE(outcome.err.find("tessera: error:"), std::string::npos) << outcome.err;
  }
}

}  // namespace
}  // namespace tessera::test
