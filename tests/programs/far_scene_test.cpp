// The same few boxes at the origin and as far as 10,000 km from it: the pictures must not tell.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/image/picture.h"
#include "tests/support/process.h"

namespace tessera::test {
namespace {

using std::chrono::seconds;

constexpr int kFrames = 4;
constexpr const char* kTiled = R"({"grid": {"columns": 2, "rows": 2, "tile_px": [320, 240]}})";

using Offset = std::array<double, 3>;

/// The bytes of a cube of half size 1: indices of 12 triangles, then positions, then normals.
struct Cube {
  std::string bytes;
  static constexpr std::size_t kIndexBytes = std::size_t{36} * 2, kVectorBytes = std::size_t{24} * 12;

  Cube() {
    std::string positions, normals;
    const auto append = [](std::string& to, const auto& value) {
      to.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    for (std::uint16_t face = 0; face < 6; ++face) {
      const std::size_t axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
      const float side = face % 2 == 0 ? 1 : -1;
      for (const auto& [a, b] : {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}}) {
        std::array<float, 3> position{}, normal{};
        position[axis] = normal[axis] = side;
        position[u] = side * static_cast<float>(a);  // the other way round on the far side
        position[v] = static_cast<float>(b);
        append(positions, position);
        append(normals, normal);
      }
      for (const int corner : {0, 1, 2, 0, 2, 3})
        append(bytes, static_cast<std::uint16_t>(4 * face + corner));
    }
    bytes += positions + normals;
  }
};

/// Coloured boxes, turned and scaled, within 3 m of one another, below a node that moves all by `offset`.
std::string boxes(const TemporaryFolder& folder, const std::string& name, const Offset& offset) {
  struct Box {
    Offset at, size;
    double turn;  ///< about y: sine of half the angle
    const char* colour;
  };
  const std::vector<Box> all = {{{0, -0.55, 0}, {2.5, 0.05, 2}, 0, "0.5,0.5,0.45"},
                                {{0.3, 0.1, 0.2}, {0.4, 0.6, 0.4}, 0.2, "0.8,0.1,0.1"},
                                {{-1.1, 0, 0.7}, {0.5, 0.5, 0.3}, 0.35, "0.1,0.6,0.2"},
                                {{1.4, -0.2, -0.9}, {0.3, 0.3, 0.8}, 0.1, "0.1,0.2,0.8"},
                                {{-0.6, 0.9, -0.5}, {0.9, 0.02, 0.6}, 0.5, "0.8,0.7,0.1"},
                                {{0.9, 0.4, 1.1}, {0.03, 0.9, 0.03}, 0, "0.7,0.2,0.7"},
                                {{-1.7, -0.3, -1.2}, {0.2, 0.2, 0.2}, 0.4, "0.1,0.7,0.7"}};
  const Cube cube;
  (void)folder.write(name + ".bin", cube.bytes);
  std::ostringstream nodes, children, meshes, materials;
  for (std::ostringstream* out : {&nodes, &children})
    out->precision(17);
  nodes << R"({"translation":[)" << offset[0] << "," << offset[1] << "," << offset[2] << R"(],"children":[)";
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Box& box = all[i];
    const char* comma = i == 0 ? "" : ",";
    nodes << comma << i + 1;
    children << R"(,{"mesh":)" << i << R"(,"translation":[)" << box.at[0] << "," << box.at[1] << ","
             << box.at[2] << R"(],"scale":[)" << box.size[0] << "," << box.size[1] << "," << box.size[2]
             << R"(],"rotation":[0,)" << box.turn << ",0," << std::sqrt(1 - box.turn * box.turn) << "]}";
    meshes << comma << R"({"primitives":[{"indices":0,"attributes":{"POSITION":1,"NORMAL":2},"material":)"
           << i << "}]}";
    materials << comma << R"({"pbrMetallicRoughness":{"metallicFactor":0,"baseColorFactor":[)" << box.colour
              << ",1]}}";
  }
  nodes << "]}";
  const std::size_t vectors = Cube::kVectorBytes, indices = Cube::kIndexBytes;
  std::ostringstream json;
  json << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)" << nodes.str()
       << children.str() << R"(],"meshes":[)" << meshes.str() << R"(],"materials":[)" << materials.str()
       << R"(],"buffers":[{"byteLength":)" << cube.bytes.size() << R"(,"uri":")" << name << R"(.bin"}],)"
       << R"("bufferViews":[{"buffer":0,"byteLength":)" << indices << R"(},{"buffer":0,"byteOffset":)"
       << indices << R"(,"byteLength":)" << vectors << R"(},{"buffer":0,"byteOffset":)" << indices + vectors
       << R"(,"byteLength":)" << vectors << R"(}],"accessors":[)"
       << R"({"bufferView":0,"componentType":5123,"count":36,"type":"SCALAR"},)"
       << R"({"bufferView":1,"componentType":5126,"count":24,"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]},)"
       << R"({"bufferView":2,"componentType":5126,"count":24,"type":"VEC3"}]})";
  return folder.write(name + ".gltf", json.str());
}

