// A wall stitched from its tiles against the same wall drawn as one picture with nothing culled.

#include <array>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <random>
#include <set>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/image/picture.h"
#include "tests/support/process.h"

namespace tessera::test {
namespace {

using std::chrono::seconds;

struct Case {
  const char* name;
  const char* scene;  ///< "made:KIND" is made by the program
  const char* camera;
  /// Pixels that may differ by more than 8/255. A vertex may land one subpixel (1/256) aside, as window
  /// coordinates are floats whose origin differs from tile to tile; that flips single pixels on edges, so
  /// scenes of very many thin things have more of them.
  std::size_t differingMuch = 10;

  friend void PrintTo(const Case& test, std::ostream* out) { *out << test.name; }
};

class StitchedWall : public ::testing::TestWithParam<Case> {
 protected:
  /// The scene's path; empty: it is not there.
  std::string scene() {
    const std::string name = GetParam().scene;
    if (name != "made:powerplant") return sharedScene(name);
    const std::string path = folder_ / "powerplant.glb";
    const Outcome made =
        run({program("tessera"), "scene", "make", "powerplant", "--triangles", "200000", "--out", path},
            seconds(60));
    EXPECT_EQ(made.status, 0) << made.err;
    return path;
  }

  std::vector<std::string> runArguments(const std::string& scene, const std::string& wall,
                                        const std::string& out) {
    return {program("tessera"),        "run",      "--wall", wall,    "--scene", scene, "--camera",
            config(GetParam().camera), "--frames", "3",      "--out", out};
  }

  void compareWall(const std::string& scene, const std::string& wall, const std::string& name) {
    const std::string tiled = folder_ / ("tiled-" + name), whole = folder_ / ("whole-" + name);
    const Outcome a = run(runArguments(scene, wall, tiled), seconds(100));
    ASSERT_EQ(a.status, 0) << a.err;
    std::vector<std::string> reference = runArguments(scene, wall, whole);
    reference.insert(reference.end(), {"--untiled", "--algorithm", "none"});
    const Outcome b = run(reference, seconds(100));
    ASSERT_EQ(b.status, 0) << b.err;
    for (int frame = 1; frame <= 3; ++frame) {
      const std::string file = "/frame-00000" + std::to_string(frame) + ".png";
      const auto stitched = readPng(tiled + file), expected = readPng(whole + file);
      ASSERT_TRUE(stitched) << stitched.error().text();
      ASSERT_TRUE(expected) << expected.error().text();
      const auto difference = compare(*stitched, *expected);
      ASSERT_TRUE(difference) << difference.error().text();
      EXPECT_LE(static_cast<double>(difference->differing), 0.0005 * static_cast<double>(difference->pixels))
          << GetParam().name << " " << name << " frame " << frame;
      EXPECT_LE(difference->differingMuch, GetParam().differingMuch)
          << GetParam().name << " " << name << " frame " << frame;
      EXPECT_GT(differentColours(*expected), 8U) << "the reference shows nothing";
    }
    std::ifstream in(tiled + "/report.json");
    const auto report = nlohmann::json::parse(in);
    for (const auto& [tile, entry] : report.at("tiles").items())
      EXPECT_EQ(entry.at("frames_shown"), 3) << tile;
  }

  static std::size_t differentColours(const Picture& picture) {
    std::set<std::uint32_t> colours;
    for (std::size_t i = 0; i + 2 < picture.rgb.size(); i += 3) {
      colours.insert(std::uint32_t{picture.rgb[i]} << 16 | std::uint32_t{picture.rgb[i + 1]} << 8 |
                     picture.rgb[i + 2]);
    }
    return colours.size();
  }

