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
        Words{"--algorithm", "fh", "--bounds", "sphere"},
        Words{"--algorithm", "adaptive", "--regroup", "--regroup-from", "4"},
        Words{"--algorithm", "adaptive-listing", "--bounds", "aabb", "--sign-table"},
        Words{"--bounds", "aabb-then-obb"}, Words{"--bounds", "hybrid", "--sphere-first"},
        Words{"--hierarchy", "bvh", "--mtpl", "40"}, Words{"--hierarchy", "octree"},
        Words{"--planes", "matrix"}, Words{"--hierarchy", "loose-octree", "--motion-coherence"},
        Words{"--hierarchy", "kd", "--no-plane-masking"}, Words{"--hierarchy", "graph", "--mtpl", "30"},
        Words{"--algorithm", "footprint"}, Words{"--algorithm", "table", "--bounds", "aabb"},
        Words{"--algorithm", "table", "--coherent", "always", "--bounds", "hybrid"},
        Words{"--algorithm", "footprint", "--no-refine", "--hierarchy", "bvh"}}) {
    Words words = choice;
    words.insert(words.end(), {"--audit", "--json", folder_ / "cull.json"});
    const Outcome outcome = cull(words);
    ASSERT_EQ(outcome.status, 0) << choice[1] << ": " << outcome.err;
    const Json report = readJson(folder_ / "cull.json");
    EXPECT_EQ(report["audit"]["drops"], 0) << choice[1];
    EXPECT_GT(report["audit"]["exact_pairs"], 1000) << choice[1];
    EXPECT_GE(report["audit"]["pairs"], report["audit"]["exact_pairs"]) << choice[1];
    const std::string picked = report["picked"];
    const bool hasPlanes = picked != "footprint" && picked != "table";
    EXPECT_EQ(report["tests_by_kind"]["against_bisections"].get<double>() +
                      report["tests_by_kind"]["against_tiles"].get<double>() >
                  0,
              hasPlanes)
        << choice[1];
    // A switch of plane tests is never without effect.
    const bool asksForPlanes = std::any_of(words.begin(), words.end(), [](const std::string& word) {
      return word == "matrix" || word == "--sphere-first" || word == "--motion-coherence" ||
             word == "--no-plane-masking" || word == "aabb-then-obb";
    });
    if (asksForPlanes) {
      EXPECT_TRUE(hasPlanes) << choice[1];
    }
  }
}

TEST_F(CullingTools, InstructionSetIsForcedByTheEnvironment) {
  const auto run = [&](const char* name, std::vector<std::string> words) {
    ::setenv("TESSERA_SIMD", name, 1);
    words.insert(words.end(), {"--json", folder_ / "simd.json"});
    Outcome outcome = cull(words);
    ::unsetenv("TESSERA_SIMD");
    return outcome;
  };
  ASSERT_EQ(run("", {}).status, 0);
  const Json best = readJson(folder_ / "simd.json");
  ASSERT_EQ(run("scalar", {}).status, 0);
  const Json scalar = readJson(folder_ / "simd.json");
  EXPECT_EQ(scalar["simd"], "scalar");
  EXPECT_EQ(scalar["picked"], "footprint");
  EXPECT_EQ(scalar["lists_hash"], best["lists_hash"]);
  const Outcome wrong = run("mmx", {});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_NE(wrong.err.find("TESSERA_SIMD"), std::string::npos) << wrong.err;
  EXPECT_EQ(std::count(wrong.err.begin(), wrong.err.end(), '\n'), 1) << wrong.err;
}