class FarScene : public ::testing::Test {
 protected:
  /// Draws the boxes into a folder of that name.
  void draw(const std::string& name, const Offset& offset, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {program("tessera"),
                                          "run",
                                          "--wall",
                                          folder_.write("wall.json", kTiled),
                                          "--scene",
                                          boxes(folder_, name + "-scene", offset),
                                          "--camera",
                                          config("orbit.camera.json"),
                                          "--frames",
                                          std::to_string(kFrames),
                                          "--out",
                                          folder_ / name};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run(arguments, seconds(60));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }

  struct Sum {
    std::size_t differing = 0, differingMuch = 0;
    int largest = 0;
  };
  /// Of all frames; printed as well.
  Sum compareAll(const std::string& a, const std::string& b) {
    Sum sum;
    std::size_t pixels = 0;
    for (int frame = 1; frame <= kFrames; ++frame) {
      const std::string file = "/frame-00000" + std::to_string(frame) + ".png";
      const auto first = readPng(folder_ / (a + file)), second = readPng(folder_ / (b + file));
      if (!first || !second) {
        ADD_FAILURE() << (first ? second : first).error().text();
        return sum;
      }
      EXPECT_GT(colours(*first), 8U) << a << " shows nothing";
      const auto difference = compare(*first, *second);
      if (!difference) {
        ADD_FAILURE() << difference.error().text();
        return sum;
      }
      pixels += difference->pixels;
      sum.differing += difference->differing;
      sum.differingMuch += difference->differingMuch;
      sum.largest = std::max(sum.largest, difference->largest);
    }
    std::printf("%s against %s: of %zu pixels %zu differ, %zu of them by more than 8, at most by %d\n",
                a.c_str(), b.c_str(), pixels, sum.differing, sum.differingMuch, sum.largest);
    return sum;
  }
  static std::size_t colours(const Picture& picture) {
    std::set<std::array<std::uint8_t, 3>> all;
    for (std::size_t i = 0; i + 2 < picture.rgb.size(); i += 3)
      all.insert({picture.rgb[i], picture.rgb[i + 1], picture.rgb[i + 2]});
    return all.size();
  }

  TemporaryFolder folder_;
};

TEST_F(FarScene, LooksAsItDoesAtTheOrigin) {
  struct Place {
    const char* name;
    Offset offset;
    std::size_t differing = 10;  ///< pixels of all frames that may
  };
  ASSERT_NO_FATAL_FAILURE(draw("origin", {0, 0, 0}));
  // Not one pixel was measured to differ up to 1e7 m, where doubles are 2 nm apart, and one at 1e9 m. Other
  // renderers may flip a few on edges.
  for (const auto& [name, offset, differing] :
       {Place{"x1e4", {1e4, 0, 0}}, Place{"y1e6", {0, 1e6, 0}}, Place{"x1e7", {1e7, 0, 0}},
        Place{"y1e7", {0, 1e7, 0}}, Place{"z-1e7", {0, 0, -1e7}}, Place{"all1e7", {1e7, -1e7, 1e7}},
        Place{"odd", {12345678.9, -7654321.1, 0}}, Place{"x1e9", {1e9, 0, 0}, 40}}) {
    ASSERT_NO_FATAL_FAILURE(draw(name, offset));
    const Sum sum = compareAll("origin", name);
    EXPECT_LE(sum.differing, differing) << name;
  }
}

TEST_F(FarScene, StitchedItEqualsTheUntiledUnculledPicture) {
  const Offset offset = {1e7, 0, -1e7};
  ASSERT_NO_FATAL_FAILURE(draw("stitched", offset));
  ASSERT_NO_FATAL_FAILURE(draw("untiled", offset, {"--untiled", "--algorithm", "none"}));
  const Sum sum = compareAll("stitched", "untiled");
  EXPECT_LE(sum.differing, 10U);
}

}  // namespace
}  // namespace tessera::test
