// A wall whose scene is played: tiles show the same moment, and the one that it should be.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/image/picture.h"
#include "tests/support/process.h"

namespace tessera::test {
namespace {

using std::chrono::seconds;

constexpr const char* kStandingCamera = R"({"space": "scene", "keyframes": [
  {"time_s": 0, "eye": [0.9, 0.7, 2.2], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y_deg": 50},
  {"time_s": 1, "eye": [0.9, 0.7, 2.2], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y_deg": 50}]})";

struct Case {
  const char* name;
  const char* scene;
  friend void PrintTo(const Case& test, std::ostream* out) { *out << test.name; }
};

class PlayedWall : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    scene_ = sharedScene(GetParam().scene);
    if (scene_.empty()) GTEST_SKIP() << "the folder ../shared/scenes is not there";
    wall_ = folder_.write("2x2.json", R"({"grid": {"columns": 2, "rows": 2, "tile_px": [240, 160]}})");
    camera_ = folder_.write("standing.camera.json", kStandingCamera);
  }

  void draw(const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        program("tessera"), "run", "--wall", wall_,         "--scene",         scene_, "--camera", camera_,
        "--frames",         "4",   "--out",  folder_ / out, "--animation-fps", "3"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run(arguments, seconds(100));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }

  PictureDifference between(const std::string& a, int frameA, const std::string& b, int frameB) {
    const auto fileOf = [&](const std::string& out, int frame) {
      return folder_ / (out + "/frame-00000" + std::to_string(frame) + ".png");
    };
    const auto first = readPng(fileOf(a, frameA)), second = readPng(fileOf(b, frameB));
    EXPECT_TRUE(first && second);
    if (!first || !second) return {};
    const auto difference = compare(*first, *second);
    EXPECT_TRUE(difference);
    return difference ? *difference : PictureDifference{};
  }

  TemporaryFolder folder_;
  std::string scene_, wall_, camera_;
};

TEST_P(PlayedWall, EqualsTheUntiledPictureOfTheSameMoment) {
  draw("tiled", {"--animate"});
  draw("whole", {"--animate", "--untiled", "--algorithm", "none"});
  for (int frame = 1; frame <= 4; ++frame) {
    const auto difference = between("tiled", frame, "whole", frame);
    EXPECT_LE(static_cast<double>(difference.differing), 0.0005 * static_cast<double>(difference.pixels))
        << "frame " << frame;
    EXPECT_LE(difference.differingMuch, 10U) << "frame " << frame;
  }
  EXPECT_GT(between("tiled", 1, "tiled", 4).differing, 50U) << "the scene stands still";
  std::ifstream in(folder_ / "tiled/report.json");
  const auto report = nlohmann::json::parse(in);
  EXPECT_EQ(report.at("mode").at("animate"), true);
  EXPECT_GT(report.at("sent_bytes_per_frame").at("poses").at("max"), 0);
}

TEST_P(PlayedWall, RunsAreRepeatableAndStandStillWithoutTheFlag) {
  draw("first", {"--animate"});
  draw("second", {"--animate"});
  draw("still", {});
  for (int frame = 1; frame <= 4; ++frame)
    EXPECT_EQ(between("first", frame, "second", frame).differing, 0U) << "frame " << frame;
  EXPECT_EQ(between("still", 1, "still", 4).differing, 0U);
}

TEST_P(PlayedWall, StepsOfHalfAMillimetreAreHardlySeen) {
  draw("exact", {"--animate"});
  draw("steps", {"--animate", "--quantize-motion", "0.0005"});
  for (int frame = 1; frame <= 4; ++frame) {
    const auto difference = between("exact", frame, "steps", frame);
    EXPECT_LE(difference.differingMuch, difference.pixels / 200) << "frame " << frame;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, PlayedWall,
                         ::testing::Values(Case{"man", "models/CesiumMan.glb"},
                                           Case{"cube", "models/AnimatedMorphCube/AnimatedMorphCube.gltf"},
                                           Case{"nodes",
                                                "models/parent_inverse_anim/06_parent-inverse-anim.gltf"},
                                           Case{"clock", "osg/clock.osgt"}),
                         [](const auto& test) { return test.param.name; });

/// Squares in a row, triangles from afar, as OpenSceneGraph writes them.
std::string levelsOfDetail() {
  int id = 1;
  const auto open = [&id](const std::string& name) {
    return name + " {\n UniqueID " + std::to_string(id++) + "\n";
  };
  const auto level = [&](int x, int corners) {
    std::string text = open("osg::Geode") + "Drawables 1 {\n" + open("osg::Geometry") +
                       "PrimitiveSetList 1 {\n" + open("osg::DrawArrays") + "Mode TRIANGLE_STRIP\n Count " +
                       std::to_string(corners) + "\n }\n }\n VertexArray TRUE {\n" + open("osg::Vec3Array") +
                       "Binding BIND_PER_VERTEX\n vector " + std::to_string(corners) + " {\n";
    for (int i = 0; i < corners; ++i)
      text += std::to_string(x + i % 2) + " " + std::to_string(i / 2) + " 0\n";
    return text + "}\n }\n }\n }\n }\n }\n";
  };
  std::string text = "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n\n" + open("osg::Group") +
                     "Children 6 {\n";
  for (int i = 0; i < 6; ++i) {
    text += open("osg::LOD") + "Children 2 {\n" + level(4 * i, 4) + level(4 * i, 3) +
            "}\n RangeList 2 {\n 0 30\n 30 10000\n }\n }\n";
  }
  return text + "}\n }\n";
}

TEST(LevelsOfDetail, AreTheSameOnAllTiles) {
  const TemporaryFolder folder;
  const std::string scene = folder.write("levels.osgt", levelsOfDetail());
  const std::string wall =
      folder.write("2x2.json", R"({"grid": {"columns": 2, "rows": 2, "tile_px": [60, 40]}})");
  // From inside to far away.
  const std::string camera = folder.write("away.camera.json", R"({"space": "scene", "keyframes": [
    {"time_s": 0, "eye": [0.1, 0.1, 0.3], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y_deg": 60},
    {"time_s": 1, "eye": [2, 1, 4], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y_deg": 60}]})");
  const auto listsOf = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {program("tessera"), "cull", "--wall",   wall,
                                          "--scene",          scene,  "--camera", camera,
                                          "--frames",         "12",   "--lists",  folder / name};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run(arguments, seconds(60));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::vector<std::set<std::uint32_t>> frames;
    std::ifstream in(folder / name);
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
      std::set<std::uint32_t>& leaves = frames.emplace_back();
      const auto parsed = nlohmann::json::parse(line);
      for (const auto& [tile, entry] : parsed.at("tiles").items()) {
        for (const auto& range : entry.at("visible")) {
          for (std::uint32_t leaf = range[0]; leaf < range[1].get<std::uint32_t>(); ++leaf)
            leaves.insert(leaf);
        }
      }
    }
    return frames;
  };
  // What is there is the same for a wall of tiles as for one, whatever is culled.
  const auto all = listsOf("all", {"--untiled", "--algorithm", "none"});
  const auto tiled = listsOf("tiled", {"--algorithm", "none"}), culled = listsOf("culled", {});
  ASSERT_EQ(all.size(), 12U);
  EXPECT_EQ(all, tiled);
  std::size_t mixed = 0;
  for (const auto& leaves : all) {
    EXPECT_EQ(leaves.size(), 6U) << "one level of each";
    const auto fine =
        std::count_if(leaves.begin(), leaves.end(), [](std::uint32_t leaf) { return leaf % 2 == 0; });
    mixed += fine > 0 && fine < 6 ? 1 : 0;
  }
  EXPECT_EQ(all.front(), (std::set<std::uint32_t>{0, 2, 4, 6, 8, 10})) << "near";
  EXPECT_EQ(all.back(), (std::set<std::uint32_t>{1, 3, 5, 7, 9, 11})) << "far";
  EXPECT_GT(mixed, 0U);
  for (std::size_t frame = 0; frame < all.size(); ++frame) {
    EXPECT_TRUE(
        std::includes(all[frame].begin(), all[frame].end(), culled[frame].begin(), culled[frame].end()));
  }
}

TEST(Animate, AnAuditOfAPlayedSceneIsRefused) {
  const TemporaryFolder folder;
  const std::string scene = sharedScene("models/CesiumMan.glb");
  if (scene.empty()) GTEST_SKIP() << "the folder ../shared/scenes is not there";
  const std::string wall =
      folder.write("1.json", R"({"grid": {"columns": 1, "rows": 1, "tile_px": [60, 40]}})");
  const Outcome outcome = run(
      {program("tessera"), "cull", "--wall", wall, "--scene", scene, "--animate", "--audit"}, seconds(60));
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("--audit"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace tessera::test
