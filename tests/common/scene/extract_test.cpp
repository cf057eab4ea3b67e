#include "common/scene/extract.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <osg/Geometry>
#include <osg/MatrixTransform>
#include <osg/Switch>

#include "common/scene/motion/motion_codec.h"

namespace tessera {
namespace {

osg::ref_ptr<osg::Geometry> triangleAt(float x, float size = 1) {
  osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
  vertices->push_back(osg::Vec3(x, 0, 0));
  vertices->push_back(osg::Vec3(x + size, 0, 0));
  vertices->push_back(osg::Vec3(x, size, 0));
  geometry->setVertexArray(vertices);
  geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, 3));
  return geometry;
}

Result<Scene> extract(osg::Group* root) {
  ImportedGraph graph;
  graph.root = root;
  return extractScene(std::move(graph), {.source = "test"});
}

TEST(Extract, TakesANodesOwnDrawablesBeforeItsChildren) {
  osg::ref_ptr<osg::Group> root = new osg::Group, child = new osg::Group;
  child->setName("child");
  child->addChild(triangleAt(10));
  child->addChild(triangleAt(20));
  root->addChild(child);
  root->addChild(triangleAt(0));
  const auto scene = extract(root);
  ASSERT_TRUE(scene) << scene.error().text();
  ASSERT_EQ(scene->leaves.size(), 3U);
  const auto minX = [&](std::uint32_t leaf) {
    return scene->hierarchy.aabb(scene->hierarchy.nodeOfLeaf(leaf)).min.x();
  };
  EXPECT_NEAR(minX(0), 0, 1e-9);
  EXPECT_NEAR(minX(1), 10, 1e-9);
  EXPECT_NEAR(minX(2), 20, 1e-9);
  EXPECT_EQ(scene->pathOf(0), "root");
  EXPECT_EQ(scene->pathOf(2), "root/child");
  EXPECT_EQ(scene->nodePathOf(2), std::vector<std::uint32_t>{0});
  EXPECT_EQ(scene->leaves[2].source.osgDrawable, 1U);
  EXPECT_EQ(scene->triangleCount(), 3U);
}

TEST(Extract, EqualDrawablesAreOneAsset) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  for (int i = 0; i < 5; ++i) {
    osg::ref_ptr<osg::MatrixTransform> place = new osg::MatrixTransform(osg::Matrixd::translate(i, 0, 0));
    osg::ref_ptr<osg::Geometry> triangle = triangleAt(0);
    triangle->setName("copy " + std::to_string(i));
    place->addChild(triangle);
    root->addChild(place);
  }
  const auto scene = extract(root);
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_EQ(scene->leaves.size(), 5U);
  EXPECT_EQ(scene->assets.size(), 2U) << "one drawable, one state";
}

TEST(Extract, VerticesFarFromTheirOriginAreStoredAboutTheirMiddle) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  root->addChild(triangleAt(1e7F, 64));
  const auto scene = extract(root);
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_NEAR(scene->leaves[0].localToWorld(0, 3), 1e7 + 32, 1);
  const Aabb& box = scene->hierarchy.aabb(0);
  EXPECT_LE(box.min.x(), 1e7);
  EXPECT_GE(box.max.x(), 1e7 + 64);
  EXPECT_NEAR(box.max.x() - box.min.x(), 64, 1e-6);
}

TEST(Extract, BoundsHoldTheTransformedVertices) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  osg::ref_ptr<osg::MatrixTransform> place = new osg::MatrixTransform(
      osg::Matrixd::rotate(0.7, osg::Vec3d(1, 2, 3)) * osg::Matrixd::translate(1e8, -3e7, 5));
  place->addChild(triangleAt(3));
  root->addChild(place);
  const auto scene = extract(root);
  ASSERT_TRUE(scene) << scene.error().text();
  for (const osg::Vec3d local : {osg::Vec3d(3, 0, 0), osg::Vec3d(4, 0, 0), osg::Vec3d(3, 1, 0)}) {
    const osg::Vec3d world = local * place->getMatrix();
    const Vec3 p(world.x(), world.y(), world.z());
    EXPECT_TRUE((scene->hierarchy.aabb(0).min.array() <= p.array()).all());
    EXPECT_TRUE((scene->hierarchy.aabb(0).max.array() >= p.array()).all());
    EXPECT_LE((p - scene->hierarchy.sphere(0).center).norm(), scene->hierarchy.sphere(0).radius);
  }
}

TEST(Extract, OfASwitchEverythingAndWhatIsOff) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  osg::ref_ptr<osg::Switch> choice = new osg::Switch;
  choice->addChild(triangleAt(0), false);
  choice->addChild(triangleAt(5), true);
  root->addChild(choice);
  const auto scene = extract(root);
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_EQ(scene->leaves.size(), 2U);
  const auto motion = motion::decodeMotion({scene->motion.data(), scene->motion.size()});
  ASSERT_TRUE(motion) << motion.error().text();
  EXPECT_EQ(motion->hiddenAsLoaded, (VisibleList{{0, 1}}));
}

TEST(Extract, RefusesWhatCannotBeDrawn) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  osg::ref_ptr<osg::Group> bad = new osg::Group;
  bad->addChild(triangleAt(nan));
  const auto scene = extract(bad);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().text().find("not a finite number"), std::string::npos) << scene.error().text();

  osg::ref_ptr<osg::Group> crooked = new osg::Group;
  osg::ref_ptr<osg::MatrixTransform> place =
      new osg::MatrixTransform(osg::Matrixd::scale(std::numeric_limits<double>::infinity(), 1, 1));
  place->setName("crooked");
  place->addChild(triangleAt(0));
  crooked->addChild(place);
  const auto second = extract(crooked);
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().text().find("crooked"), std::string::npos) << second.error().text();

  osg::ref_ptr<osg::Geometry> outOfRange = triangleAt(0);
  osg::ref_ptr<osg::DrawElementsUShort> elements = new osg::DrawElementsUShort(GL_TRIANGLES);
  for (const int i : {0, 1, 7})
    elements->push_back(static_cast<GLushort>(i));
  outOfRange->setPrimitiveSet(0, elements);
  osg::ref_ptr<osg::Group> wrong = new osg::Group;
  wrong->addChild(outOfRange);
  const auto third = extract(wrong);
  ASSERT_FALSE(third);
  EXPECT_NE(third.error().text().find("index 7"), std::string::npos) << third.error().text();

  EXPECT_FALSE(extract(new osg::Group)) << "nothing to draw";
}

TEST(Extract, TakesAGraph20000LevelsDeep) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  osg::ref_ptr<osg::Group> last = root;
  for (int i = 0; i < 20'000; ++i) {
    osg::ref_ptr<osg::Group> next = new osg::Group;
    if (i % 1000 == 0) next->addChild(triangleAt(static_cast<float>(i)));
    last->addChild(next);
    last = next;
  }
  const auto scene = extract(root);
  root = nullptr;
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_EQ(scene->leaves.size(), 20U);
}

}  // namespace
}  // namespace tessera
