// The store of imported scenes over restarts, changes of the files, several programs and damage.

#include <memory>
#include <thread>

#include <signal.h>
#include <sys/stat.h>

#include "tests/programs/import_fixture.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;

class ImportStore : public ImportTest {
 protected:
  std::string textured(const std::string& below = "scene") {
    fs::create_directories(folder_ / below);
    overwrite(folder_ / below + "/tri.bin", triangleBin());
    overwrite(folder_ / below + "/tex.png", tinyPng());
    return folder_.write(below + "/scene.gltf", triangleScene());
  }
};

TEST_F(ImportStore, TheSecondStartUsesIt) {
  const std::string scene = folder_.write("scene.obj", smallScene());
  expectEnd(import(scene), End::Imported, "2 leaves, 2 triangles");
  expectEnd(import(scene), End::InStore, "2 leaves, 2 triangles");
  // How the scene is imported is part of what it is known by.
  expectEnd(import(scene, {"--up", "y"}), End::Imported);
  expectEnd(import(scene, {"--hierarchy", "bvh"}), End::Imported);
  expectEnd(import(scene), End::InStore);
  const Outcome outcome = show(scene);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
}

TEST_F(ImportStore, CullUsesItToo) {
  const std::string scene = folder_.write("scene.obj", smallScene());
  const auto cull = [&] {
    return run({program("tessera"), "cull", "--wall", wall_, "--scene", scene, "--store", store_, "--frames",
                "4", "--lists", folder_ / "lists.jsonl"},
               seconds(60));
  };
  ASSERT_EQ(cull().status, 0);
  const std::string first = contentOf(folder_ / "lists.jsonl");
  expectEnd(import(scene), End::InStore);
  ASSERT_EQ(cull().status, 0);
  EXPECT_EQ(contentOf(folder_ / "lists.jsonl"), first);
  EXPECT_FALSE(first.empty());
}

TEST_F(ImportStore, AChangedSceneIsImportedAnew) {
  const std::string scene = folder_.write("scene.obj", smallScene());
  expectEnd(import(scene), End::Imported, "2 triangles");
  overwrite(scene, smallScene() + "g c\nf 1 2 6\n");
  expectEnd(import(scene), End::Imported, "3 triangles");
  expectEnd(import(scene), End::InStore, "3 triangles");
  // What it was before is still there.
  overwrite(scene, smallScene());
  expectEnd(import(scene), End::InStore, "2 triangles");
}

TEST_F(ImportStore, ChangedFilesBesideItAreSeen) {
  const std::string scene = textured();
  expectEnd(import(scene), End::Imported);
  expectEnd(import(scene), End::InStore);
  overwrite(folder_ / "scene/tri.bin", triangleBin(0.5F));
  expectEnd(import(scene), End::Imported);
  overwrite(folder_ / "scene/tex.png", tinyPng() + "more");
  expectEnd(import(scene), End::Imported);
  expectEnd(import(scene), End::InStore);
  // Same size and same time of change: only the content tells.
  const auto time = fs::last_write_time(folder_ / "scene/tri.bin");
  overwrite(folder_ / "scene/tri.bin", triangleBin(0.75F));
  fs::last_write_time(folder_ / "scene/tri.bin", time);
  expectEnd(import(scene), End::Imported);
}

TEST_F(ImportStore, ATextureThatAppearsOrGoesIsSeen) {
  const std::string scene = textured();
  fs::remove(folder_ / "scene/tex.png");
  expectEnd(import(scene), End::Imported, "tex.png");
  expectEnd(import(scene), End::InStore, "tex.png");
  overwrite(folder_ / "scene/tex.png", tinyPng());
  Outcome outcome = import(scene);
  expectEnd(outcome, End::Imported);
  EXPECT_EQ(outcome.err.find("tex.png"), std::string::npos) << outcome.err;
  expectEnd(import(scene), End::InStore);
  fs::remove(folder_ / "scene/tex.png");
  expectEnd(import(scene), End::Imported, "tex.png");
}

TEST_F(ImportStore, AMaterialFileThatAppearsIsSeen) {
  const std::string scene = folder_.write("scene.obj", "mtllib scene.mtl\nusemtl red\n" + smallScene());
  expectEnd(import(scene), End::Imported);
  expectEnd(import(scene), End::InStore);
  (void)folder_.write("scene.mtl", "newmtl red\nKd 1 0 0\n");
  expectEnd(import(scene), End::Imported);
  expectEnd(import(scene), End::InStore);
}

TEST_F(ImportStore, AFolderThatMovedIsTheSame) {
  expectEnd(import(textured()), End::Imported);
  fs::rename(folder_ / "scene", folder_ / "elsewhere");
  expectEnd(import(folder_ / "elsewhere/scene.gltf"), End::InStore);
  (void)textured("copy");
  expectEnd(import(folder_ / "copy/scene.gltf"), End::InStore);
  overwrite(folder_ / "copy/tri.bin", triangleBin(0.5F));
  expectEnd(import(folder_ / "copy/scene.gltf"), End::Imported);
}

TEST_F(ImportStore, APipeInThePlaceOfATextureIsNotWaitedFor) {
  const std::string scene = textured();
  fs::remove(folder_ / "scene/tex.png");
  expectEnd(import(scene), End::Imported);
  ASSERT_EQ(::mkfifo((folder_ / "scene/tex.png").c_str(), 0600), 0);
  const Outcome outcome = run(arguments(scene, {"--import-timeout", "3"}), seconds(20));
  EXPECT_NE(outcome.status, -1) << "waits";
  EXPECT_NE(endOf(outcome), End::Broken) << outcome.err;
}

