// Scenes from strangers: no file outside of the scene's folder is read, nobody is called, links are followed
// only where the user gave them.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/programs/import_fixture.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;

class ImportStrangers : public ImportTest {
 protected:
  ImportStrangers() {
    fs::create_directory(folder_ / "scene");
    fs::create_directory(folder_ / "secret");
    overwrite(folder_ / "scene/tri.bin", triangleBin());
    overwrite(folder_ / "scene/tex.png", tinyPng());
    overwrite(folder_ / "secret/tri.bin", triangleBin());
    overwrite(folder_ / "secret/tex.png", tinyPng());
  }
  std::string gltf(const std::string& bin, const std::string& png) {
    return folder_.write("scene/scene.gltf", triangleScene(bin, png));
  }
  /// Whether this machine's kernel keeps files back from a process.
  bool hasLandlock() {
    const std::string scene = folder_.write("plain.obj", smallScene());
    const Outcome outcome = run({program("tessera"), "import", scene, "--store", folder_ / "probe"},
                                seconds(60), {{"TESSERA_LOG", "debug"}});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.err.find("Landlock") == std::string::npos;
  }
};

TEST_F(ImportStrangers, BuffersOutsideAreRefused) {
  for (const std::string& bin : {std::string("../secret/tri.bin"), std::string("..%2Fsecret%2Ftri.bin"),
                                 std::string("x/../../secret/tri.bin"), folder_ / "secret/tri.bin",
                                 "file://" + (folder_ / "secret/tri.bin")})
    expectEnd(import(gltf(bin, "tex.png")), End::InputError, "tri.bin");
}

TEST_F(ImportStrangers, PicturesOutsideAreLeftOut) {
  for (const std::string& png : {std::string("../secret/tex.png"), std::string("..%2Fsecret%2Ftex.png"),
                                 folder_ / "secret/tex.png", "file://" + (folder_ / "secret/tex.png")})
    expectEnd(import(gltf("tri.bin", png)), End::Imported, "warning");
}

TEST_F(ImportStrangers, LinksThatLeadOutsideAreNotFollowed) {
  if (!hasLandlock()) GTEST_SKIP() << "this kernel has no Landlock";
  fs::create_symlink("../secret/tri.bin", folder_ / "scene/link.bin");
  fs::create_symlink("../secret/tex.png", folder_ / "scene/link.png");
  expectEnd(import(gltf("link.bin", "tex.png")), End::InputError, "link.bin");
  expectEnd(import(gltf("tri.bin", "link.png")), End::InputError, "link.png");
}

/// A file of the readers of OpenSceneGraph that names another one.
struct Naming {
  std::string file, text, canary;
};

TEST_F(ImportStrangers, ReadersOfOpenSceneGraphStayInside) {
  // What stands for the content of the canary: its triangles would be counted, its colour be a new asset.
  overwrite(folder_ / "secret/model.obj", largeScene(77));
  overwrite(folder_ / "secret/scene.mtl", "newmtl red\nKd 1 0 0\nmap_Kd tex.png\n");
  const auto nodeFile = [](const std::string& name) {
    return "#Ascii Scene\n#Version 154\n#Generator OpenSceneGraph 3.6.5\n\nosg::Group {\n  UniqueID 1\n  "
           "Children 1 {\n    osg::ProxyNode {\n      UniqueID 2\n      FileNames 1 {\n        \"" +
           name + "\"\n      }\n    }\n  }\n}\n";
  };
  const Naming namings[] = {
      {"a.obj", "mtllib ../secret/scene.mtl\nusemtl red\n" + smallScene(), "secret/scene.mtl"},
      {"b.obj", "mtllib " + (folder_ / "secret/scene.mtl") + "\nusemtl red\n" + smallScene(),
       "secret/scene.mtl"},
      {"c.osgt", nodeFile("../secret/model.obj"), "secret/model.obj"},
      {"d.osgt", nodeFile(folder_ / "secret/model.obj"), "secret/model.obj"}};
  for (const Naming& naming : namings) {
    SCOPED_TRACE(naming.file);
    const std::string scene = folder_.write("scene/" + naming.file, naming.text);
    const Outcome outcome = import(scene);
    EXPECT_NE(static_cast<int>(endOf(outcome)), static_cast<int>(End::Broken)) << outcome.err;
    EXPECT_EQ(outcome.out.find("77 triangles"), std::string::npos) << outcome.out;
    // Without the canary the very same comes out.
    const std::string kept = store_;
    store_ += "-without";
    fs::rename(folder_ / naming.canary, folder_ / "away");
    const Outcome without = import(scene);
    fs::rename(folder_ / "away", folder_ / naming.canary);
    store_ = kept;
    EXPECT_EQ(static_cast<int>(endOf(without)), static_cast<int>(endOf(outcome))) << without.err;
    EXPECT_EQ(without.out.substr(0, without.out.find('\n')), outcome.out.substr(0, outcome.out.find('\n')));
  }
}