  TemporaryFolder folder_;
};

TEST_P(StitchedWall, EqualsTheUntiledUnculledPicture) {
  const std::string path = scene();
  if (path.empty()) GTEST_SKIP() << "the folder ../shared/scenes is not there";
  compareWall(path,
              folder_.write("2x2.json", R"({"grid": {"columns": 2, "rows": 2, "tile_px": [480, 270]}})"),
              "2x2");
  compareWall(path,
              folder_.write("4x4.json", R"({"grid": {"columns": 4, "rows": 4, "tile_px": [200, 112]}})"),
              "4x4");
  compareWall(path,
              folder_.write("3x2.json", R"({"grid": {"columns": 3, "rows": 2, "tile_px": [256, 192]}})"),
              "3x2");
}

INSTANTIATE_TEST_SUITE_P(Scenes, StitchedWall,
                         ::testing::Values(Case{"munich", "city/munich.glb", "orbit.camera.json"},
                                           Case{"denhaag", "city/denhaag.glb", "orbit.camera.json"},
                                           Case{"delft", "city/delft.gltf", "orbit.camera.json"},
                                           Case{"engine", "models/2CylinderEngine.glb", "orbit.camera.json"},
                                           Case{"cow", "osg/cow.osgt", "orbit.camera.json"},
                                           Case{"billboards", "osg/lz.osgt", "orbit.camera.json"},
                                           Case{"powerplant", "made:powerplant", "orbit.camera.json", 60}),
                         [](const auto& test) { return test.param.name; });

/// A scene of 300 small triangles in a ball of radius 2, moved by `offset`; details of centimetres.
std::string scatteredTriangles(const TemporaryFolder& folder, const std::string& name, double offset) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::string bytes;
  for (int triangle = 0; triangle < 300; ++triangle) {
    const std::array<float, 3> middle = {2 * unit(random), 2 * unit(random), 2 * unit(random)};
    for (int corner = 0; corner < 3; ++corner) {
      for (const float m : middle) {
        const float x = m + 0.2F * unit(random);
        bytes.append(reinterpret_cast<const char*>(&x), sizeof x);
      }
    }
  }
  (void)folder.write(name + ".bin", bytes);
  std::ostringstream json;
  json.precision(17);
  json
      << R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"translation":[)" << offset
      << "," << -offset / 2 << "," << offset / 4
      << R"(]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
      << R"("buffers":[{"byteLength":)" << bytes.size() << R"(,"uri":")" << name << R"(.bin"}],)"
      << R"("bufferViews":[{"buffer":0,"byteLength":)" << bytes.size() << R"(}],)"
      << R"("accessors":[{"bufferView":0,"componentType":5126,"count":900,"type":"VEC3","min":[-2.2,-2.2,-2.2],"max":[2.2,2.2,2.2]}]})";
  return folder.write(name + ".gltf", json.str());
}

TEST(FarFromTheOrigin, ASceneLooksAsItDoesAtTheOrigin) {
  const TemporaryFolder folder;
  const std::string wall =
      folder.write("wall.json", R"({"grid": {"columns": 2, "rows": 1, "tile_px": [240, 240]}})");
  const auto draw = [&](const std::string& name, double offset) {
    const Outcome outcome =
        run({program("tessera"), "run", "--wall", wall, "--scene", scatteredTriangles(folder, name, offset),
             "--camera", config("orbit.camera.json"), "--frames", "4", "--out", folder / name},
            seconds(60));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
  };
  draw("near", 0);
  draw("far", 1e7);
  for (int frame = 1; frame <= 4; ++frame) {
    const std::string file = "/frame-00000" + std::to_string(frame) + ".png";
    const auto near = readPng(folder / "near" + file), far = readPng(folder / "far" + file);
    ASSERT_TRUE(near) << near.error().text();
    ASSERT_TRUE(far) << far.error().text();
    const auto difference = compare(*near, *far);
    ASSERT_TRUE(difference);
    // A nanometre of the camera's place is all that 1e7 m leaves to rounding.
    EXPECT_LE(difference->differing, difference->pixels / 1000) << "frame " << frame;
    EXPECT_LE(difference->differingMuch, 20U) << "frame " << frame;
  }
}

}  // namespace
}  // namespace tessera::test
