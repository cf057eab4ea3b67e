#include "common/scene/cut_drawable.h"

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <osg/Billboard>
#include <osg/MatrixTransform>
#include <osg/Point>
#include <osg/TriangleIndexFunctor>

#include "common/scene/extract.h"
#include "tests/common/scene/grid_mesh.h"

namespace tessera {
namespace {

using Index3 = std::array<unsigned int, 3>;
/// A vertex is the bytes of all its attributes.
using Corners = std::array<std::string, 3>;

struct IndexSink {
  std::vector<Index3> triangles;
  void operator()(unsigned int a, unsigned int b, unsigned int c) { triangles.push_back({a, b, c}); }
};

std::vector<Index3> indicesOf(const osg::Geometry& mesh) {
  osg::TriangleIndexFunctor<IndexSink> sink;
  mesh.accept(sink);
  return sink.triangles;
}

std::string vertexOf(const osg::Geometry& mesh, unsigned int vertex) {
  osg::Geometry::ArrayList arrays;
  mesh.getArrayList(arrays);
  std::string bytes;
  for (const auto& array : arrays) {
    const unsigned int i = array->getBinding() == osg::Array::BIND_OVERALL ? 0 : vertex;
    bytes.append(static_cast<const char*>(array->getDataPointer(i)), array->getElementSize());
    bytes += array->className();
  }
  return bytes;
}

/// The triangles with all attributes, each from its smallest corner on so that winding alone counts; sorted.
std::vector<Corners> trianglesFrom(const osg::Geometry& mesh, const std::vector<Index3>& indices) {
  std::vector<Corners> all;
  for (const auto& [a, b, c] : indices) {
    Corners corners = {vertexOf(mesh, a), vertexOf(mesh, b), vertexOf(mesh, c)};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    all.push_back(std::move(corners));
  }
  std::sort(all.begin(), all.end());
  return all;
}

std::vector<Corners> trianglesOfParts(const CutTree& tree) {
  std::vector<Corners> all;
  for (const auto& part : tree.parts) {
    const std::vector<Corners> some = trianglesFrom(*part, indicesOf(*part));
    all.insert(all.end(), some.begin(), some.end());
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// One set of indexed triangles, and every vertex used: the first time in ascending order.
void expectCompact(const osg::Geometry& part) {
  ASSERT_EQ(part.getNumPrimitiveSets(), 1U);
  EXPECT_EQ(part.getPrimitiveSet(0)->getMode(), GLenum{GL_TRIANGLES});
  unsigned int next = 0;
  for (const Index3& triangle : indicesOf(part)) {
    for (const unsigned int i : triangle) {
      ASSERT_LE(i, next);
      next = std::max(next, i + 1);
    }
  }
  EXPECT_EQ(next, part.getVertexArray()->getNumElements());
}

void expectWhole(const osg::Geometry& mesh, std::uint64_t max, const std::vector<Index3>& expected) {
  const auto tree = cutDrawable(mesh, max);
  ASSERT_TRUE(tree);
  EXPECT_GE(tree->parts.size(), (expected.size() + max - 1) / max);
  for (const auto& part : tree->parts) {
    EXPECT_LE(indicesOf(*part).size(), max);
    expectCompact(*part);
  }
  EXPECT_EQ(trianglesOfParts(*tree), trianglesFrom(mesh, expected));
}

void expectWhole(const osg::Geometry& mesh, std::uint64_t max) {
  expectWhole(mesh, max, indicesOf(mesh));
}

template <class ArrayType>
osg::ref_ptr<ArrayType> perVertex(unsigned int count, typename ArrayType::ElementDataType (*make)(unsigned)) {
  osg::ref_ptr<ArrayType> array = new ArrayType(osg::Array::BIND_PER_VERTEX);
  for (unsigned int i = 0; i < count; ++i)
    array->push_back(make(i));
  return array;
}

osg::ref_ptr<osg::Geometry> richMesh() {
  osg::ref_ptr<osg::Geometry> mesh = gridMesh(6);
  const unsigned int count = mesh->getVertexArray()->getNumElements();
  mesh->setNormalArray(
      perVertex<osg::Vec3Array>(count, [](unsigned i) { return osg::Vec3(static_cast<float>(i), 1, 2); }));
  osg::ref_ptr<osg::Vec4ubArray> colors = perVertex<osg::Vec4ubArray>(
      count, [](unsigned i) { return osg::Vec4ub(static_cast<GLubyte>(i), 7, 8, 9); });
  colors->setNormalize(true);
  mesh->setColorArray(colors);
  mesh->setSecondaryColorArray(perVertex<osg::Vec3Array>(
      count, [](unsigned i) { return osg::Vec3(0, static_cast<float>(i) * 0.5F, 0); }));
  mesh->setFogCoordArray(
      perVertex<osg::FloatArray>(count, [](unsigned i) { return static_cast<float>(i) + 0.25F; }));
  mesh->setTexCoordArray(
      0, perVertex<osg::Vec2Array>(count, [](unsigned i) { return osg::Vec2(0, static_cast<float>(i)); }));
  mesh->setTexCoordArray(
      2, perVertex<osg::Vec3dArray>(count, [](unsigned i) { return osg::Vec3d(double(i) / 3, 0, 1); }));
  mesh->setVertexAttribArray(5, perVertex<osg::Vec4sArray>(count, [](unsigned i) {
                               return osg::Vec4s(static_cast<GLshort>(i), 3, 2, 1);
                             }));
  return mesh;
}

/// Vertices in two rows, as a strip has them; doubles far from the origin.
osg::ref_ptr<osg::Geometry> band(unsigned int columns) {
  osg::ref_ptr<osg::Geometry> mesh = new osg::Geometry;
  osg::ref_ptr<osg::Vec3dArray> vertices = new osg::Vec3dArray;
  for (unsigned int i = 0; i < 2 * columns; ++i)
    vertices->push_back(osg::Vec3d(1e6 + i / 2 + 1e-7, i % 2, 0.1 * i));
  mesh->setVertexArray(vertices);
  return mesh;
}

TEST(CutDrawable, PartsTogetherAreTheWholeWithEveryAttribute) {
  for (const std::uint64_t max : {1, 2, 7, 40, 71})
    expectWhole(*richMesh(), max);
}

TEST(CutDrawable, StripsFansAndPolygonsKeepTheirWinding) {
  for (const GLenum mode : {GL_TRIANGLE_STRIP, GL_TRIANGLE_FAN, GL_POLYGON, GL_TRIANGLES}) {
    osg::ref_ptr<osg::Geometry> mesh = band(12);
    mesh->addPrimitiveSet(new osg::DrawArrays(mode, 0, 12));
    osg::ref_ptr<osg::DrawArrayLengths> lengths = new osg::DrawArrayLengths(mode, 12);
    for (const int n : {3, 9})
      lengths->push_back(n);
    mesh->addPrimitiveSet(lengths);
    osg::ref_ptr<osg::DrawElementsUByte> bytes = new osg::DrawElementsUByte(mode);
    for (const int i : {0, 5, 7, 3, 9, 11})
      bytes->push_back(static_cast<GLubyte>(i));
    mesh->addPrimitiveSet(bytes);
    expectWhole(*mesh, 3);
  }
}

TEST(CutDrawable, FlatShadingKeepsItsProvokingVertex) {
  osg::ref_ptr<osg::Geometry> mesh = band(4);
  mesh->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLE_STRIP, 0, 8));
  const auto tree = cutDrawable(*mesh, 1);
  ASSERT_TRUE(tree);
  std::vector<std::string> last;
  for (const auto& part : tree->parts)
    last.push_back(vertexOf(*part, indicesOf(*part)[0][2]));
  std::vector<std::string> expected;
  for (unsigned int i = 2; i < 8; ++i)
    expected.push_back(vertexOf(*mesh, i));
  std::sort(last.begin(), last.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(last, expected);
}

TEST(CutDrawable, QuadsAreSplitSoThatTheirLastVertexStaysTheProvokingOne) {
  osg::ref_ptr<osg::Geometry> quads = band(4);
  quads->addPrimitiveSet(new osg::DrawArrays(GL_QUADS, 0, 8));
  expectWhole(*quads, 1, {{0, 1, 3}, {1, 2, 3}, {4, 5, 7}, {5, 6, 7}});
  osg::ref_ptr<osg::Geometry> strip = band(3);
  strip->addPrimitiveSet(new osg::DrawArrays(GL_QUAD_STRIP, 0, 6));
  expectWhole(*strip, 2, {{2, 0, 3}, {0, 1, 3}, {4, 2, 5}, {2, 3, 5}});
}

TEST(CutDrawable, AnOverallColourGoesWithEveryPart) {
  osg::ref_ptr<osg::Geometry> mesh = gridMesh(5);
  osg::ref_ptr<osg::Vec4Array> color = new osg::Vec4Array;
  color->push_back(osg::Vec4(0.25F, 0.5F, 0.75F, 1));
  mesh->setColorArray(color, osg::Array::BIND_OVERALL);
  expectWhole(*mesh, 9);
  const auto tree = cutDrawable(*mesh, 9);
  for (const auto& part : tree->parts) {
    EXPECT_EQ(part->getColorArray()->getBinding(), osg::Array::BIND_OVERALL);
    EXPECT_EQ(part->getColorArray()->getNumElements(), 1U);
  }
}

TEST(CutDrawable, PartsShareStateNameAndSettings) {
  osg::ref_ptr<osg::Geometry> mesh = richMesh();
  mesh->setName("sheet");
  mesh->getOrCreateStateSet()->setAttribute(new osg::Point(3));
  mesh->setUseDisplayList(false);
  mesh->setUseVertexBufferObjects(false);
  const auto tree = cutDrawable(*mesh, 10);
  ASSERT_TRUE(tree);
  for (const auto& part : tree->parts) {
    EXPECT_EQ(part->getStateSet(), mesh->getStateSet());
    EXPECT_EQ(part->getName(), "sheet");
    EXPECT_FALSE(part->getUseDisplayList());
    EXPECT_FALSE(part->getUseVertexBufferObjects());
    EXPECT_TRUE(part->getColorArray()->getNormalize());
    EXPECT_EQ(part->getTexCoordArray(1), nullptr);
  }
}

TEST(CutDrawable, TheShapeCountsThePartsBelow) {
  const auto tree = cutDrawable(*gridMesh(9), 10);
  ASSERT_TRUE(tree);
  EXPECT_EQ(tree->shape.size(), 2 * tree->parts.size() - 1) << "a binary tree";
  ASSERT_EQ(tree->shape[0], tree->parts.size());
  // Walks the tree by the counts alone: each inner node's two children add up to it.
  std::vector<std::size_t> end(tree->shape.size());
  for (std::size_t n = tree->shape.size(); n-- > 0;) {
    end[n] = n + 1;
    if (tree->shape[n] == 1) continue;
    const std::size_t left = n + 1, right = end[left];
    end[n] = end[right];
    EXPECT_EQ(tree->shape[n], tree->shape[left] + tree->shape[right]);
  }
  EXPECT_EQ(end[0], tree->shape.size());
}

TEST(CutDrawable, CutsAcrossTheLongestAxis) {
  osg::ref_ptr<osg::Geometry> mesh = band(10);
  mesh->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLE_STRIP, 0, 20));
  const auto tree = cutDrawable(*mesh, 9);
  ASSERT_TRUE(tree);
  ASSERT_EQ(tree->parts.size(), 2U);
  EXPECT_LT(tree->parts[0]->getBoundingBox().center().x(), tree->parts[1]->getBoundingBox().center().x());
}

TEST(CutDrawable, EqualInputGivesEqualParts) {
  const auto first = cutDrawable(*richMesh(), 5), second = cutDrawable(*richMesh(), 5);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->shape, second->shape);
  ASSERT_EQ(first->parts.size(), second->parts.size());
  for (std::size_t i = 0; i < first->parts.size(); ++i) {
    const osg::Geometry &a = *first->parts[i], &b = *second->parts[i];
    EXPECT_EQ(indicesOf(a), indicesOf(b));
    EXPECT_EQ(trianglesFrom(a, indicesOf(a)), trianglesFrom(b, indicesOf(b)));
  }
}

