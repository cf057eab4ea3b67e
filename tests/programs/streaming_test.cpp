// Geometry on its way to whole walls: caches that are too small, boxes for what is late, disks that remember.

#include <cstdint>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/image/picture.h"
#include "tests/support/process.h"

namespace tessera::test {
namespace {

using std::chrono::seconds;
using Json = nlohmann::json;

constexpr int kFrames = 40;

/// What the tiles of a run say together.
struct Sums {
  std::uint64_t evictions = 0, hits = 0, misses = 0, geometryBytes = 0, diskHits = 0, lacked = 0, missed = 0;
  std::uint64_t missingLeaves = 0, missingPx = 0;
};

class Streaming : public ::testing::Test {
 protected:
  void SetUp() override {
    const Outcome made =
        run({program("tessera"), "scene", "make", "city", "--leaves", "3000", "--out", scene_}, seconds(60));
    ASSERT_EQ(made.status, 0) << made.err;
  }

  Json fly(const std::string& out, const std::vector<std::string>& more,
           const std::string& surface = "none") {
    std::vector<std::string> arguments = {program("tessera"),
                                          "run",
                                          "--wall",
                                          wall_,
                                          "--scene",
                                          scene_,
                                          "--camera",
                                          config("fly.camera.json"),
                                          "--frames",
                                          std::to_string(kFrames),
                                          "--surface",
                                          surface,
                                          "--out",
                                          folder_ / out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    if (surface == "none") arguments.emplace_back("--no-pictures");
    const Outcome outcome = run(arguments, seconds(120));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    said_ = outcome.err;
    std::ifstream in(folder_ / (out + "/report.json"));
    return Json::parse(in);
  }

  static Sums sumsOf(const Json& report) {
    Sums sums;
    for (const auto& [name, tile] : report.at("tiles").items()) {
      sums.evictions += tile.at("cache_evictions").get<std::uint64_t>();
      sums.hits += tile.at("cache_hits").get<std::uint64_t>();
      sums.misses += tile.at("cache_misses").get<std::uint64_t>();
      sums.geometryBytes += tile.at("received_geometry_bytes").get<std::uint64_t>();
      sums.diskHits += tile.at("disk_hits").get<std::uint64_t>();
      sums.lacked += tile.at("disk_lacked").get<std::uint64_t>();
      sums.missed += tile.at("frames_missed").get<std::uint64_t>();
      sums.missingLeaves += tile.at("missing_leaves").get<std::uint64_t>();
      sums.missingPx += tile.at("missing_px").get<std::uint64_t>();
    }
    return sums;
  }

  void expectSamePictures(const std::string& a, const std::string& b) {
    for (int frame = 1; frame <= kFrames; ++frame) {
      char name[32];
      std::snprintf(name, sizeof name, "/frame-%06d.png", frame);
      const auto first = readPng(folder_ / (a + name)), second = readPng(folder_ / (b + name));
      ASSERT_TRUE(first && second) << name;
      const auto difference = compare(*first, *second);
      ASSERT_TRUE(difference);
      EXPECT_EQ(difference->differing, 0U) << name;
    }
  }

  TemporaryFolder folder_;
  std::string scene_ = folder_ / "city.glb";
  std::string wall_ = folder_.write("2x2.json", R"({"grid": {"columns": 2, "rows": 2, "tile_px": [120, 80]},
                                                    "camera": {"fov_y_deg": 50}})");
  std::string said_;
};

TEST_F(Streaming, ASmallCacheChangesNoPicture) {
  const Json roomy = fly("roomy", {}, "offscreen");
  EXPECT_EQ(sumsOf(roomy).evictions, 0U);
  EXPECT_EQ(roomy.at("frames_incomplete"), 0);
  std::uint64_t most = 0;
  for (const auto& [name, tile] : roomy.at("tiles").items())
    most = std::max(most, tile.at("received_geometry_bytes").get<std::uint64_t>());
  const Json tight = fly("tight", {"--cache", std::to_string(most * 6 / 10)}, "offscreen");
  EXPECT_GT(sumsOf(tight).evictions, 0U);
  EXPECT_EQ(sumsOf(tight).missed, 0U);
  EXPECT_EQ(tight.at("frames_incomplete"), 0) << said_;
  expectSamePictures("roomy", "tight");
}

TEST_F(Streaming, ACacheBelowOneFramesNeedIsSaidOnceAndDrawsWhatItHolds) {
  const Json report = fly("tiny", {"--cache", "30KB"});
  EXPECT_EQ(report.at("frames"), kFrames);
  EXPECT_EQ(sumsOf(report).missed, 0U);
  EXPECT_GT(report.at("frames_incomplete"), 0);
  EXPECT_GT(sumsOf(report).missingLeaves, 0U);
  std::size_t lines = 0;
  for (std::size_t at = said_.find("holds less than one frame needs"); at != std::string::npos;
       at = said_.find("holds less than one frame needs", at + 1))
    ++lines;
  EXPECT_GE(lines, 1U) << said_;
  EXPECT_LE(lines, 4U) << "once for each tile";
}

TEST_F(Streaming, BoxesStandForWhatIsLateAndOnlyForThat) {
  const Json starved =
      fly("box", {"--on-miss", "box", "--upload-budget", "2KB", "--predict", "0"}, "offscreen");
  const Sums sums = sumsOf(starved);
  EXPECT_GT(starved.at("frames_incomplete"), 0);
  EXPECT_GT(sums.missingPx, 0U);
  EXPECT_EQ(sums.missed, 0U);
  const Json fed = fly("fed", {"--on-miss", "box", "--upload-budget", "1GB"}, "offscreen");
  EXPECT_EQ(fed.at("frames_incomplete"), 0);
  fly("waited", {}, "offscreen");
  expectSamePictures("fed", "waited");
  // A box is not nothing: what is left out looks otherwise.
  fly("skip", {"--on-miss", "skip", "--upload-budget", "2KB", "--predict", "0"}, "offscreen");
  const auto boxes = readPng(folder_ / "box/frame-000002.png");
  const auto gaps = readPng(folder_ / "skip/frame-000002.png");
  ASSERT_TRUE(boxes && gaps);
  EXPECT_GT(compare(*boxes, *gaps)->differing, 0U);
}

TEST_F(Streaming, GeometrySentAheadIsThereWhenItIsNeeded) {
  const Sums with = sumsOf(fly("ahead", {"--upload-budget", "1GB"}));
  const Sums without = sumsOf(fly("late", {"--predict", "0"}));
  EXPECT_LT(with.misses, without.misses);
}

TEST_F(Streaming, ADiskThatRemembersSavesTheWay) {
  const std::vector<std::string> disk = {"--disk-cache", "1GB", "--cache-dir", folder_ / "disk"};
  const Sums first = sumsOf(fly("first", disk));
  EXPECT_EQ(first.diskHits, 0U);
  const Json again = fly("second", disk);
  const Sums second = sumsOf(again);
  EXPECT_GT(second.diskHits, 0U);
  EXPECT_EQ(second.lacked, 0U);
  EXPECT_LT(second.geometryBytes, first.geometryBytes);
  EXPECT_EQ(again.at("sent_bytes_per_frame").at("geometry").at("max"), 0) << "records alone are sent";
}

TEST_F(Streaming, ADamagedDiskCostsTimeAlone) {
  const std::vector<std::string> disk = {"--disk-cache", "1GB", "--cache-dir", folder_ / "disk"};
  fly("first", disk, "offscreen");
  std::size_t damaged = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "disk")) {
    if (entry.path().extension() != ".pack") continue;
    std::fstream pack(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
    // Somewhere among the records, not in the catalogue at the end.
    for (std::uintmax_t at = 200; at + 40'000 < entry.file_size(); at += 20'000) {
      pack.seekp(static_cast<std::streamoff>(at));
      pack.write("damage", 6);
      ++damaged;
    }
  }
  ASSERT_GT(damaged, 0U);
  const Json second = fly("second", disk, "offscreen");
  EXPECT_GT(sumsOf(second).lacked, 0U);
  EXPECT_EQ(sumsOf(second).missed, 0U);
  // The last frame comes long after all that lacked was sent again.
  const auto before = readPng(folder_ / "first/frame-000040.png");
  const auto after = readPng(folder_ / "second/frame-000040.png");
  ASSERT_TRUE(before && after);
  EXPECT_EQ(compare(*before, *after)->differing, 0U);
}

}  // namespace
}  // namespace tessera::test
