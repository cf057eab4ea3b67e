#pragma once

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/programs/small_scene.h"
#include "tests/support/process.h"

namespace tessera::test {

/// A file's bytes.
inline std::string contentOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void overwrite(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
}

/// A picture of one pixel.
inline std::string tinyPng() {
  static constexpr unsigned char bytes[] = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
      0x44, 0x52, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x06, 0x00, 0x00,
      0x00, 0x1f, 0x15, 0xc4, 0x89, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x44, 0x41, 0x54, 0x78,
      0xda, 0x63, 0xf8, 0xdf, 0xe0, 0xf0, 0x1f, 0x00, 0x07, 0x00, 0x02, 0xbf, 0xf4, 0x89,
      0xd5, 0xf2, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  return {reinterpret_cast<const char*>(bytes), sizeof bytes};
}

/// The vertices of a triangle, for triangleScene.
inline std::string triangleBin(float width = 1) {
  const float vertices[] = {0, 0, 0, width, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1};
  return {reinterpret_cast<const char*>(vertices), sizeof vertices};
}

/// glTF of one textured triangle whose arrays and picture are files of these names.
inline std::string triangleScene(const std::string& bin = "tri.bin", const std::string& png = "tex.png") {
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
    "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    "textures": [{"source": 0}], "images": [{"uri": ")" +
         png + R"("}], "buffers": [{"uri": ")" + bin + R"(", "byteLength": 60}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                   "min": [0, 0, 0], "max": [1, 1, 0]},
                  {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}]})";
}

/// An OBJ that takes a while to read.
inline std::string largeScene(int triangles = 100'000) {
  std::ostringstream text;
  for (int i = 0; i < triangles; ++i) {
    text << "v " << i << " 0 0\nv " << i + 1 << " 0 " << i % 7 << "\nv " << i << " 1 0\n"
         << (i % 100 == 0 ? "g p" + std::to_string(i) + "\n" : "") << "f -3 -2 -1\n";
  }
  return text.str();
}

/// Runs imports into a store of its own.
class ImportTest : public ::testing::Test {
 protected:
  enum class End { Imported, InStore, InputError, RuntimeError, Broken };

  [[nodiscard]] std::vector<std::string> arguments(const std::string& scene,
                                                   std::vector<std::string> more = {}) const {
    std::vector<std::string> all = {program("tessera"), "import", scene, "--store", store_};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Outcome import(const std::string& scene, const std::vector<std::string>& more = {}) const {
    return run(arguments(scene, more), std::chrono::seconds(60));
  }
  /// How it ended; Broken for whatever is neither a scene nor exactly one error with its exit status.
  static End endOf(const Outcome& outcome) {
    std::istringstream lines(outcome.err);
    int errors = 0;
    for (std::string line; std::getline(lines, line);)
      errors += line.starts_with("tessera: error: ") ? 1 : 0;
    if (outcome.status == 0 && errors == 0 && outcome.out.starts_with("imported: ")) return End::Imported;
    if (outcome.status == 0 && errors == 0 && outcome.out.starts_with("in the store: ")) return End::InStore;
    if (outcome.status == 2 && errors == 1) return End::InputError;
    if (outcome.status == 1 && errors == 1) return End::RuntimeError;
    return End::Broken;
  }
  void expectEnd(const Outcome& outcome, End end, const std::string& says = {}) const {
    EXPECT_EQ(static_cast<int>(endOf(outcome)), static_cast<int>(end)) << outcome.status << "\n"
                                                                       << outcome.out << outcome.err;
    EXPECT_NE((outcome.out + outcome.err).find(says), std::string::npos) << "not said: " << says << "\n"
                                                                         << outcome.out << outcome.err;
  }
  /// Three frames of the scene on a wall that shows nothing.
  Outcome show(const std::string& scene) const {
    return run({program("tessera"), "run", "--surface", "none", "--wall", wall_, "--scene", scene, "--store",
                store_, "--frames", "3"},
               std::chrono::seconds(60));
  }
  [[nodiscard]] std::vector<std::filesystem::path> filesOfStore() const {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(store_)) {
      if (entry.is_regular_file() && entry.file_size() > 0) files.push_back(entry.path());
    }
    return files;
  }

  TemporaryFolder folder_;
  std::string store_ = folder_ / "store";
  std::string wall_ = folder_.write("wall.json", smallWall());
};

}  // namespace tessera::test