TEST(CutDrawable, CoincidentTrianglesAreHalvedByOrder) {
  osg::ref_ptr<osg::Geometry> mesh = band(2);
  osg::ref_ptr<osg::DrawElementsUShort> indices = new osg::DrawElementsUShort(GL_TRIANGLES);
  for (int i = 0; i < 1000; ++i) {
    for (const int v : {0, 1, 2})
      indices->push_back(static_cast<GLushort>(v));
  }
  mesh->addPrimitiveSet(indices);
  expectWhole(*mesh, 10);
  EXPECT_EQ(cutDrawable(*mesh, 500)->parts.size(), 2U);
}

TEST(CutDrawable, IndicesAreAsWideAsTheyMustBe) {
  osg::ref_ptr<osg::Geometry> mesh = gridMesh(400);
  const auto wide = cutDrawable(*mesh, 200'000);
  ASSERT_TRUE(wide);
  ASSERT_EQ(wide->parts.size(), 2U);
  EXPECT_EQ(wide->parts[0]->getPrimitiveSet(0)->getType(), osg::PrimitiveSet::DrawElementsUIntPrimitiveType);
  expectCompact(*wide->parts[0]);
  const auto narrow = cutDrawable(*mesh, 1000);
  ASSERT_TRUE(narrow);
  std::size_t triangles = 0;
  for (const auto& part : narrow->parts) {
    EXPECT_EQ(part->getPrimitiveSet(0)->getType(), osg::PrimitiveSet::DrawElementsUShortPrimitiveType);
    triangles += indicesOf(*part).size();
  }
  EXPECT_EQ(triangles, 320'000U);
}

TEST(CutDrawable, ArraysByIndexAreResolvedFirst) {
  osg::ref_ptr<osg::Geometry> mesh = gridMesh(3);
  osg::ref_ptr<osg::Vec3Array> normals = new osg::Vec3Array;
  normals->push_back(osg::Vec3(0, 0, 1));
  mesh->setNormalArray(normals, osg::Array::BIND_PER_VERTEX);
  osg::ref_ptr<osg::UIntArray> indices = new osg::UIntArray(mesh->getVertexArray()->getNumElements());
  normals->setUserData(indices);  // how OpenSceneGraph 3.6 keeps deprecated indices
  ASSERT_TRUE(mesh->checkForDeprecatedData());
  const auto tree = cutDrawable(*mesh, 4);
  ASSERT_TRUE(tree);
  for (const auto& part : tree->parts)
    EXPECT_EQ(part->getNormalArray()->getNumElements(), part->getVertexArray()->getNumElements());
  EXPECT_EQ(mesh->getNormalArray()->getNumElements(), 1U) << "the original is left alone";
}

struct Uncut {
  const char* name;
  std::function<void(osg::Geometry&)> change;
};

class CutDrawableRefusal : public testing::TestWithParam<Uncut> {};

TEST_P(CutDrawableRefusal, StaysWhole) {
  osg::ref_ptr<osg::Geometry> mesh = richMesh();
  ASSERT_TRUE(cutDrawable(*mesh, 10));
  GetParam().change(*mesh);
  EXPECT_FALSE(cutDrawable(*mesh, 10));
}

INSTANTIATE_TEST_SUITE_P(
    , CutDrawableRefusal,
    testing::Values(
        Uncut{"Points", [](auto& m) { m.addPrimitiveSet(new osg::DrawArrays(GL_POINTS, 0, 3)); }},
        Uncut{"Lines", [](auto& m) { m.addPrimitiveSet(new osg::DrawArrays(GL_LINE_LOOP, 0, 3)); }},
        Uncut{"Patches", [](auto& m) { m.addPrimitiveSet(new osg::DrawArrays(GL_PATCHES, 0, 3)); }},
        Uncut{"Instancing", [](auto& m) { m.getPrimitiveSet(0)->setNumInstances(3); }},
        Uncut{"PerPrimitiveSet",
              [](auto& m) { m.getColorArray()->setBinding(osg::Array::BIND_PER_PRIMITIVE_SET); }},
        Uncut{"Unbound", [](auto& m) { m.getTexCoordArray(2)->setBinding(osg::Array::BIND_UNDEFINED); }},
        Uncut{"ShortArray", [](auto& m) { m.getVertexAttribArray(5)->resizeArray(3); }},
        Uncut{"EmptyOverall", [](auto& m) { m.setColorArray(new osg::Vec4Array, osg::Array::BIND_OVERALL); }},
        Uncut{"IndexOutOfRange",
              [](auto& m) { m.addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 48, 3)); }},
        Uncut{"NegativeFirst", [](auto& m) { m.addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, -3, 3)); }},
        Uncut{"NoVertices", [](auto& m) { m.setVertexArray(nullptr); }},
        Uncut{"NotFinite",
              [](auto& m) {
                (*static_cast<osg::Vec3Array*>(m.getVertexArray()))[4].x() =
                    std::numeric_limits<float>::quiet_NaN();
              }}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(CutDrawable, WhatIsSmallEnoughStaysWhole) {
  EXPECT_FALSE(cutDrawable(*gridMesh(3), 18));
  EXPECT_TRUE(cutDrawable(*gridMesh(3), 17));
  EXPECT_FALSE(cutDrawable(*gridMesh(3), 0)) << "0: never";
  class Derived : public osg::Geometry {};
  osg::ref_ptr<Derived> derived = new Derived;
  derived->setVertexArray(gridMesh(3)->getVertexArray());
  derived->addPrimitiveSet(gridMesh(3)->getPrimitiveSet(0));
  EXPECT_FALSE(cutDrawable(*derived, 2)) << "may draw something else";
}

