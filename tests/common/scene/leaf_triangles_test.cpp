#include "common/scene/leaf_triangles.h"

#include <algorithm>

#include <gtest/gtest.h>
#include <osg/Billboard>
#include <osg/MatrixTransform>

#include "common/scene/extract.h"
#include "tests/common/scene/grid_mesh.h"

namespace tessera {
namespace {

using Triangle = std::array<Vec3, 3>;

Result<Scene> extract(osg::Group* root, std::uint64_t max = 0) {
  ImportedGraph graph;
  graph.root = root;
  return extractScene(std::move(graph), {.source = "test", .maxTrianglesPerLeaf = max});
}

/// The triangles of one set of indexed triangles over floats.
std::vector<Triangle> expectedOf(const osg::Geometry& mesh, const osg::Matrixd& place) {
  const auto& vertices = dynamic_cast<const osg::Vec3Array&>(*mesh.getVertexArray());
  const osg::PrimitiveSet& set = *mesh.getPrimitiveSet(0);
  std::vector<Triangle> all(set.getNumIndices() / 3);
  for (unsigned int i = 0; i < set.getNumIndices(); ++i) {
    const osg::Vec3d world = osg::Vec3d(vertices[set.index(i)]) * place;
    all[i / 3][i % 3] = Vec3(world.x(), world.y(), world.z());
  }
  return all;
}

/// The same triangles in any order, to within `tolerance`.
void expectSame(std::vector<Triangle> actual, std::vector<Triangle> expected, double tolerance) {
  ASSERT_EQ(actual.size(), expected.size());
  for (const Triangle& triangle : actual) {
    const auto match = std::find_if(expected.begin(), expected.end(), [&](const Triangle& other) {
      for (std::size_t i = 0; i < 3; ++i) {
        if ((triangle[i] - other[i]).norm() > tolerance) return false;
      }
      return true;
    });
    ASSERT_NE(match, expected.end()) << triangle[0].transpose();
    expected.erase(match);
  }
}

void expectInside(const Aabb& box, const Triangle& triangle) {
  for (const Vec3& p : triangle) {
    EXPECT_TRUE((box.min.array() <= p.array()).all());
    EXPECT_TRUE((box.max.array() >= p.array()).all());
  }
}

osg::ref_ptr<osg::MatrixTransform> placed(osg::Node* node, const osg::Matrixd& matrix) {
  osg::ref_ptr<osg::MatrixTransform> place = new osg::MatrixTransform(matrix);
  place->addChild(node);
  return place;
}

TEST(LeafTriangles, AreTheOriginalUnderItsTransform) {
  osg::ref_ptr<osg::Geometry> mesh = gridMesh(6);
  const osg::Matrixd matrix = osg::Matrixd::scale(1, 2, 3) * osg::Matrixd::rotate(0.7, osg::Vec3d(1, 2, 3)) *
                              osg::Matrixd::translate(100, -30, 5);
  osg::ref_ptr<osg::Group> root = new osg::Group;
  root->addChild(placed(mesh, matrix));
  for (const std::uint64_t max : {0, 10}) {
    const auto scene = extract(root, max);
    ASSERT_TRUE(scene);
    LeafTriangles triangles(*scene);
    std::vector<Triangle> all;
    for (std::uint32_t leaf = 0; leaf < scene->leaves.size(); ++leaf) {
      const auto some = triangles.of(leaf);
      ASSERT_TRUE(some) << some.error().text();
      EXPECT_EQ(some->size(), scene->leaves[leaf].triangles);
      const std::uint32_t node = scene->hierarchy.nodeOfLeaf(leaf);
      for (const Triangle& triangle : *some)
        expectInside(scene->hierarchy.aabb(node), triangle);
      all.insert(all.end(), some->begin(), some->end());
    }
    expectSame(all, expectedOf(*mesh, matrix), 1e-12);
  }
}

TEST(LeafTriangles, OfFarGeometryAreWhereTheFileHasThem) {
  for (const std::uint64_t max : {0, 10}) {
    osg::ref_ptr<osg::Geometry> mesh = gridMesh(6, 1e6);
    const osg::Matrixd matrix = osg::Matrixd::rotate(0.3, osg::Vec3d(0, 0, 1));
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(placed(mesh, matrix));
    const auto scene = extract(root, max);
    ASSERT_TRUE(scene);
    EXPECT_GT(scene->leaves[0].localToWorld.col(3).norm(), 1e5) << "stored about its middle";
    LeafTriangles triangles(*scene);
    std::vector<Triangle> all;
    for (std::uint32_t leaf = 0; leaf < scene->leaves.size(); ++leaf) {
      const auto some = triangles.of(leaf);
      ASSERT_TRUE(some);
      all.insert(all.end(), some->begin(), some->end());
    }
    expectSame(all, expectedOf(*mesh, matrix), 1e-8);
  }
}

TEST(LeafTriangles, SharedDrawablesAreEachInTheirPlace) {
  osg::ref_ptr<osg::Geometry> mesh = gridMesh(2);
  osg::ref_ptr<osg::Group> root = new osg::Group;
  for (int i = 0; i < 3; ++i)
    root->addChild(placed(mesh, osg::Matrixd::translate(10 * i, 0, 0)));
  const auto scene = extract(root);
  ASSERT_TRUE(scene);
  LeafTriangles triangles(*scene);
  for (const std::uint32_t leaf : {2U, 0U, 1U, 2U}) {
    const auto some = triangles.of(leaf);
    ASSERT_TRUE(some);
    expectSame({some->begin(), some->end()}, expectedOf(*mesh, osg::Matrixd::translate(10.0 * leaf, 0, 0)),
               1e-12);
  }
}

TEST(LeafTriangles, PointsAndLinesAreDegenerateTriangles) {
  osg::ref_ptr<osg::Geometry> mesh = new osg::Geometry;
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
  for (int i = 0; i < 4; ++i)
    vertices->push_back(osg::Vec3(static_cast<float>(i), 0, 0));
  mesh->setVertexArray(vertices);
  mesh->addPrimitiveSet(new osg::DrawArrays(GL_POINTS, 3, 1));
  mesh->addPrimitiveSet(new osg::DrawArrays(GL_LINES, 0, 2));
  mesh->addPrimitiveSet(new osg::DrawArrays(GL_LINE_LOOP, 1, 3));
  osg::ref_ptr<osg::Group> root = new osg::Group;
  root->addChild(mesh);
  const auto scene = extract(root);
  ASSERT_TRUE(scene);
  LeafTriangles triangles(*scene);
  const auto some = triangles.of(0);
  ASSERT_TRUE(some);
  std::vector<std::array<int, 3>> xs;
  for (const Triangle& t : *some)
    xs.push_back({static_cast<int>(t[0].x()), static_cast<int>(t[1].x()), static_cast<int>(t[2].x())});
  EXPECT_EQ(xs, (std::vector<std::array<int, 3>>{{3, 3, 3}, {0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 1, 1}}));
}

TEST(LeafTriangles, OfVerticesInDoubleLieWithinTheBoundsAsStored) {
  for (const double offset : {0.0, 0.3, 10.0, 1e4 + 1.0 / 3, 1e7 + 1.0 / 3, -1e12 / 3}) {
    osg::ref_ptr<osg::Geometry> mesh = gridMesh(3);
    osg::ref_ptr<osg::Vec3dArray> doubles = new osg::Vec3dArray;
    for (const osg::Vec3& v : dynamic_cast<const osg::Vec3Array&>(*mesh->getVertexArray()))
      doubles->push_back(osg::Vec3d(v) * (1.0 / 3) + osg::Vec3d(offset, -offset, offset / 3));
    mesh->setVertexArray(doubles);
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(placed(mesh, osg::Matrixd::identity()));
    root->addChild(
        placed(mesh, osg::Matrixd::rotate(1, osg::Vec3d(1, 2, 3)) * osg::Matrixd::scale(10, 1, 0.1)));
    for (const std::uint64_t most : {0, 4}) {
      const auto scene = extract(root, most);
      ASSERT_TRUE(scene) << scene.error().text();
      LeafTriangles triangles(*scene);
      for (std::uint32_t leaf = 0; leaf < scene->leaves.size(); ++leaf) {
        const std::uint32_t node = scene->hierarchy.nodeOfLeaf(leaf);
        const Aabb& box = scene->hierarchy.aabb(node);
        const Sphere& sphere = scene->hierarchy.sphere(node);
        const auto some = triangles.of(leaf);
        ASSERT_TRUE(some);
        for (const Triangle& triangle : *some) {
          for (const Vec3& v : triangle) {
            EXPECT_TRUE(box.contains(Aabb{v, v})) << "leaf " << leaf << " at " << offset;
            EXPECT_LE((v - sphere.center).norm(), sphere.radius) << "leaf " << leaf << " at " << offset;
          }
        }
      }
    }
  }
}

TEST(LeafTriangles, BillboardsHaveNone) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  osg::ref_ptr<osg::Billboard> billboard = new osg::Billboard;
  billboard->addDrawable(gridMesh(2), osg::Vec3(1, 2, 3));
  root->addChild(billboard);
  const auto scene = extract(root);
  ASSERT_TRUE(scene);
  const auto some = LeafTriangles(*scene).of(0);
  ASSERT_TRUE(some);
  EXPECT_TRUE(some->empty());
}

TEST(LeafTriangles, FailOnAnAssetThatIsNotThere) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  root->addChild(gridMesh(2));
  auto scene = extract(root);
  ASSERT_TRUE(scene);
  scene->leaves[0].drawable = scene->leaves[0].state;
  EXPECT_FALSE(LeafTriangles(*scene).of(0)) << "a state, not a drawable";
  scene->leaves[0].drawable = static_cast<std::uint32_t>(scene->assets.size());
  EXPECT_FALSE(LeafTriangles(*scene).of(0));
}

}  // namespace
}  // namespace tessera
