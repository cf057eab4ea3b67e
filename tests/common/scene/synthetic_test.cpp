#include "common/scene/synthetic/synthetic.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/geometry/vec.h"
#include "common/scene/synthetic/shapes.h"
#include "common/scene/synthetic/trig.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr int kUnsignedShort = 5123;

std::uint32_t wordAt(std::string_view bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

/// A .glb taken apart; the checks of its frame are made on the way.
struct Glb {
  json doc;
  std::string_view binary;
};

Glb parse(const std::string& bytes) {
  Glb glb;
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(wordAt(bytes, 4), 2U);
  EXPECT_EQ(wordAt(bytes, 8), bytes.size());
  const std::uint32_t jsonBytes = wordAt(bytes, 12);
  EXPECT_EQ(jsonBytes % 4, 0U);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  glb.doc = json::parse(bytes.begin() + 20, bytes.begin() + 20 + jsonBytes);
  const std::size_t binaryAt = 20 + jsonBytes;
  const std::uint32_t binaryBytes = wordAt(bytes, binaryAt);
  EXPECT_EQ(binaryBytes % 4, 0U);
  EXPECT_EQ(bytes.substr(binaryAt + 4, 4), std::string("BIN\0", 4));
  EXPECT_EQ(binaryAt + 8 + binaryBytes, bytes.size());
  glb.binary = std::string_view(bytes).substr(binaryAt + 8);
  EXPECT_EQ(glb.doc["buffers"][0]["byteLength"], binaryBytes);
  EXPECT_EQ(glb.doc["asset"]["version"], "2.0");
  EXPECT_EQ(glb.doc["asset"]["generator"], "tessera");
  EXPECT_FALSE(glb.doc["scenes"][0].value("name", "").empty());
  EXPECT_EQ(glb.doc["scenes"][0]["nodes"].size(), 1U);
  return glb;
}

struct Census {
  std::uint64_t nodes = 0, leaves = 0, groups = 0, triangles = 0;
  std::size_t leastChildren = 1'000'000;
};

/// Walks the tree from its root: every node must be met once.
Census census(const Glb& glb) {
  const json& nodes = glb.doc["nodes"];
  std::vector<std::uint64_t> meshTriangles;
  for (const json& mesh : glb.doc["meshes"]) {
    EXPECT_EQ(mesh["primitives"].size(), 1U);
    const json& indices = glb.doc["accessors"][mesh["primitives"][0]["indices"].get<std::size_t>()];
    meshTriangles.push_back(indices["count"].get<std::uint64_t>() / 3);
  }
  Census c;
  std::vector<bool> seen(nodes.size(), false);
  std::vector<std::size_t> open = {glb.doc["scenes"][0]["nodes"][0].get<std::size_t>()};
  while (!open.empty()) {
    const std::size_t i = open.back();
    open.pop_back();
    EXPECT_FALSE(seen.at(i));
    seen[i] = true;
    ++c.nodes;
    const json& node = nodes[i];
    const bool hasMesh = node.contains("mesh");
    EXPECT_NE(hasMesh, node.contains("children"));
    if (hasMesh) {
      ++c.leaves;
      c.triangles += meshTriangles.at(node["mesh"].get<std::size_t>());
      continue;
    }
    ++c.groups;
    c.leastChildren = std::min(c.leastChildren, node["children"].size());
    for (const json& child : node["children"])
      open.push_back(child.get<std::size_t>());
  }
  EXPECT_EQ(c.nodes, nodes.size());
  return c;
}

/// The bytes of an accessor, after checking that they lie inside its view and the view inside the buffer.
std::string_view bytesOf(const Glb& glb, const json& accessor, std::size_t elementBytes) {
  const json& view = glb.doc["bufferViews"][accessor["bufferView"].get<std::size_t>()];
  const auto viewOffset = view["byteOffset"].get<std::size_t>();
  const auto viewBytes = view["byteLength"].get<std::size_t>();
  const auto offset = accessor["byteOffset"].get<std::size_t>();
  const auto count = accessor["count"].get<std::size_t>();
  EXPECT_GT(count, 0U);
  EXPECT_LE(viewOffset + viewBytes, glb.binary.size());
  EXPECT_LE(offset + count * elementBytes, viewBytes);
  const std::size_t alignment = std::min<std::size_t>(elementBytes, 4);
  EXPECT_EQ((viewOffset + offset) % alignment, 0U);
  EXPECT_EQ(view["target"], elementBytes == 12 ? 34962 : 34963);
  return glb.binary.substr(viewOffset + offset, count * elementBytes);
}

std::vector<Vec3> vectorsOf(const Glb& glb, const json& accessor) {
  EXPECT_EQ(accessor["type"], "VEC3");
  EXPECT_EQ(accessor["componentType"], 5126);
  const std::string_view bytes = bytesOf(glb, accessor, 12);
  std::vector<Vec3> vectors(bytes.size() / 12);
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    float v[3];
    std::memcpy(v, bytes.data() + 12 * i, sizeof v);
    vectors[i] = {v[0], v[1], v[2]};
  }
  return vectors;
}

