#include <filesystem>
#include <set>

#include "common/base/file.h"
#include "common/wall/import/wall_text.h"
#include "common/wall/json_document.h"
#include "tests/common/wall/import/imported.h"
#include "tests/support/process.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::errorOf;

TEST(ImportWall, refusesWhatIsNoWall) {
  EXPECT_TRUE(contains(errorOf("", "a"), "a: the file is empty"));
  EXPECT_TRUE(contains(errorOf(" \n", "a"), "the file is empty"));
  EXPECT_TRUE(contains(errorOf("hello", "a"), "no wall in a known format; known are Equalizer"));
  EXPECT_TRUE(contains(errorOf("{}", "a"), "is JSON, but describes no wall"));
  EXPECT_TRUE(contains(errorOf("[]", "a"), "is JSON, but describes no wall"));
  EXPECT_TRUE(contains(errorOf("{\"grid\": {}}", "a"), "is a wall file already"));
  EXPECT_TRUE(contains(errorOf("<html/>", "a"), "is XML, but describes no wall"));
  EXPECT_TRUE(contains(errorOf("<Cluster/>", "a"), "SGCT file of the old XML format"));
  EXPECT_TRUE(contains(errorOf("<MPCDI/>", "a"), "inside an MPCDI archive"));
  EXPECT_TRUE(
      contains(errorOf(std::string_view("server {\n\0}", 11), "a"), "a:2: the text holds a NUL byte"));
  EXPECT_TRUE(contains(errorOf("\xEF\xBB\xBFserver {}", "a"), "no config")) << "a byte order mark is no text";
}

TEST(ImportWall, boundsTheSizeOfFiles) {
  const std::string large = "server { config { } }" + std::string(std::size_t{1} << 20, ' ');
  EXPECT_TRUE(contains(errorOf(large, "a"), "is larger than 1048576 bytes"));
  const test::TemporaryFolder folder;
  const Result<ImportedWall> wall = importWall(folder.write("large.eqc", large));
  ASSERT_FALSE(wall.ok());
  EXPECT_TRUE(contains(wall.error().text(), "is larger than 1048576 bytes"));
  EXPECT_FALSE(importWall(folder / "none.eqc").ok());
  EXPECT_FALSE(importWall(folder.path()).ok());
}