TEST_F(ImportStore, ProgramsMayImportAtTheSameTime) {
  const std::string one = folder_.write("one.obj", largeScene(3000)), two = textured();
  for (int round = 0; round < 3; ++round) {
    fs::remove_all(store_);
    std::vector<std::unique_ptr<Process>> programs;
    for (const std::string& scene : {one, one, two, one})
      programs.push_back(std::make_unique<Process>(arguments(scene)));
    for (const auto& started : programs) {
      const End end = endOf(started->wait(seconds(60)));
      EXPECT_TRUE(end == End::Imported || end == End::InStore) << started->err();
    }
    expectEnd(import(one), End::InStore, "3000 triangles");
    expectEnd(import(two), End::InStore, "1 triangles");
  }
}

TEST_F(ImportStore, DamageBetweenStartsIsMended) {
  const std::string scene = textured();
  struct Damage {
    const char* name;
    void (*todo)(const fs::path&);
  };
  static constexpr Damage kinds[] = {
      {"removed", [](const fs::path& file) { fs::remove(file); }},
      {"emptied", [](const fs::path& file) { fs::resize_file(file, 0); }},
      {"cut", [](const fs::path& file) { fs::resize_file(file, fs::file_size(file) / 2); }},
      {"longer", [](const fs::path& file) { fs::resize_file(file, fs::file_size(file) + 4096); }},
      {"flipped", [](const fs::path& file) {
         std::string bytes = contentOf(file);
         for (std::size_t at = 0; at < bytes.size(); at += 61)
           bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
         overwrite(file, bytes);
       }}};
  for (const Damage& kind : kinds) {
    for (const char* part : {"packs", "entries"}) {
      SCOPED_TRACE(std::string(kind.name) + " " + part);
      fs::remove_all(store_);
      expectEnd(import(scene), End::Imported);
      std::size_t damaged = 0;
      for (const fs::path& file : filesOfStore()) {
        if (file.parent_path().filename() != part) continue;
        kind.todo(file);
        ++damaged;
      }
      EXPECT_GT(damaged, 0U);
      const Outcome first = show(scene);
      EXPECT_TRUE(first.status == 0 || first.status == 1) << first.status << first.err;
      // Damage that is found only when an asset is wanted is mended by the next start.
      const Outcome second = show(scene);
      EXPECT_EQ(second.status, 0) << first.err << second.err;
      expectEnd(import(scene), End::InStore);
    }
  }
}

TEST_F(ImportStore, DamageWhileAMasterRunsHarmsItNot) {
  const std::string scene = textured();
  for (const bool isRemoved : {false, true}) {
    Process master({program("tessera"), "serve", "--wall", wall_, "--scene", scene, "--store", store_,
                    "--listen", "127.0.0.1:0", "--fps", "50"});
    ASSERT_TRUE(master.waitForOut("listening on 127.0.0.1:", seconds(30))) << master.err();
    const std::string out = master.out();
    const std::string address =
        "127.0.0.1:" + std::to_string(std::atoi(out.c_str() + out.find("127.0.0.1:") + 10));
    const auto tile = [&](const char* name) {
      return std::make_unique<Process>(std::vector<std::string>{program("tessera-tile"), "--connect", address,
                                                                "--tile", name, "--surface", "none"});
    };
    const auto before = tile("r0c0");
    std::this_thread::sleep_for(seconds(1));
    for (const fs::path& file : filesOfStore()) {
      if (isRemoved) {
        fs::remove(file);
      } else if (file.parent_path().filename() == "packs") {
        // Not cut: what is mapped from a file must stay there, and whoever writes the store can do worse.
        std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
        for (std::uintmax_t at = 16; at < fs::file_size(file); at += 64) {
          bytes.seekp(static_cast<std::streamoff>(at));
          bytes.put('\x5a');
        }
      }
    }
    const auto after = tile("r0c1");
    std::this_thread::sleep_for(seconds(1));
    master.signal(SIGTERM);
    const Outcome outcome = master.wait(seconds(20));
    EXPECT_TRUE(outcome.status == 0 || outcome.status == 1) << outcome.status << outcome.err;
    EXPECT_EQ(outcome.out.find("Sanitizer"), std::string::npos);
    (void)show(scene);
    const Outcome later = show(scene);
    EXPECT_EQ(later.status, 0) << later.err;
    expectEnd(import(scene), End::InStore);
  }
}

TEST_F(ImportStore, APackThatIsCutWhileAMasterRunsHarmsItNot) {
  const std::string scene = textured();
  Process master({program("tessera"), "serve", "--wall", wall_, "--scene", scene, "--store", store_,
                  "--listen", "127.0.0.1:0", "--fps", "50"});
  ASSERT_TRUE(master.waitForOut("listening on 127.0.0.1:", seconds(30))) << master.err();
  const std::string out = master.out();
  for (const fs::path& file : filesOfStore()) {
    if (file.parent_path().filename() == "packs") fs::resize_file(file, 20);
  }
  const Process tile({program("tessera-tile"), "--connect",
                      "127.0.0.1:" + std::to_string(std::atoi(out.c_str() + out.find("127.0.0.1:") + 10)),
                      "--tile", "r0c0", "--surface", "none"});
  std::this_thread::sleep_for(seconds(1));
  master.signal(SIGTERM);
  const Outcome outcome = master.wait(seconds(20));
  EXPECT_TRUE(outcome.status == 0 || outcome.status == 1) << outcome.status << outcome.err;
  (void)show(scene);
  EXPECT_EQ(show(scene).status, 0);
}

}  // namespace
}  // namespace tessera::test