TEST_F(CullingTools, FootprintsRefuseSwitchesOfPlanes) {
  using Words = std::vector<std::string>;
  for (const Words& words : {Words{"--algorithm", "table", "--planes", "matrix"},
                             Words{"--algorithm", "footprint", "--octant-test"},
                             Words{"--algorithm", "footprint", "--bounds", "sphere"}}) {
    const Outcome outcome = cull(words);
    EXPECT_EQ(outcome.status, 2) << words.back();
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
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

class BenchCull : public CullingTools {
 protected:
  Outcome bench(std::vector<std::string> more) {
    std::vector<std::string> command = {program("tessera"),        "bench",    "cull", "--wall",
                                        config("wall-4x4.json"),   "--scene",  scene_, "--camera",
                                        config("fly.camera.json"), "--frames", "4",    "--json",
                                        folder_ / "bench.json"};
    command.insert(command.end(), more.begin(), more.end());
    return run(command, seconds(120));
  }
  Json report() { return readJson(folder_ / "bench.json"); }
};

const Json& candidate(const Json& report, const std::string& name) {
  static const Json kNone;
  for (const Json& one : report["candidates"]) {
    if (one["name"] == name) return one;
  }
  ADD_FAILURE() << name << " is not among the candidates";
  return kNone;
}

TEST_F(BenchCull, MeasuresEveryMethodAgainstAdaptive) {
  const Outcome outcome = bench({"--audited-frames", "2"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Json all = report();
  EXPECT_EQ(all["audited_drops"], 0);
  EXPECT_EQ(all["audited_frames"], 2);
  EXPECT_EQ(all["compared_frames"], 4);
  EXPECT_GT(all["camera_step"]["degrees_per_frame"], 0);
  const double exact = all["audited_exact_pairs"];
  EXPECT_GT(exact, 1000);
  ASSERT_GE(all["candidates"].size(), 30U);
  for (const Json& one : all["candidates"]) {
    EXPECT_GT(one["us"]["p50"], 0) << one["name"];
    EXPECT_GT(one["time_ratio_to_oh"]["p50"], 0) << one["name"];
    EXPECT_GT(one["time_ratio_to_linear_read"]["p50"], 0) << one["name"];
    if (one["output"] == "count") continue;
    EXPECT_EQ(one["audited_drops"], 0) << one["name"];
    EXPECT_GE(one["audited_pairs"], exact) << one["name"];
    EXPECT_NEAR(one["excess_percent"], 100 * (one["audited_pairs"].get<double>() / exact - 1), 1e-6)
        << one["name"];
  }
  EXPECT_EQ(all["candidates"][0]["name"], "adaptive obb");
  EXPECT_EQ(all["candidates"][0]["time_ratio"]["p50"], 1);
  EXPECT_EQ(candidate(all, "oh obb")["time_ratio_to_oh"]["p50"], 1);
}

TEST_F(BenchCull, EveryFormOfOutputHasTheSameLists) {
  ASSERT_EQ(bench({"--audited-frames", "0", "--only", "footprint,table,auto"}).status, 0);
  const Json all = report();
  for (const char* name : {"footprint obb ids", "footprint obb diff", "table obb ranges", "table obb diff",
                           "table obb coherent-always diff", "table obb coherent-measured diff"}) {
    EXPECT_EQ(candidate(all, name)["compared_lists_hash"],
              candidate(all, "footprint obb ranges")["compared_lists_hash"])
        << name;
    EXPECT_EQ(candidate(all, name)["pairs_per_frame"],
              candidate(all, "footprint obb ranges")["pairs_per_frame"])
        << name;
  }
  EXPECT_EQ(candidate(all, "footprint obb ids")["output"], "ids");
  EXPECT_EQ(candidate(all, "footprint obb diff")["output"], "diff");
  EXPECT_FALSE(candidate(all, "footprint obb diff").contains("lists_hash"));
  EXPECT_FALSE(candidate(all, "footprint obb diff").contains("excess_percent"));
}

TEST_F(BenchCull, OnlyWhatIsAskedForAndTheBaseIsMeasured) {
  ASSERT_EQ(bench({"--only", "table obb diff,adaptive aabb-then"}).status, 0);
  std::vector<std::string> names;
  const Json all = report();
  for (const Json& one : all["candidates"])
    names.push_back(one["name"]);
  EXPECT_EQ(names, (std::vector<std::string>{"adaptive obb", "adaptive aabb-then-obb", "table obb diff"}));
}

TEST_F(BenchCull, ANameThatIsNoCandidateIsOneError) {
  for (const char* only : {"adaptive,quick", "naive obb bvh"}) {
    const Outcome outcome = bench({"--only", only});
    EXPECT_EQ(outcome.status, 2) << only;
    EXPECT_EQ(outcome.err.find("tessera: error: --only: no candidate's name begins with \""), 0U)
        << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  // A candidate that was left out by another flag is none.
  EXPECT_EQ(bench({"--only", "adaptive obb bvh"}).status, 0);
  EXPECT_EQ(bench({"--only", "adaptive obb bvh", "--no-hierarchies"}).status, 2);
}

TEST_F(BenchCull, OpenSceneGraphPassesWhatIsVisible) {
  ASSERT_EQ(bench({"--audited-frames", "4", "--only", "osg"}).status, 0);
  const Json all = report();
  const double exact = all["audited_exact_pairs"], pairs = candidate(all, "osg full")["audited_pairs"];
  EXPECT_GE(pairs, exact);
  EXPECT_LE(pairs, 1.5 * exact);  // it did cull
  EXPECT_EQ(candidate(all, "osg traversal-only")["audited_pairs"], pairs);
}

TEST_F(BenchCull, ExponentsTellHowTimeGrowsWithTiles) {
  const Outcome outcome = bench({"--exponents", "tiles"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Json tiles = report()["exponents"]["tiles"];
  EXPECT_FALSE(report()["exponents"].contains("objects"));
  ASSERT_GE(tiles["methods"].size(), 6U);
  for (const Json& method : tiles["methods"]) {
    ASSERT_EQ(method["points"].size(), 6U);
    EXPECT_EQ(method["points"][5]["tiles"], 1024);
    for (const Json& point : method["points"])
      EXPECT_GT(point["us"]["p50"], 0) << method["name"];
    EXPECT_TRUE(method["slope"].is_number()) << method["name"];
    if (method["name"] == "oh obb") {  // once for each tile: certainly grows
      EXPECT_GT(method["slope"], 0.3);
      EXPECT_LT(method["slope"], 1.2);
    }
  }
}

TEST_F(BenchCull, ExponentsTellHowTimeGrowsWithObjects) {
  ASSERT_EQ(bench({"--exponents", "objects", "--most-leaves", "10000", "--out", folder_ / "cities"}).status,
            0);
  const Json objects = report()["exponents"]["objects"];
  ASSERT_EQ(objects["methods"][0]["points"].size(), 2U);
  EXPECT_EQ(objects["methods"][0]["points"][1]["leaves"], 10'000);
  EXPECT_TRUE(std::ifstream(folder_ / "cities/city-1000.glb").good());
}

TEST_F(BenchCull, TargetsAreMeasuredAndJudged) {
  const Outcome outcome =
      run({program("tessera"), "bench", "targets", "--out", folder_ / "targets", "--only", "P", "--runs", "2",
           "--frame-scale", "0.001", "--json", folder_ / "targets.json"},
          seconds(120));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  std::size_t judged = 0;
  const Json targets = readJson(folder_ / "targets.json");
  for (const Json& figure : targets["figures"]) {
    ASSERT_EQ(figure["measured"].size(), 2U) << figure["name"];
    if (!figure.contains("target")) continue;
    ++judged;
    const double measured = figure["measured"][1], target = figure["target"];
    EXPECT_EQ(figure["met"][1], figure["bound"] == "at least" ? measured >= target : measured <= target)
        << figure["name"];
  }
  EXPECT_GE(judged, 14U);
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
