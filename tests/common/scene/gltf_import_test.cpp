#include <cmath>

#include <gtest/gtest.h>
#include <osg/FrontFace>
#include <osg/Material>

#include "common/scene/gltf/import_gltf.h"
#include "tests/common/scene/gltf_builder.h"

namespace tessera::test {
namespace {

using nlohmann::json;

// ---- shape of the graph

TEST(GltfImport, keepsNodesNamesOrderAndSources) {
  GltfBuilder file = triangleFile();
  file.json["scenes"][0]["name"] = "hall";
  file.json["nodes"][0]["name"] = "first";
  file.json["nodes"][0]["children"] = {1, 2};
  file.add("nodes", {{"mesh", 0}, {"translation", {1, 2, 3}}});
  file.add("nodes", {{"name", "empty"}});
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_EQ(graph->root->getName(), "hall");
  const osg::Group* first = nodeAt(*graph, 0);
  EXPECT_EQ(first->getName(), "first");
  EXPECT_EQ(first->asTransform(), nullptr);
  ASSERT_EQ(first->getNumChildren(), 3U);
  EXPECT_NE(first->getChild(0)->asGeometry(), nullptr);
  const auto* moved = dynamic_cast<const osg::MatrixTransform*>(first->getChild(1));
  ASSERT_NE(moved, nullptr);
  EXPECT_EQ(moved->getName(), "");
  EXPECT_EQ(moved->getMatrix().getTrans(), osg::Vec3d(1, 2, 3));
  EXPECT_EQ(first->getChild(2)->getName(), "empty");
  EXPECT_EQ(moved->getChild(0), first->getChild(0)) << "one mesh, one geometry";
  EXPECT_EQ(graph->gltfSources.at(first).node, 0);
  EXPECT_EQ(graph->gltfSources.at(moved).node, 1);
  EXPECT_EQ(graph->gltfSources.at(moved).primitives, std::vector<int>{0});
  EXPECT_TRUE(graph->gltfSources.at(first->getChild(2)).primitives.empty());
  EXPECT_TRUE(graph->warnings.empty());
}

TEST(GltfImport, skipsPrimitivesThatDrawNothingAndKeepsTheOthersNumbers) {
  GltfBuilder file = triangleFile();
  json& primitives = file.json["meshes"][0]["primitives"];
  file.add("accessors", {{"componentType", kFloat}, {"count", 0}, {"type", "VEC3"}});
  primitives.insert(primitives.begin(), json({{"attributes", json::object()}}));
  primitives.insert(primitives.begin() + 1, json({{"attributes", {{"POSITION", 1}}}}));
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_EQ(graph->gltfSources.at(nodeAt(*graph, 0)).primitives, std::vector<int>{2});
  EXPECT_TRUE(warns(*graph, "mesh 0 primitive 0 has no POSITION"));
  EXPECT_TRUE(warns(*graph, "mesh 0 primitive 1 has 0 vertices"));
}

TEST(GltfImport, takesTheDefaultSceneOrAllRoots) {
  GltfBuilder file = triangleFile();
  file.add("nodes", {{"name", "other"}});
  file.add("scenes", {{"nodes", {1}}});
  file.json["scene"] = 1;
  auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_EQ(nodeAt(*graph, 0)->getName(), "other");
  file.json.erase("scene");
  file.json.erase("scenes");
  graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_EQ(graph->root->getNumChildren(), 2U);
  EXPECT_TRUE(warns(*graph, "no scene"));
}

TEST(GltfImport, readsTransforms) {
  GltfBuilder file;
  const double h = std::sqrt(0.5);
  file.add("nodes", {{"translation", {10, 20, 30}}, {"rotation", {0, 0, h, h}}, {"scale", {2, 3, 4}}});
  file.add("nodes", {{"matrix", {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 10, 20, 30, 1}}});
  file.add("nodes", {{"rotation", {0, 0, 2, 2}}});
  file.add("nodes", {{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});
  file.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  for (unsigned int i = 0; i < 2; ++i) {
    const osg::Matrixd& m = dynamic_cast<osg::MatrixTransform&>(*nodeAt(*graph, i)).getMatrix();
    const osg::Vec3d moved = osg::Vec3d(1, 1, 1) * m;  // scaled (2,3,4), turned (-3,2,4), moved
    EXPECT_NEAR((moved - osg::Vec3d(7, 22, 34)).length(), 0, 1e-12) << i;
  }
  const osg::Matrixd& turned = dynamic_cast<osg::MatrixTransform&>(*nodeAt(*graph, 2)).getMatrix();
  EXPECT_NEAR((osg::Vec3d(1, 0, 0) * turned - osg::Vec3d(0, 1, 0)).length(), 0, 1e-12);
  EXPECT_TRUE(warns(*graph, "node 2 has a rotation of length"));
  EXPECT_EQ(nodeAt(*graph, 3)->asTransform(), nullptr);
}

TEST(GltfImport, survivesADeepTree) {
  constexpr int kDepth = 250000;  // 100,000 of them OSG itself can take apart within 8 MiB of stack
  GltfBuilder file = triangleFile();
  file.json["nodes"] = json::array();
  for (int i = 0; i + 1 < kDepth; ++i)
    file.add("nodes", {{"children", {i + 1}}});
  file.add("nodes", {{"mesh", 0}});
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  const SceneFigures figures = figuresOf(*graph);
  EXPECT_EQ(figures.nodes, static_cast<std::size_t>(kDepth));
  EXPECT_EQ(figures.leaves, 1U);
}

TEST(GltfImport, keepsWhatOthersHoldWhenTheGraphGoes) {
  osg::ref_ptr<osg::Node> held;
  {
    const auto graph = triangleFile().import();
    ASSERT_TRUE(graph) << errorOf(graph);
    held = nodeAt(*graph, 0);
  }
  EXPECT_EQ(held->asGroup()->getNumChildren(), 1U);
}

TEST(GltfImport, manyParentsOfOneMeshStayLinear) {
  GltfBuilder file = triangleFile();
  json nodes = json::array();
  for (int i = 0; i < 200000; ++i) {
    nodes.push_back({{"mesh", 0}});
    if (i > 0) file.json["scenes"][0]["nodes"].push_back(i);
  }
  file.json["nodes"] = std::move(nodes);
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_LE(leafAt(*graph)->getNumParents(), 4096U);
  EXPECT_LE(leafAt(*graph)->getStateSet()->getNumParents(), 4096U);
  EXPECT_EQ(leafAt(*graph, 0)->getVertexArray(), leafAt(*graph, 199999)->getVertexArray());
}

TEST(GltfImport, flipsTheWindingOfMirroredNodes) {
  GltfBuilder file = triangleFile();
  file.add("nodes", {{"scale", {-1, 1, 1}}, {"children", {2}}});
  file.add("nodes", {{"mesh", 0}, {"children", {3}}});
  file.add("nodes", {{"mesh", 0}, {"scale", {1, 1, -2}}, {"children", {4}}});
  file.add("nodes", {{"mesh", 0}, {"scale", {1e-200, 1e-200, -1e-200}}});
  file.json["scenes"][0]["nodes"] = {0, 1};
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  const osg::Geometry* plain = leafAt(*graph);
  const osg::Group* mirror = nodeAt(*graph, 1)->getChild(0)->asGroup();
  const osg::Geometry* mirrored = mirror->getChild(0)->asGeometry();
  const osg::Group* back = mirror->getChild(1)->asGroup();
  EXPECT_NE(plain, mirrored);
  EXPECT_EQ(plain->getVertexArray(), mirrored->getVertexArray());
  EXPECT_EQ(plain->getStateSet()->getAttribute(osg::StateAttribute::FRONTFACE), nullptr);
  const auto* face = dynamic_cast<const osg::FrontFace*>(
      mirrored->getStateSet()->getAttribute(osg::StateAttribute::FRONTFACE));
  ASSERT_NE(face, nullptr);
  EXPECT_EQ(face->getMode(), osg::FrontFace::CLOCKWISE);
  EXPECT_EQ(back->getChild(0), plain) << "mirrored twice";
  EXPECT_EQ(back->getChild(1)->asGroup()->getChild(0), mirrored) << "the mirrored copy is shared too";
}

// ---- drawing modes and indices

TEST(GltfImport, readsEveryMode) {
  const std::vector<float> ring = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  const std::vector<float> up = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  for (int mode = 0; mode <= 6; ++mode) {
    for (const bool isIndexed : {false, true}) {
      GltfBuilder file;
      file.accessor(ring, "VEC3", kFloat);
      file.accessor(up, "VEC3", kFloat);
      json primitive = {{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}, {"mode", mode}};
      if (isIndexed)
        primitive["indices"] = file.accessor(std::vector<std::uint16_t>{0, 1, 2, 3}, "SCALAR", kUShort);
      file.addPrimitive(primitive);
      const auto graph = file.import();
      ASSERT_TRUE(graph) << errorOf(graph);
      const osg::PrimitiveSet* set = leafAt(*graph)->getPrimitiveSet(0);
      EXPECT_EQ(set->getMode(), static_cast<GLenum>(mode));
      EXPECT_EQ(set->getNumIndices(), mode == 4 ? 3U : 4U);
      EXPECT_EQ(warns(*graph, "left over") || warns(*graph, "the last 1"), mode == 4);
      EXPECT_EQ(leafAt(*graph)->getStateSet()->getMode(GL_LIGHTING), osg::StateAttribute::ON);
    }
  }
}

TEST(GltfImport, drawsPointsAndLinesWithoutNormalsUnlit) {
  for (int mode = 0; mode <= 3; ++mode) {
    GltfBuilder file = triangleFile();
    file.json["meshes"][0]["primitives"][0]["mode"] = mode;
    const auto graph = file.import();
    ASSERT_TRUE(graph) << errorOf(graph);
    EXPECT_EQ(leafAt(*graph)->getStateSet()->getMode(GL_LIGHTING), osg::StateAttribute::OFF);
    EXPECT_EQ(leafAt(*graph)->getNormalArray(), nullptr);
  }
}

TEST(GltfImport, readsIndicesOfEveryWidthAndDropsUnusedVertices) {
  const std::vector<float> four = {9, 9, 9, 0, 0, 0, 1, 0, 0, 0, 1, 0};
  for (const int type : {kUByte, kUShort, kUInt}) {
    GltfBuilder file;
    file.accessor(four, "VEC3", kFloat);
    if (type == kUByte) file.accessor(std::vector<std::uint8_t>{1, 2, 3}, "SCALAR", type);
    if (type == kUShort) file.accessor(std::vector<std::uint16_t>{1, 2, 3}, "SCALAR", type);
    if (type == kUInt) file.accessor(std::vector<std::uint32_t>{1, 2, 3}, "SCALAR", type);
    file.addPrimitive({{"attributes", {{"POSITION", 0}}}, {"indices", 1}});
    const auto graph = file.import();
    ASSERT_TRUE(graph) << errorOf(graph);
    EXPECT_EQ(positionsOf(*leafAt(*graph)).size(), 3U);
    EXPECT_EQ(positionsOf(*leafAt(*graph))[1], osg::Vec3f(1, 0, 0));
    EXPECT_EQ(leafAt(*graph)->getPrimitiveSet(0)->index(2), 2U);
  }
}

TEST(GltfImport, picksAFewVerticesOfAHugeAccessor) {
  GltfBuilder file;
  std::vector<float> many(300000);
  for (std::size_t i = 0; i < many.size(); ++i)
    many[i] = static_cast<float>(i * i % 1013);
  file.accessor(many, "VEC3", kFloat);
  file.accessor(std::vector<std::uint32_t>{99999, 5, 70000, 5, 70000, 3}, "SCALAR", kUInt);
  file.addPrimitive({{"attributes", {{"POSITION", 0}, {"NORMAL", 0}}}, {"indices", 1}});
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  const osg::Geometry& g = *leafAt(*graph);
  EXPECT_EQ(positionsOf(g).size(), 4U);
  const std::vector<std::size_t> wanted = {99999, 5, 70000, 5, 70000, 3};
  for (unsigned int i = 0; i < 6; ++i) {
    EXPECT_EQ(positionsOf(g)[g.getPrimitiveSet(0)->index(i)].x(), many[3 * wanted[i]]);
  }
}

TEST(GltfImport, usesWideIndicesOnlyWhereNeeded) {
  for (const std::uint32_t count : {65536U, 65537U}) {
    GltfBuilder file;
    std::vector<float> line(std::size_t{3} * count);
    std::vector<std::uint32_t> indices(count);
    for (std::uint32_t i = 0; i < count; ++i)
      indices[i] = i;
    file.accessor(line, "VEC3", kFloat);
    file.accessor(indices, "SCALAR", kUInt);
    file.addPrimitive({{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"mode", 0}});
    const auto graph = file.import();
    ASSERT_TRUE(graph) << errorOf(graph);
    const auto* set = leafAt(*graph)->getPrimitiveSet(0);
    EXPECT_EQ(dynamic_cast<const osg::DrawElementsUShort*>(set) != nullptr, count == 65536);
    EXPECT_EQ(set->index(count - 1), count - 1);
  }
}

// ---- accessors

template <class T>
void expectPositions(int componentType, bool isNormalized, const std::vector<T>& values,
                     const std::vector<float>& wanted) {
  GltfBuilder file;
  file.accessor(values, "VEC3", componentType, isNormalized);
  file.addPrimitive({{"attributes", {{"POSITION", 0}}}, {"mode", 0}});
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  const osg::Vec3Array& got = positionsOf(*leafAt(*graph));
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    EXPECT_EQ(got[i / 3].ptr()[i % 3], wanted[i]) << componentType << " " << i;
  }
}

TEST(GltfAccessors, readEveryComponentTypeOfPositions) {
  expectPositions<float>(kFloat, false, {1.5F, -2, 3}, {1.5F, -2, 3});
  expectPositions<std::int8_t>(kByte, false, {-128, 127, 3}, {-128, 127, 3});
  expectPositions<std::uint8_t>(kUByte, false, {255, 0, 3}, {255, 0, 3});
  expectPositions<std::int16_t>(kShort, false, {-32768, 32767, 3}, {-32768, 32767, 3});
  expectPositions<std::uint16_t>(kUShort, false, {65535, 0, 3}, {65535, 0, 3});
  expectPositions<std::int8_t>(kByte, true, {-128, 127, 3}, {-1, 1, 3.0F / 127});
  expectPositions<std::uint8_t>(kUByte, true, {255, 0, 3}, {1, 0, 3.0F / 255});
  expectPositions<std::int16_t>(kShort, true, {-32768, 32767, -3}, {-1, 1, -3.0F / 32767});
  expectPositions<std::uint16_t>(kUShort, true, {65535, 0, 3}, {1, 0, 3.0F / 65535});
}

TEST(GltfAccessors, readStridedUnalignedAndInterleavedElements) {
  GltfBuilder file;
  std::vector<unsigned char> bytes(3 + 2 * 20 + 12);
  const std::vector<float> values = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  for (std::size_t i = 0; i < 3; ++i)
    std::memcpy(bytes.data() + 3 + i * 20, values.data() + 3 * i, 12);
  file.add("accessors", {{"bufferView", file.view(bytes)},
                         {"byteOffset", 3},
                         {"componentType", kFloat},
                         {"count", 3},
                         {"type", "VEC3"}});
  file.json["bufferViews"][0]["byteStride"] = 20;
  file.addPrimitive({{"attributes", {{"POSITION", 0}}}});
  auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_EQ(positionsOf(*leafAt(*graph))[2], osg::Vec3f(0, 1, 0));
  file.json["accessors"][0]["byteOffset"] = 4;
  EXPECT_NE(errorOf(file.import()).find("accessor 0 reaches past the end of buffer view 0"),
            std::string::npos);
}

TEST(GltfAccessors, applySparseParts) {
  for (const bool hasBase : {true, false}) {
    GltfBuilder file = triangleFile();
    json& accessor = file.json["accessors"][0];
    if (!hasBase) accessor.erase("bufferView");
    const int indices = file.view(std::vector<std::uint16_t>{0, 2});
    const int values = file.view(std::vector<float>{-1, -1, -1, 7, 8, 9});
    file.json["accessors"][0]["sparse"] = {{"count", 2},
                                           {"indices", {{"bufferView", indices}, {"componentType", kUShort}}},
                                           {"values", {{"bufferView", values}}}};
    const auto graph = file.import();
    ASSERT_TRUE(graph) << errorOf(graph);
    const osg::Vec3Array& got = positionsOf(*leafAt(*graph));
    EXPECT_EQ(got[0], osg::Vec3f(-1, -1, -1));
    EXPECT_EQ(got[1], hasBase ? osg::Vec3f(1, 0, 0) : osg::Vec3f());
    EXPECT_EQ(got[2], osg::Vec3f(7, 8, 9));
  }
}

TEST(GltfAccessors, withoutABufferViewAreZeros) {
  GltfBuilder file = triangleFile();
  file.json["accessors"][0].erase("bufferView");
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_EQ(positionsOf(*leafAt(*graph))[1], osg::Vec3f());
}

// ---- normals and colours

TEST(GltfImport, makesFlatNormals) {
  // A quad in z = 0 and a third triangle that stands up on one of its edges.
  GltfBuilder file;
  file.accessor(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1}, "VEC3", kFloat);
  file.accessor(std::vector<std::uint8_t>{0, 1, 2, 0, 2, 3, 0, 3, 4}, "SCALAR", kUByte);
  file.addPrimitive({{"attributes", {{"POSITION", 0}}}, {"indices", 1}});
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  const osg::Geometry& g = *leafAt(*graph);
  EXPECT_EQ(positionsOf(g).size(), 7U) << "the quad keeps four vertices, the third triangle has its own";
  const auto& normals = dynamic_cast<const osg::Vec3Array&>(*g.getNormalArray());
  for (unsigned int i = 0; i < 9; ++i) {
    const osg::Vec3f wanted = i < 6 ? osg::Vec3f(0, 0, 1) : osg::Vec3f(1, 0, 0);
    EXPECT_NEAR((normals[g.getPrimitiveSet(0)->index(i)] - wanted).length(), 0, 1e-6) << i;
  }
}

TEST(GltfImport, makesFlatNormalsForStripsFansAndUnindexedTriangles) {
  const std::vector<float> strip = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  const std::vector<float> fan = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  for (const int mode : {4, 5, 6}) {
    GltfBuilder file;
    std::vector<float> points = mode == 5 ? strip : fan;
    if (mode == 4) points.resize(9);
    file.accessor(points, "VEC3", kFloat);
    file.addPrimitive({{"attributes", {{"POSITION", 0}}}, {"mode", mode}});
    const auto graph = file.import();
    ASSERT_TRUE(graph) << errorOf(graph);
    const osg::Geometry& g = *leafAt(*graph);
    EXPECT_EQ(figuresOf(*graph).triangles, mode == 4 ? 1U : 2U);
    for (const osg::Vec3f& n : dynamic_cast<const osg::Vec3Array&>(*g.getNormalArray())) {
      EXPECT_EQ(n, osg::Vec3f(0, 0, 1)) << mode;
    }
  }
}

TEST(GltfImport, showsLinearColoursInSrgb) {
  GltfBuilder file = triangleFile();
  file.add("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0, 0.0021404, 0.25}}}},
                         {"emissiveFactor", {0, 1, 0}}});
  json& primitive = file.json["meshes"][0]["primitives"][0];
  primitive["material"] = 0;
  auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_EQ(overallColor(*leafAt(*graph)), osg::Vec4ub(188, 0, 7, 255)) << "opaque: alpha is ignored";
  const auto* shading = dynamic_cast<const osg::Material*>(
      leafAt(*graph)->getStateSet()->getAttribute(osg::StateAttribute::MATERIAL));
  ASSERT_NE(shading, nullptr);
  EXPECT_EQ(shading->getColorMode(), osg::Material::AMBIENT_AND_DIFFUSE);
  EXPECT_EQ(shading->getEmission(osg::Material::FRONT), osg::Vec4f(0, 1, 0, 1));

