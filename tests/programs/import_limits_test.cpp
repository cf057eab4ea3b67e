// Imports that take too long or too much, disks that are full or may not be written, files that change
// meanwhile.

#include <atomic>
#include <thread>
#include <vector>

#include "tests/programs/import_fixture.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::seconds;

using ImportLimitsTest = ImportTest;

TEST_F(ImportLimitsTest, TimeIsUp) {
  const std::string scene = folder_.write("large.obj", largeScene());
  const auto start = std::chrono::steady_clock::now();
  expectEnd(import(scene, {"--import-timeout", "0.1"}), End::InputError,
            "within 0.1 s; give it longer with --import-timeout");
  EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(20));
  // Nothing half-done is taken for the scene.
  expectEnd(import(scene), End::Imported, "100000 triangles");
}

TEST_F(ImportLimitsTest, MemoryIsUp) {
  const std::string scene = folder_.write("large.obj", largeScene());
  for (const char* limit : {"1MB", "150MB", "200MB", "250MB", "300MB", "350MB", "400MB"}) {
    const Outcome outcome = import(scene, {"--import-memory", limit});
    // Programs with sanitizers have no limit.
    if (endOf(outcome) == End::Imported) {
      fs::remove_all(store_);
      continue;
    }
    expectEnd(outcome, End::InputError, "--import-memory");
  }
  expectEnd(import(scene), End::Imported, "100000 triangles");
}

TEST_F(ImportLimitsTest, AStoreThatCannotBeWritten) {
  const std::string scene = folder_.write("scene.obj", smallScene());
  store_ = folder_.write("file", "in the way");
  for (int start = 0; start < 2; ++start)
    expectEnd(import(scene), End::Imported, "a temporary folder is used");
  EXPECT_EQ(contentOf(folder_ / "file"), "in the way");
  EXPECT_EQ(show(scene).status, 0);
  store_ = "/proc/tessera-store";
  expectEnd(import(scene), End::Imported, "a temporary folder is used");
}

TEST_F(ImportLimitsTest, TemporaryFoldersGoWithTheProgram) {
  const std::string scene = folder_.write("scene.obj", smallScene());
  store_ = folder_.write("file", "in the way");
  fs::create_directory(folder_ / "tmp");
  const Outcome outcome = run(arguments(scene), seconds(60), {{"TMPDIR", folder_ / "tmp"}});
  expectEnd(outcome, End::Imported, folder_ / "tmp");
  EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
}

TEST_F(ImportLimitsTest, AFullDiskIsOneError) {
  const std::string scene = folder_.write("large.obj", largeScene(20'000));
  // In blocks of 1024 bytes: nothing, the lock files, a part of the pack.
  for (const char* blocks : {"0", "1", "16", "64"}) {
    SCOPED_TRACE(blocks);
    fs::remove_all(store_);
    const std::string command = std::string("(ulimit -f ") + blocks + " && exec '" + program("tessera") +
                                "' import '" + scene + "' --store '" + store_ +
                                "') 2>&1 | cat; exit ${PIPESTATUS[0]}";
    const Outcome outcome = run({"/bin/bash", "-c", command}, seconds(60));
    EXPECT_TRUE(outcome.status == 1 || outcome.status == 2) << outcome.status << outcome.out;
    std::size_t errors = 0;
    for (std::size_t at = 0; (at = outcome.out.find("tessera: error: ", at)) != std::string::npos; ++at)
      ++errors;
    EXPECT_EQ(errors, 1U) << outcome.out;
    EXPECT_EQ(outcome.out.find("crashed"), std::string::npos) << outcome.out;
    // With room, the same store is in order.
    expectEnd(import(scene), End::Imported, "20000 triangles");
    expectEnd(import(scene), End::InStore, "20000 triangles");
  }
}

TEST_F(ImportLimitsTest, ASceneThatGrowsMeanwhile) {
  const std::string scene = folder_.write("large.obj", largeScene(20'000));
  Process program(arguments(scene));
  std::atomic<bool> isOver = false;
  std::thread writer([&] {
    while (!isOver) {
      std::ofstream(scene, std::ios::app) << "f 1 2 3\n";
      std::this_thread::sleep_for(milliseconds(5));
    }
  });
  const Outcome outcome = program.wait(seconds(60));
  isOver = true;
  writer.join();
  expectEnd(outcome, End::InputError, "was changed while it was imported");
  expectEnd(import(scene), End::Imported);
}

constexpr int kManyTriangles = 20'000;

/// The vertices of triangles in a row, so far apart.
std::string rowBin(float distance) {
  std::vector<float> vertices;
  for (int i = 0; i < kManyTriangles; ++i) {
    const float x = distance * static_cast<float>(i);
    vertices.insert(vertices.end(), {x, 0, 0, x + 1, 0, 0, x, 1, 0});
  }
  return {reinterpret_cast<const char*>(vertices.data()), vertices.size() * sizeof(float)};
}

std::string rowScene() {
  const std::string bytes = std::to_string(kManyTriangles * 36);
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"uri": "row.bin",
    "byteLength": )" +
         bytes + R"(}], "bufferViews": [{"buffer": 0, "byteLength": )" + bytes +
         R"(}], "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": )" +
         std::to_string(kManyTriangles * 3) + R"(, "min": [0, 0, 0], "max": [100000, 1, 0]}]})";
}

TEST_F(ImportLimitsTest, AMixtureIsNeverKept) {
  const std::string scene = folder_.write("scene.gltf", rowScene());
  // Small leaves make the import last longer than the reading of the file.
  const std::vector<std::string> small = {"--hierarchy", "bvh", "--mtpl", "4"};
  const auto lists = [&](const std::string& store) {
    std::vector<std::string> all = {program("tessera"), "cull", "--wall",  wall_,
                                    "--scene",          scene,  "--store", store,
                                    "--frames",         "1",    "--lists", folder_ / "lists.jsonl"};
    all.insert(all.end(), small.begin(), small.end());
    const Outcome outcome = run(all, seconds(60));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return contentOf(folder_ / "lists.jsonl");
  };
  (void)folder_.write("row.bin", rowBin(2));
  const auto start = std::chrono::steady_clock::now();
  const std::string narrow = lists(folder_ / "narrow");
  const auto whole = std::chrono::duration_cast<milliseconds>(std::chrono::steady_clock::now() - start);
  overwrite(folder_ / "row.bin", rowBin(2.5F));
  const std::string wide = lists(folder_ / "wide");
  ASSERT_NE(narrow, wide);
  bool wasRefused = false;
  // More often where the machine was too slow or too quick to hit the moment.
  for (int turn = 0; turn < 6 || (!wasRefused && turn < 24); ++turn) {
    const int part = turn % 6;
    overwrite(folder_ / "row.bin", rowBin(2));
    (void)folder_.write("new.bin", rowBin(2.5F));
    fs::remove_all(store_);
    Process program(arguments(scene, small));
    std::this_thread::sleep_for(whole * part / 6);
    fs::rename(folder_ / "new.bin", folder_ / "row.bin");
    const Outcome outcome = program.wait(seconds(60));
    const End end = endOf(outcome);
    EXPECT_TRUE(end == End::Imported || end == End::InputError) << outcome.err;
    wasRefused |= outcome.err.find("was changed while it was imported") != std::string::npos;
    EXPECT_TRUE(lists(store_) == wide) << "the store holds what the file was before";
  }
  EXPECT_TRUE(wasRefused) << "the file was never changed between being read and the end";
}

}  // namespace
}  // namespace tessera::test
