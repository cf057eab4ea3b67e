// tessera cull and tessera bench: every algorithm, bound, hierarchy and switch from the command line, judged
// by the audit; lists in one id space; the papers' figures.
#include <algorithm>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/image/picture.h"
#include "tests/programs/small_scene.h"
#include "tests/support/process.h"

namespace tessera::test {
namespace {

using std::chrono::seconds;
using Json = nlohmann::json;

Json readJson(const std::string& file) {
  std::ifstream in(file);
  return Json::parse(in);
}

class CullingTools : public ::testing::Test {
 protected:
  void SetUp() override {
    const Outcome made =
        run({program("tessera"), "scene", "make", "powerplant", "--triangles", "120000", "--out", scene_});
    ASSERT_EQ(made.status, 0) << made.err;
  }
  Outcome cull(std::vector<std::string> more) {
    std::vector<std::string> command = {program("tessera"), "cull", "--wall",   config("wall-4x4.json"),
                                        "--scene",          scene_, "--camera", config("fly.camera.json"),
                                        "--frames",         "3"};
    command.insert(command.end(), more.begin(), more.end());
    return run(command, seconds(60));
  }
  TemporaryFolder folder_;
  std::string scene_ = folder_ / "plant.glb";
};

TEST_F(CullingTools, AuditFindsNoDropWhateverIsChosen) {
  using Words = std::vector<std::string>;
  for (const Words& choice :
       {Words{"--algorithm", "naive"}, Words{"--algorithm", "oh", "--octant-test", "--plane-coherency"},
        Words{"--algorithm", "fh", "--bounds", "sphere"}, Words{"--regroup", "--regroup-from", "4"},
        Words{"--algorithm", "adaptive-listing", "--bounds", "aabb", "--sign-table"},
        Words{"--bounds", "aabb-then-obb"}, Words{"--bounds", "hybrid", "--sphere-first"},
        Words{"--hierarchy", "bvh", "--mtpl", "40"}, Words{"--hierarchy", "octree"},
        Words{"--planes", "matrix"}, Words{"--hierarchy", "loose-octree", "--motion-coherence"},
        Words{"--hierarchy", "kd", "--no-plane-masking"}, Words{"--hierarchy", "graph", "--mtpl", "30"}}) {
    Words words = choice;
    words.insert(words.end(), {"--audit", "--json", folder_ / "cull.json"});
    const Outcome outcome = cull(words);
    ASSERT_EQ(outcome.status, 0) << choice[1] << ": " << outcome.err;
    const Json report = readJson(folder_ / "cull.json");
    EXPECT_EQ(report["audit"]["drops"], 0) << choice[1];
    EXPECT_GT(report["audit"]["exact_pairs"], 1000) << choice[1];
    EXPECT_GE(report["audit"]["pairs"], report["audit"]["exact_pairs"]) << choice[1];
    EXPECT_GT(report["tests_by_kind"]["against_bisections"].get<double>() +
                  report["tests_by_kind"]["against_tiles"].get<double>(),
              0)
        << choice[1];
  }
}

/// All leaf-tile pairs of the first frame in order, and the number of leaves in the header.
std::pair<std::vector<int>, int> listed(const std::string& file) {
  std::ifstream in(file);
  std::string header, frame;
  std::getline(in, header);
  std::getline(in, frame);
  std::vector<int> leaves;
  const Json tiles = Json::parse(frame)["tiles"];
  int base = 0;  // leaf ids of the n-th tile count from n million, so that pairs are compared
  for (const auto& [name, tile] : tiles.items()) {
    for (const Json& range : tile["visible"]) {
      for (int leaf = range[0]; leaf < range[1]; ++leaf)
        leaves.push_back(base + leaf);
    }
    base += 1'000'000;
  }
  return {leaves, Json::parse(header)["leaves"]};
}

TEST_F(CullingTools, ListsAreInTheIdsOfTheGraphOnEveryHierarchy) {
  ASSERT_EQ(cull({"--lists", folder_ / "graph"}).status, 0);
  const auto [expected, count] = listed(folder_ / "graph");
  ASSERT_EQ(count, 3919);
  ASSERT_GT(expected.size(), 1000U);
  for (const char* kind : {"bvh", "octree", "loose-octree", "kd"}) {
    ASSERT_EQ(cull({"--lists", folder_ / "other", "--hierarchy", kind}).status, 0);
    const auto [leaves, others] = listed(folder_ / "other");
    EXPECT_EQ(others, 3919);
    std::vector<int> differing;
    std::set_symmetric_difference(leaves.begin(), leaves.end(), expected.begin(), expected.end(),
                                  std::back_inserter(differing));
    EXPECT_LT(differing.size(), expected.size() / 50) << kind;
  }
  // A leaf is listed once, however many of its parts are.
  ASSERT_EQ(cull({"--lists", folder_ / "cut", "--mtpl", "10"}).status, 0);
  const auto [leaves, others] = listed(folder_ / "cut");
  EXPECT_EQ(others, 3919);
  EXPECT_LE(leaves.size(), expected.size());
}

TEST_F(CullingTools, RefusesWhatDoesNotGoTogether) {
  for (const std::vector<std::string>& words : {std::vector<std::string>{"--sign-table"},
                                                {"--algorithm", "fast"},
                                                {"--bounds", "convex"},
                                                {"--hierarchy", "heap"},
                                                {"--algorithm", "oh", "--regroup"},
                                                {"--bounds", "sphere", "--sphere-first"}}) {
    const Outcome outcome = cull(words);
    EXPECT_EQ(outcome.status, 2) << words[0];
    EXPECT_NE(outcome.err.find("tessera: error: "), std::string::npos) << outcome.err;
  }
}

TEST_F(CullingTools, BenchCullMeasuresEveryMethodAgainstAdaptive) {
  const Outcome outcome = run(
      {program("tessera"), "bench", "cull", "--wall", config("wall-4x4.json"), "--scene", scene_, "--camera",
       config("fly.camera.json"), "--frames", "4", "--audited-frames", "2", "--json", folder_ / "bench.json"},
      seconds(60));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Json report = readJson(folder_ / "bench.json");
  EXPECT_EQ(report["audited_drops"], 0);
  EXPECT_GT(report["camera_step"]["degrees_per_frame"], 0);
  ASSERT_GE(report["candidates"].size(), 13U);
  for (const Json& candidate : report["candidates"]) {
    EXPECT_GT(candidate["us"]["p50"], 0);
    EXPECT_GE(candidate["excess_percent"], 0);
  }
  EXPECT_EQ(report["candidates"][0]["time_ratio"]["p50"], 1);
}

TEST_F(CullingTools, BenchPapersWritesEveryFigure) {
  const Outcome outcome =
      run({program("tessera"), "bench", "papers", "--out", folder_ / "papers", "--frame-scale", "0.001",
           "--only", "methods,tiles,dynamic,regroup,mtpl,optimizations,excess,bound"},
          seconds(240));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* name :
       {"methods", "tiles", "dynamic", "regroup", "mtpl", "optimizations", "excess", "bound"}) {
    const Json figure = readJson(folder_ / "papers/" + name + ".json");
    EXPECT_EQ(figure["figure"], name);
  }
  EXPECT_EQ(readJson(folder_ / "papers/dynamic.json")["points"].size(), 11U);
}

// Another hierarchy and cut meshes change what is sent, not what is seen.
TEST_F(CullingTools, AWallShowsTheSameWithAnotherHierarchyAndCutMeshes) {
  const auto runWith = [&](const std::string& out, std::vector<std::string> more) {
    std::vector<std::string> command = {program("tessera"),
                                        "run",
                                        "--wall",
                                        config("wall-2x2.json"),
                                        "--scene",
                                        scene_,
                                        "--frames",
                                        "2",
                                        "--out",
                                        folder_ / out};
    command.insert(command.end(), more.begin(), more.end());
    return run(command, seconds(120));
  };
  ASSERT_EQ(runWith("graph", {}).status, 0);
  const Outcome other = runWith("bvh", {"--hierarchy", "bvh", "--mtpl", "40"});
  ASSERT_EQ(other.status, 0) << other.err;
  const auto a = readPng(folder_ / "graph/frame-000002.png"), b = readPng(folder_ / "bvh/frame-000002.png");
  ASSERT_TRUE(a) << a.error().text();
  ASSERT_TRUE(b) << b.error().text();
  const auto difference = compare(*a, *b);
  ASSERT_TRUE(difference);
  // The order in which coinciding surfaces are drawn differs.
  EXPECT_LT(difference->differing, 300U);
}

}  // namespace
}  // namespace tessera::test
