// What is wrong with a file or a flag is said in one line, with the exit status of a wrong input.

#include <algorithm>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/programs/small_scene.h"
#include "tests/support/process.h"

namespace tessera::test {
namespace {

using std::chrono::seconds;

/// Lines of standard error that are the error itself; warnings and notes may stand before it.
std::vector<std::string> errorLines(const Outcome& outcome) {
  std::vector<std::string> lines;
  std::istringstream in(outcome.err);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("tessera: error: ") || line.starts_with("tessera-tile: error: "))
      lines.push_back(line);
  }
  return lines;
}

void expectInputError(const Outcome& outcome, const std::string& says) {
  EXPECT_EQ(outcome.status, 2) << outcome.err;
  const auto lines = errorLines(outcome);
  ASSERT_EQ(lines.size(), 1U) << outcome.err;
  EXPECT_NE(lines[0].find(says), std::string::npos) << lines[0];
}

class BadInput : public ::testing::Test {
 protected:
  Outcome check(const std::string& wall, const std::string& scene) {
    return run({program("tessera"), "check", "--wall", wall, "--scene", scene}, seconds(20));
  }
  Outcome runWall(const std::string& wall, const std::string& scene) {
    return run({program("tessera"), "run", "--wall", wall, "--scene", scene, "--frames", "1", "--out",
                folder_ / "out"},
               seconds(20));
  }
  TemporaryFolder folder_;
  std::string goodWall_ = folder_.write("wall.json", smallWall());
  std::string goodScene_ = folder_.write("scene.obj", smallScene());
};

TEST_F(BadInput, GoodFilesPass) {
  const Outcome outcome = check(goodWall_, goodScene_);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("2 triangles"), std::string::npos) << outcome.out;
}

TEST_F(BadInput, SceneFiles) {
  expectInputError(runWall(goodWall_, folder_ / "none.glb"), "no such file");
  expectInputError(runWall(goodWall_, folder_ / "none.obj"), "no such file");
  expectInputError(check(goodWall_, folder_.write("empty.glb", "")), "empty.glb");
  expectInputError(check(goodWall_, folder_.write("empty.osgt", "")), "is empty");
  expectInputError(check(goodWall_, folder_.write("odd.xyzzy", "hello")), "no reader");
  expectInputError(check(goodWall_, folder_.write("text.glb", "this is no glTF")), "text.glb");
  expectInputError(check(goodWall_, folder_.write("list.gltf", "[1, 2, 3]")), "list.gltf");
  expectInputError(
      check(goodWall_,
            folder_.write("nothing.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": []}]})")),
      "nothing to draw");
  expectInputError(check(goodWall_, folder_.path()), "");
}

TEST_F(BadInput, NumbersThatAreNone) {
  expectInputError(check(goodWall_, folder_.write("nan.obj", smallScene("nan"))), "not a finite number");
  expectInputError(check(goodWall_, folder_.write("inf.obj", smallScene("inf"))), "not a finite number");
  const std::string matrix =
      R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"name": "crooked", "matrix":
    [1e999,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]})";
  expectInputError(check(goodWall_, folder_.write("matrix.gltf", matrix)), "matrix.gltf");
}

TEST_F(BadInput, WallFiles) {
  expectInputError(runWall(folder_ / "none.json", goodScene_), "no such file");
  expectInputError(runWall(folder_.write("w1.json", ""), goodScene_), "w1.json:1");
  expectInputError(runWall(folder_.write("w2.json", "{\n\"grid\": {\n\"columns\": 2,"), goodScene_),
                   "w2.json:3");
  expectInputError(runWall(folder_.write("w3.json", R"({"grid": "2x2"})"), goodScene_), "w3.json:1");
  expectInputError(
      runWall(folder_.write("w4.json", R"({"grid": {"columns": 0, "rows": 2, "tile_px": [64, 48]}})"),
              goodScene_),
      "columns");
  expectInputError(runWall(folder_.write("w5.json", R"({"grid": {"columns": 2, "rows": 1, "tile_px": [64, 48],
    "names": [["a", "a"]]}})"),
                           goodScene_),
                   "w5.json:2");
  expectInputError(
      runWall(folder_.write("w6.json", R"({"grid": {"colums": 2, "rows": 1, "tile_px": [64, 48]}})"),
              goodScene_),
      "columns");
}

TEST_F(BadInput, Flags) {
  const auto tessera = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), program("tessera"));
    return run(arguments, seconds(20));
  };
  expectInputError(tessera({}), "command line");
  expectInputError(tessera({"run"}), "--wall");
  expectInputError(tessera({"run", "--wall", goodWall_, "--scene", goodScene_, "--frames", "0"}), "frames");
  expectInputError(tessera({"run", "--wall", goodWall_, "--scene", goodScene_, "--algorithm", "fastest"}),
                   "fastest");
  expectInputError(tessera({"cull", "--wall", goodWall_, "--scene", goodScene_, "--bounds", "hull"}), "hull");
  expectInputError(
      tessera({"cull", "--wall", goodWall_, "--scene", goodScene_, "--camera", folder_ / "no.json"}),
      "no such file");
  expectInputError(tessera({"serve", "--wall", goodWall_, "--scene", goodScene_, "--listen", "here"}),
                   "HOST:PORT");
  expectInputError(tessera({"scene", "make", "powerplant", "--triangles", "1", "--out", folder_ / "x.glb"}),
                   "triangles");
  EXPECT_FALSE(std::ifstream(folder_ / "x.glb").good()) << "half an output is left";
  expectInputError(run({program("tessera-tile"), "--connect", "nowhere", "--tile", "r0c0"}, seconds(20)),
                   "HOST:PORT");
  expectInputError(run({program("tessera-tile"), "--tile", "r0c0"}, seconds(20)), "--connect");
}

TEST_F(BadInput, OutputThatCannotBeWritten) {
  const Outcome outcome = run({program("tessera"), "cull", "--wall", goodWall_, "--scene", goodScene_,
                               "--frames", "1", "--lists", "/nowhere/at/all/lists.jsonl"},
                              seconds(20));
  EXPECT_NE(outcome.status, 0);
  EXPECT_EQ(errorLines(outcome).size(), 1U) << outcome.err;
}

}  // namespace
}  // namespace tessera::test