std::vector<std::uint32_t> indicesOf(const Glb& glb, const json& accessor) {
  EXPECT_EQ(accessor["type"], "SCALAR");
  const bool narrow = accessor["componentType"] == kUnsignedShort;
  const std::size_t elementBytes = narrow ? 2 : 4;
  const std::string_view bytes = bytesOf(glb, accessor, elementBytes);
  std::vector<std::uint32_t> indices(bytes.size() / elementBytes);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    std::memcpy(&indices[i], bytes.data() + elementBytes * i, elementBytes);
  }
  return indices;
}

struct MeshFaults {
  std::uint64_t notFinite = 0, normalsNotUnit = 0, indicesOutside = 0, turnedInward = 0, boundsWrong = 0;
};

void checkTriangle(const Vec3* const corners[3], const Vec3& normalSum, MeshFaults& faults) {
  const Vec3 face = (*corners[1] - *corners[0]).cross(*corners[2] - *corners[0]);
  // Slivers have no direction in single precision.
  if (face.norm() > 1e-6 && face.dot(normalSum) <= 0) ++faults.turnedInward;
}

/// Looks at every vertex and triangle of every mesh.
MeshFaults inspect(const Glb& glb) {
  MeshFaults faults;
  for (const json& mesh : glb.doc["meshes"]) {
    const json& primitive = mesh["primitives"][0];
    const json& accessors = glb.doc["accessors"];
    const json& position = accessors[primitive["attributes"]["POSITION"].get<std::size_t>()];
    const std::vector<Vec3> positions = vectorsOf(glb, position);
    const std::vector<Vec3> normals =
        vectorsOf(glb, accessors[primitive["attributes"]["NORMAL"].get<std::size_t>()]);
    const std::vector<std::uint32_t> indices =
        indicesOf(glb, accessors[primitive["indices"].get<std::size_t>()]);
    EXPECT_EQ(positions.size(), normals.size());
    EXPECT_EQ(indices.size() % 3, 0U);
    Vec3 low = positions.front();
    Vec3 high = low;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      if (!positions[i].allFinite()) ++faults.notFinite;
      if (!(std::abs(normals[i].norm() - 1) < 1e-5)) ++faults.normalsNotUnit;
      low = low.cwiseMin(positions[i]);
      high = high.cwiseMax(positions[i]);
    }
    for (int k = 0; k < 3; ++k) {
      if (position["min"][static_cast<std::size_t>(k)].get<float>() != static_cast<float>(low[k]) ||
          position["max"][static_cast<std::size_t>(k)].get<float>() != static_cast<float>(high[k])) {
        ++faults.boundsWrong;
      }
    }
    for (std::size_t t = 0; t + 2 < indices.size(); t += 3) {
      if (std::max({indices[t], indices[t + 1], indices[t + 2]}) >= positions.size()) {
        ++faults.indicesOutside;
        continue;
      }
      const Vec3* const corners[3] = {&positions[indices[t]], &positions[indices[t + 1]],
                                      &positions[indices[t + 2]]};
      const Vec3 sum = normals[indices[t]] + normals[indices[t + 1]] + normals[indices[t + 2]];
      checkTriangle(corners, sum, faults);
    }
  }
  return faults;
}

void expectSound(const Glb& glb) {
  const MeshFaults faults = inspect(glb);
  EXPECT_EQ(faults.notFinite, 0U);
  EXPECT_EQ(faults.normalsNotUnit, 0U);
  EXPECT_EQ(faults.indicesOutside, 0U);
  EXPECT_EQ(faults.turnedInward, 0U);
  EXPECT_EQ(faults.boundsWrong, 0U);
}

std::string take(Result<std::string> result) {
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().text());
  return result.ok() ? std::move(result).value() : std::string();
}

TEST(PowerPlant, HasThePapersShape) {
  for (const std::uint64_t seed : {1U, 2U, 99U}) {
    const std::string bytes = take(makePowerPlantGlb({.seed = seed}));
    const Census c = census(parse(bytes));
    EXPECT_EQ(c.nodes, 5037U);
    EXPECT_EQ(c.groups, 1118U);
    EXPECT_EQ(c.leaves, 3919U);
    EXPECT_GE(c.leastChildren, 2U);
  }
}

