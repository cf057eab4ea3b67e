// Imports that take too long or too much, disks that are full or may not be written, files that change
// meanwhile.

#include <atomic>
#include <thread>

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

/// Swaps the two files of a scene between two states, as renames, for as long as it lives.
class Swapper {
 public:
  explicit Swapper(std::string folder) : folder_(std::move(folder)), thread_([this] { swap(); }) {}
  ~Swapper() {
    isOver_ = true;
    thread_.join();
  }
  Swapper(const Swapper&) = delete;
  Swapper& operator=(const Swapper&) = delete;

 private:
  void swap() {
    for (int turn = 0; !isOver_; ++turn) {
      overwrite(folder_ + "/new.bin", triangleBin(turn % 2 == 0 ? 0.25F : 0.5F));
      fs::rename(folder_ + "/new.bin", folder_ + "/tri.bin");
      std::this_thread::sleep_for(milliseconds(1 + turn % 90));
    }
  }
  const std::string folder_;
  std::atomic<bool> isOver_ = false;
  std::thread thread_;
};

TEST_F(ImportLimitsTest, AMixtureIsNeverKept) {
  (void)folder_.write("tri.bin", triangleBin(0.25F));
  (void)folder_.write("tex.png", tinyPng());
  const std::string scene = folder_.write("scene.gltf", triangleScene());
  std::size_t good = 0;
  {
    const Swapper swapper(folder_.path());
    for (int i = 0; i < 12; ++i) {
      const Outcome outcome = import(scene);
      const End end = endOf(outcome);
      EXPECT_TRUE(end == End::Imported || end == End::InStore || end == End::InputError ||
                  end == End::RuntimeError)
          << outcome.err;
      good += end == End::Imported || end == End::InStore ? 1 : 0;
    }
  }
  // Whatever state the store calls its own is the one that a fresh import sees.
  for (const float width : {0.25F, 0.5F}) {
    overwrite(folder_ / "tri.bin", triangleBin(width));
    const auto lists = [&](const std::string& store, const std::string& name) {
      const Outcome outcome = run({program("tessera"), "cull", "--wall", wall_, "--scene", scene, "--store",
                                   store, "--frames", "2", "--lists", folder_ / name},
                                  seconds(60));
      EXPECT_EQ(outcome.status, 0) << outcome.err;
      return contentOf(folder_ / name);
    };
    EXPECT_EQ(lists(store_, "a.jsonl"), lists(folder_ / ("fresh" + std::to_string(width)), "b.jsonl"));
  }
  RecordProperty("good", static_cast<int>(good));
}

}  // namespace
}  // namespace tessera::test