TEST_F(ImportStrangers, ReadersOfOpenSceneGraphReadBeside) {
  // The other test would see nothing if the reader did not follow names at all.
  overwrite(folder_ / "scene/model.obj", largeScene(77));
  const std::string scene = folder_.write(
      "scene/near.osgt",
      "#Ascii Scene\n#Version 154\n#Generator OpenSceneGraph 3.6.5\n\nosg::Group {\n  UniqueID 1\n  Children "
      "1 "
      "{\n    osg::ProxyNode {\n      UniqueID 2\n      FileNames 1 {\n        \"model.obj\"\n      }\n    "
      "}\n  }\n}\n");
  expectEnd(import(scene), End::Imported, "77 triangles");
}

TEST_F(ImportStrangers, NobodyIsCalled) {
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(::listen(listener, 8), 0);
  socklen_t size = sizeof address;
  ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
  const std::string host = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port)) + "/";
  expectEnd(import(gltf(host + "tri.bin", "tex.png")), End::InputError, "tri.bin");
  expectEnd(import(gltf("tri.bin", host + "tex.png")), End::Imported, "warning");
  const Outcome material =
      import(folder_.write("scene/a.obj", "mtllib " + host + "a.mtl\nusemtl red\n" + smallScene()));
  EXPECT_EQ(material.status, 0) << material.err;
  const Outcome scene = import(host + "scene.glb");
  EXPECT_EQ(scene.status, 2) << scene.err;
  pollfd waiting{listener, POLLIN, 0};
  EXPECT_EQ(::poll(&waiting, 1, 100), 0) << "it called";
  ::close(listener);
}

TEST_F(ImportStrangers, LinksOfTheUserAreFollowed) {
  (void)gltf("tri.bin", "tex.png");
  fs::create_directory_symlink(folder_ / "scene", folder_ / "linked");
  expectEnd(import(folder_ / "linked/scene.gltf"), End::Imported);
  expectEnd(import(folder_ / "scene/scene.gltf"), End::InStore);
  // A link to the file alone: what it names is looked for beside the link.
  fs::create_directory(folder_ / "desk");
  (void)folder_.write("scene/plain.obj", smallScene());
  fs::create_symlink(folder_ / "scene/plain.obj", folder_ / "desk/plain.obj");
  expectEnd(import(folder_ / "desk/plain.obj"), End::Imported, "2 triangles");
  fs::create_symlink(folder_ / "scene/scene.gltf", folder_ / "desk/scene.gltf");
  expectEnd(import(folder_ / "desk/scene.gltf"), End::InputError, "tri.bin");
  // Names with steps back over a link mean what the system makes of them.
  fs::create_directory(folder_ / "scene/deep");
  fs::create_directory_symlink(folder_ / "scene/deep", folder_ / "desk/deep");
  store_ += "-again";
  expectEnd(import(folder_ / "desk/deep/../scene.gltf"), End::Imported);
}

}  // namespace
}  // namespace tessera::test