Result<Scene> extract(osg::Group* root, std::uint64_t max) {
  ImportedGraph graph;
  graph.root = root;
  return extractScene(std::move(graph), {.source = "test", .maxTrianglesPerLeaf = max});
}

TEST(ExtractCut, PartsAreLeavesUnderABinarySubtree) {
  osg::ref_ptr<osg::Group> root = new osg::Group, child = new osg::Group;
  root->addChild(gridMesh(1));
  root->addChild(gridMesh(8));
  root->addChild(child);
  child->addChild(gridMesh(1, 50));
  const auto whole = extract(root, 0);
  const auto scene = extract(root, 20);
  ASSERT_TRUE(whole && scene);
  ASSERT_EQ(whole->leaves.size(), 3U);
  for (std::uint32_t leaf = 0; leaf < 3; ++leaf)
    EXPECT_EQ(whole->leaves[leaf].graphLeaf, leaf);
  EXPECT_EQ(whole->graphLeafCount, 3U);

  const auto count = static_cast<std::uint32_t>(scene->leaves.size());
  ASSERT_GE(count, 2U + 7U);
  EXPECT_EQ(scene->graphLeafCount, 3U);
  EXPECT_EQ(scene->hierarchy.leafCount(), count);
  EXPECT_EQ(scene->triangleCount(), whole->triangleCount());
  EXPECT_EQ(scene->leaves[0].graphLeaf, 0U);
  EXPECT_EQ(scene->leaves[count - 1].graphLeaf, 2U);
  EXPECT_EQ(scene->leaves[count - 1].part, 0U);
  for (std::uint32_t leaf = 1; leaf + 1 < count; ++leaf) {
    EXPECT_EQ(scene->leaves[leaf].graphLeaf, 1U);
    EXPECT_EQ(scene->leaves[leaf].part, leaf - 1);
    EXPECT_EQ(scene->leaves[leaf].source.osgDrawable, 1U);
    EXPECT_LE(scene->leaves[leaf].triangles, 20U);
  }
  // Root, leaf 0, then the subtree of the parts: one range of leaves.
  const ObjectHierarchy& oh = scene->hierarchy;
  EXPECT_EQ(oh.leaves(2).first, 1U);
  EXPECT_EQ(oh.leaves(2).last, count - 1);
  EXPECT_EQ(oh.subtreeEnd(2) - 2, 2 * (count - 2) - 1);
  EXPECT_TRUE(scene->warnings.empty());
}