TEST(ImportWall, boundsTheSizeOfWallsAndWarnings) {
  std::string tide =
      R"({"surfaces": [{"displayWidth": 9, "displayHeight": 9}], "processes": [{"screens": [{})";
  for (int i = 0; i < 50'000; ++i)
    tide += ",{}";
  const Result<ImportedWall> same = importWallText(tide + "]}]}", "t");
  ASSERT_TRUE(same.ok()) << same.error().text();
  EXPECT_LE(same->warnings.size(), 2u);
  std::string keys =
      "config { canvas { wall {} segment { channel \"a\" } } node { pipe { window { channel { name \"a\" } } "
      "} }\n";
  for (int i = 0; i < 20'000; ++i)
    keys += "k" + std::to_string(i) + " 1 ";
  const Result<ImportedWall> many = importWallText(keys + "}", "e");
  ASSERT_TRUE(many.ok()) << many.error().text();
  EXPECT_LE(many->warnings.size(), 65u);
}

TEST(ImportWall, hostileNamesStayText) {
  const std::string name = "a\n\"b\x01\xff.eqc";
  const char* text =
      "server { config { node { pipe { window { channel { name \"a\xc3 }{\" } } } }\n"
      "canvas { wall {} segment { channel \"a\xc3 }{\" } } } }";
  const Result<ImportedWall> wall = importWallText(text, name);
  ASSERT_TRUE(wall.ok()) << wall.error().text();
  const Result<JsonDocument> json = JsonDocument::parse(wall->json, "wall");
  ASSERT_TRUE(json.ok()) << json.error().text() << wall->json;
  EXPECT_EQ(json->root().find("screens")->children()[0].find("tiles")->children()[0].find("name")->string(),
            "a----");
}

TEST(NameMaker, makesEachNameOnce) {
  NameMaker names;
  EXPECT_EQ(names.make("left wall"), "left-wall");
  EXPECT_EQ(names.make("left/wall"), "left-wall-2");
  EXPECT_EQ(names.make(""), "tile");
  EXPECT_EQ(names.make(std::string(100, 'x')), std::string(64, 'x'));
  EXPECT_EQ(names.make(std::string(100, 'x')), std::string(62, 'x') + "-2");
}

/// The files of other systems that lie beside the source tree.
class ForeignWalls : public testing::Test {
 protected:
  static fs::path folder() { return fs::path(TESSERA_SOURCE_DIR).parent_path() / "shared/walls"; }

  static std::string warningsOf(const std::string& file) {
    const Result<ImportedWall> wall = importWall(folder() / file);
    if (!wall) return "error: " + wall.error().text();
    std::string all;
    for (const std::string& warning : wall->warnings)
      all += warning + '\n';
    return all;
  }

  void SetUp() override {
    if (!fs::is_directory(folder())) GTEST_SKIP() << "the folder ../shared/walls is not there";
  }
};

TEST_F(ForeignWalls, allBecomeWallFilesOrAreRefusedWithAReason) {
  std::set<std::string> refused;
  int count = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder())) {
    if (!entry.is_regular_file() || entry.path().extension() == ".md") continue;
    const std::string name = entry.path().lexically_relative(folder()).string();
    SCOPED_TRACE(name);
    ++count;
    const Result<ImportedWall> wall = importWall(entry.path());
    if (!wall) {
      refused.insert(name);
      continue;
    }
    const Result<JsonDocument> json = JsonDocument::parse(wall->json, "wall");
    ASSERT_TRUE(json.ok()) << json.error().text() << wall->json;
    EXPECT_TRUE(wall->json.starts_with("// From the "));
    EXPECT_EQ(json->root().find("name")->string(), entry.path().stem().string());
    EXPECT_NE(json->root().find("grid").has_value(), json->root().find("screens").has_value());
    const Result<std::string> text = readFile(entry.path(), 1 << 20);
    ASSERT_TRUE(text.ok());
    std::string warnings;
    for (const std::string& warning : wall->warnings)
      warnings += warning + '\n';
    for (const char* word :
         {"compound", "load_equalizer", "view_equalizer", "monitor_equalizer", "swapbarrier", "inputframe",
          "outputframe", "deflect_host", "device", "HMD", "background", "masteraddress"}) {
      // Comments begin with #; no value of these files does.
      bool isThere = false;
      for (std::size_t at = text->find(word); at != std::string::npos; at = text->find(word, at + 1)) {
        const std::size_t line = text->rfind('\n', at) + 1;
        isThere =
            isThere || std::string_view(*text).substr(line, at - line).find('#') == std::string_view::npos;
      }
      EXPECT_EQ(contains(warnings, word), isThere) << word << '\n' << warnings;
    }
  }
  EXPECT_GE(count, 29);
  EXPECT_EQ(refused, std::set<std::string>{"sgct/single_fisheye.json"});
  EXPECT_TRUE(contains(warningsOf("sgct/single_fisheye.json"), "FisheyeProjection"))
      << warningsOf("sgct/single_fisheye.json");
}

TEST_F(ForeignWalls, countsWhatItLeavesOut) {
  const std::string curved = warningsOf("equalizer/3-window.curved.eqc");
  EXPECT_TRUE(contains(curved, ".eqc:99: compound (17 times): ")) << curved;
  EXPECT_TRUE(contains(curved, ".eqc:123: load_equalizer (3 times): ")) << curved;
  EXPECT_TRUE(contains(curved, ".eqc:119: view_equalizer: ")) << curved;
  const std::string six = warningsOf("equalizer/6-node.layout.eqc");
  EXPECT_TRUE(contains(six, "channel that no segment of a canvas shows (5 times): ")) << six;
}

TEST_F(ForeignWalls, everyTruncationOfTheLargestIsAnErrorOrAWall) {
  for (const char* file : {"equalizer/3-window.curved.eqc", "tide/configuration_stereo.json",
                           "sgct/multi_window.json", "displaycluster/configuration.xml"}) {
    const Result<std::string> text = readFile(folder() / file, 1 << 20);
    ASSERT_TRUE(text.ok());
    for (std::size_t size = 0; size < text->size(); ++size) {
      const Result<ImportedWall> wall = importWallText(std::string_view(*text).substr(0, size), file);
      if (wall) {
        EXPECT_TRUE(JsonDocument::parse(wall->json, "wall").ok());
      }
    }
  }
}

}  // namespace
}  // namespace tessera