TEST(PowerPlant, KeepsTheTriangleBudget) {
  for (const std::uint64_t triangles : {110'000U, 130'000U, 200'000U, 510'000U, 2'000'000U}) {
    const std::string bytes = take(makePowerPlantGlb({.triangles = triangles}));
    const Glb glb = parse(bytes);
    const Census c = census(glb);
    EXPECT_EQ(c.leaves, 3919U);
    EXPECT_NEAR(static_cast<double>(c.triangles), static_cast<double>(triangles),
                0.01 * static_cast<double>(triangles));
    expectSound(glb);
  }
}

TEST(PowerPlant, SameSeedSameBytes) {
  const std::string first = take(makePowerPlantGlb({.seed = 7}));
  EXPECT_EQ(first, take(makePowerPlantGlb({.seed = 7})));
  EXPECT_NE(first, take(makePowerPlantGlb({.seed = 8})));
}

TEST(PowerPlant, StandsOnTheGround) {
  const std::string bytes = take(makePowerPlantGlb({}));
  const Glb glb = parse(bytes);
  // Leaves are only turned and shifted, so the tallest mesh bounds no more than the plant is high.
  for (const json& node : glb.doc["nodes"])
    EXPECT_FALSE(node.contains("scale"));
  for (const json& accessor : glb.doc["accessors"]) {
    if (!accessor.contains("max")) continue;
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_LE(accessor["max"][k].get<double>(), 310);
  }
}