TEST(ExtractCut, ASharedDrawableIsCutOnce) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  osg::ref_ptr<osg::Geometry> mesh = gridMesh(8);
  for (int i = 0; i < 3; ++i) {
    osg::ref_ptr<osg::MatrixTransform> place = new osg::MatrixTransform(osg::Matrixd::translate(0, 0, 9 * i));
    place->addChild(mesh);
    root->addChild(place);
  }
  const auto scene = extract(root, 20);
  ASSERT_TRUE(scene);
  const std::size_t parts = scene->leaves.size() / 3;
  EXPECT_EQ(scene->leaves.size(), 3 * parts);
  EXPECT_EQ(scene->assets.size(), parts + 1) << "one for each part, one state";
  EXPECT_EQ(scene->graphLeafCount, 3U);
  for (std::size_t i = 0; i < scene->leaves.size(); ++i) {
    EXPECT_EQ(scene->leaves[i].graphLeaf, i / parts);
    EXPECT_EQ(scene->leaves[i].part, i % parts);
    EXPECT_EQ(scene->leaves[i].drawable, scene->leaves[i % parts].drawable);
  }
}

TEST(ExtractCut, ManyCutsDoNotMixUpTheirParts) {
  // The parts of one mesh die before the next is cut, so the same addresses come again.
  osg::ref_ptr<osg::Group> root = new osg::Group;
  for (int i = 0; i < 20; ++i)
    root->addChild(gridMesh(4, 10 * i));
  const auto scene = extract(root, 16);
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->leaves.size(), 40U);
  for (std::uint32_t leaf = 0; leaf < 40; ++leaf) {
    EXPECT_NEAR(scene->hierarchy.aabb(scene->hierarchy.nodeOfLeaf(leaf)).min.x(), 10 * (leaf / 2), 4.5);
    EXPECT_EQ(scene->leaves[leaf].graphLeaf, leaf / 2);
  }
}