  primitive["attributes"]["COLOR_0"] = file.accessor(
      std::vector<std::uint8_t>{255, 255, 255, 255, 0, 0, 0, 0, 255, 9, 9, 102}, "VEC4", kUByte, true);
  file.json["materials"][0]["alphaMode"] = "BLEND";
  graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  const auto& colors = dynamic_cast<const osg::Vec4ubArray&>(*leafAt(*graph)->getColorArray());
  EXPECT_EQ(colors.getBinding(), osg::Array::BIND_PER_VERTEX);
  EXPECT_TRUE(colors.getNormalize());
  EXPECT_EQ(colors[0], osg::Vec4ub(188, 0, 7, 64));
  EXPECT_EQ(colors[1], osg::Vec4ub(0, 0, 0, 0));
  EXPECT_EQ(colors[2].a(), 26);
}

TEST(GltfImport, readsVertexColoursOfEveryType) {
  for (const int type : {kFloat, kUByte, kUShort}) {
    GltfBuilder file = triangleFile();
    int color = 0;
    if (type == kFloat) color = file.accessor(std::vector<float>{1, 0, 2, 1, 0, 2, 1, 0, 2}, "VEC3", type);
    if (type == kUByte) {
      color =
          file.accessor(std::vector<std::uint8_t>{255, 0, 255, 255, 0, 255, 255, 0, 255}, "VEC3", type, true);
    }
    if (type == kUShort) {
      const std::uint16_t m = 65535;
      color = file.accessor(std::vector<std::uint16_t>{m, 0, m, m, 0, m, m, 0, m}, "VEC3", type, true);
    }
    file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = color;
    const auto graph = file.import();
    ASSERT_TRUE(graph) << errorOf(graph);
    const auto& colors = dynamic_cast<const osg::Vec4ubArray&>(*leafAt(*graph)->getColorArray());
    EXPECT_EQ(colors[2], osg::Vec4ub(255, 0, 255, 255)) << type;
  }
}

TEST(GltfImport, readsNormalsOfEveryType) {
  for (const int type : {kFloat, kByte, kShort}) {
    GltfBuilder file = triangleFile();
    int normal = 0;
    if (type == kFloat) normal = file.accessor(std::vector<float>{1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3", type);
    if (type == kByte) {
      normal = file.accessor(std::vector<std::int8_t>{127, 0, 0, 127, 0, 0, 127, 0, 0}, "VEC3", type, true);
    }
    if (type == kShort) {
      normal =
          file.accessor(std::vector<std::int16_t>{32767, 0, 0, 32767, 0, 0, 32767, 0, 0}, "VEC3", type, true);
    }
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normal;
    const auto graph = file.import();
    ASSERT_TRUE(graph) << errorOf(graph);
    EXPECT_EQ(dynamic_cast<const osg::Vec3Array&>(*leafAt(*graph)->getNormalArray())[1], osg::Vec3f(1, 0, 0));
  }
}

}  // namespace
}  // namespace tessera::test