TEST(Fatehpur, HasThePapersShape) {
  for (const std::uint64_t seed : {1U, 2U, 77U}) {
    const std::string bytes = take(makeFatehpurGlb({.seed = seed, .triangles = 200'000}));
    const Census c = census(parse(bytes));
    EXPECT_EQ(c.nodes, 770U);
    EXPECT_EQ(c.groups, 288U);
    EXPECT_EQ(c.leaves, 482U);
    EXPECT_GE(c.leastChildren, 2U);
  }
}

TEST(Fatehpur, KeepsTheTriangleBudget) {
  for (const std::uint64_t triangles : {100'000U, 400'000U, 1'600'000U}) {
    const std::string bytes = take(makeFatehpurGlb({.triangles = triangles}));
    const Glb glb = parse(bytes);
    const Census c = census(glb);
    EXPECT_EQ(c.leaves, 482U);
    EXPECT_NEAR(static_cast<double>(c.triangles), static_cast<double>(triangles),
                0.01 * static_cast<double>(triangles));
    expectSound(glb);
  }
}

TEST(Fatehpur, SameSeedSameBytes) {
  const std::string first = take(makeFatehpurGlb({.seed = 7, .triangles = 150'000}));
  EXPECT_EQ(first, take(makeFatehpurGlb({.seed = 7, .triangles = 150'000})));
  EXPECT_NE(first, take(makeFatehpurGlb({.seed = 8, .triangles = 150'000})));
}

TEST(City, HasExactlyTheLeavesAskedFor) {
  for (const std::uint64_t leaves : {10U, 15U, 16U, 17U, 31U, 33U, 100U, 1000U, 4097U, 50'000U}) {
    const std::string bytes = take(makeCityGlb({.leaves = leaves}));
    const Glb glb = parse(bytes);
    const Census c = census(glb);
    EXPECT_EQ(c.leaves, leaves);
    EXPECT_GE(c.leastChildren, 2U);
    EXPECT_LT(glb.doc["meshes"].size(), 200U);
    expectSound(glb);
  }
}

TEST(City, SameSeedSameBytes) {
  const std::string first = take(makeCityGlb({.seed = 7, .leaves = 2000}));
  EXPECT_EQ(first, take(makeCityGlb({.seed = 7, .leaves = 2000})));
  EXPECT_NE(first, take(makeCityGlb({.seed = 8, .leaves = 2000})));
}

TEST(City, StaysSmall) {
  const std::string bytes = take(makeCityGlb({.leaves = 100'000}));
  // A million leaves shall stay below 200 MB.
  EXPECT_LT(bytes.size(), 20'000'000U);
}

TEST(Synthetic, RefusesWhatItCannotMake) {
  const auto refused = [](const Result<std::string>& result, const std::string& range) {
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().kind, ErrorKind::Input);
    EXPECT_NE(result.error().text().find(range), std::string::npos) << result.error().text();
  };
  refused(makePowerPlantGlb({.triangles = 0}), "110000");
  refused(makePowerPlantGlb({.triangles = ~0ULL}), "30000000");
  refused(makeFatehpurGlb({.triangles = 99'999}), "100000");
  refused(makeFatehpurGlb({.triangles = 30'000'001}), "30000000");
  refused(makeCityGlb({.leaves = 9}), "10");
  refused(makeCityGlb({.leaves = 1'000'001}), "1000000");
}

/// Six times the volume that the triangles enclose; positive where they turn outward.
double sixVolumes(const synthetic::Mesh& mesh) {
  double sum = 0;
  const auto corner = [&](std::size_t i) {
    const auto& p = mesh.positions[mesh.indices[i]];
    return Vec3(p[0], p[1], p[2]);
  };
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    sum += corner(i).dot(corner(i + 1).cross(corner(i + 2)));
  }
  return sum;
}

TEST(Shapes, BuildWhatTheyCountAndTurnOutward) {
  using namespace synthetic;
  const std::vector<Curve> outline = {line({0, 0}, {2, 0}), line({2, 0}, {2, 1}), arc({1, 1}, {1, 1}, 0, kPi),
                                      line({0, 1}, {0, 0})};
  const std::vector<Curve> profile = {arc({0, 1}, {1, 1}, -kPi / 2, 0), line({1, 1}, {1, 3}),
                                      line({1, 3}, {0, 3})};
  const Shape shapes[] = {Box{.min = {-1, -2, -3}, .max = {1, 2, 3}},
                          Lathe{profile},
                          Lathe{{arc({2, 0}, {0.5, 0.5}, -kPi, kPi)}},
                          Extrusion{.outline = outline, .depthM = 2},
                          Stairs{},
                          Jali{},
                          ArchBay{}};
  for (const double level : {0.0, 0.3, 1.0, 3.0}) {
    for (const Shape& shape : shapes) {
      const Part part{
          .shape = shape, .placement = at({5, 6, 7}, turnY(0.7)), .repeat = {.count = 2, .stepM = {9, 0, 0}}};
      const Detail detail{.level = level, .dither = 0.4};
      Mesh mesh;
      build(part, detail, mesh);
      EXPECT_EQ(mesh.triangleCount(), triangleCount(part, detail)) << shape.index() << " at " << level;
      // Stairs and bays stand on the ground and have no underside; seen from there it adds nothing.
      Mesh local;
      build({.shape = shape, .placement = {}, .repeat = {}}, detail, local);
      EXPECT_GT(sixVolumes(local), 0) << shape.index() << " at " << level;
    }
  }
}

TEST(Shapes, SphereHasItsVolume) {
  using namespace synthetic;
  Mesh mesh;
  build({.shape = Lathe{{arc({0, 0}, {1, 1}, -kPi / 2, kPi / 2)}}, .placement = {}, .repeat = {}},
        {.level = 8}, mesh);
  EXPECT_NEAR(sixVolumes(mesh) / 6, 4.0 / 3 * kPi, 0.01);
}

TEST(Shapes, ElbowMeetsThePipesItJoins) {
  using namespace synthetic;
  Mesh mesh;
  build({.shape = Elbow{.pipeRadiusM = 0.1, .bendRadiusM = 0.3}, .placement = {}, .repeat = {}}, {.level = 1},
        mesh);
  double lowest = 1;
  double farthest = 0;
  for (const auto& p : mesh.positions) {
    lowest = std::min<double>(lowest, p[1]);
    farthest = std::max<double>(farthest, p[0]);
  }
  EXPECT_NEAR(lowest, 0, 1e-6);
  EXPECT_NEAR(farthest, 0.3, 1e-6);
}

TEST(Shapes, TriangulatesAConcavePolygon) {
  const std::vector<synthetic::Vec2> letterL = {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}};
  double area = 0;
  const auto triangles = synthetic::triangulate(letterL);
  EXPECT_EQ(triangles.size(), 4U);
  for (const auto& [a, b, c] : triangles) {
    const synthetic::Vec2 u = letterL[b] - letterL[a];
    const synthetic::Vec2 v = letterL[c] - letterL[a];
    const double twice = u.x() * v.y() - u.y() * v.x();
    EXPECT_GT(twice, 0);
    area += twice / 2;
  }
  EXPECT_DOUBLE_EQ(area, 5);
}

TEST(Trig, AgreesWithTheLibrary) {
  for (double angleRad = -20; angleRad < 20; angleRad += 0.0137) {
    const synthetic::SinCos a = synthetic::sinCos(angleRad);
    EXPECT_NEAR(a.sin, std::sin(angleRad), 1e-15);
    EXPECT_NEAR(a.cos, std::cos(angleRad), 1e-15);
  }
}

}  // namespace
}  // namespace tessera