TEST(ExtractCut, SaysOnceThatSomeCannotBeCut) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  for (int i = 0; i < 2; ++i) {
    osg::ref_ptr<osg::Geometry> mesh = gridMesh(8, 10 * i);
    mesh->addPrimitiveSet(new osg::DrawArrays(GL_POINTS, 0, 1));
    root->addChild(mesh);
  }
  const auto scene = extract(root, 20);
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->leaves.size(), 2U);
  ASSERT_EQ(scene->warnings.size(), 1U);
  EXPECT_NE(scene->warnings[0].find("stay whole"), std::string::npos);
}

TEST(ExtractCut, BillboardsAreNeverCut) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  osg::ref_ptr<osg::Billboard> billboard = new osg::Billboard;
  billboard->addDrawable(gridMesh(8), osg::Vec3(1, 2, 3));
  root->addChild(billboard);
  const auto scene = extract(root, 20);
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->leaves.size(), 1U);
  EXPECT_NE(scene->billboardOf(scene->leaves[0]), nullptr);
}

TEST(ExtractCut, PartsOfAFarMeshShareItsOrigin) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  root->addChild(gridMesh(8, 1e6));
  const auto whole = extract(root, 0), scene = extract(root, 20);
  ASSERT_TRUE(whole && scene);
  ASSERT_GT(scene->leaves.size(), 1U);
  EXPECT_NEAR(whole->leaves[0].localToWorld(0, 3), 1e6 + 4, 1);
  for (const SceneLeaf& leaf : scene->leaves)
    EXPECT_EQ(leaf.localToWorld, whole->leaves[0].localToWorld) << "or seams would open";
}

}  // namespace
}  // namespace tessera
