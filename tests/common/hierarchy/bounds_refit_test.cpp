#include "common/hierarchy/bounds_refit.h"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <ostream>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <boost/multiprecision/cpp_int.hpp>
#include <gtest/gtest.h>

#include "common/hierarchy/spatial_hierarchy.h"
#include "common/hierarchy/transformed_bounds.h"

namespace tessera {
namespace {

using Rational = boost::multiprecision::cpp_rational;
using Exact = std::array<Rational, 3>;

Exact exact(const Vec3& v) {
  return {Rational(v.x()), Rational(v.y()), Rational(v.z())};
}

Exact plus(const Exact& a, const Rational& factor, const Exact& b) {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}

Rational dot(const Exact& a, const Exact& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Exact cross(const Exact& a, const Exact& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Exact image(const Mat4& map, const Exact& p) {
  Exact out;
  for (int row = 0; row < 3; ++row) {
    Rational sum(map(row, 3));
    for (int k = 0; k < 3; ++k)
      sum += Rational(map(row, k)) * p[static_cast<std::size_t>(k)];
    out[static_cast<std::size_t>(row)] = sum;
  }
  return out;
}

/// By Cramer's rule.
bool containsExactly(const Obb& box, const Exact& p) {
  const Exact h0 = exact(box.halfAxes[0]), h1 = exact(box.halfAxes[1]), h2 = exact(box.halfAxes[2]);
  const Exact d = plus(p, -1, exact(box.center));
  const Rational size = abs(dot(h0, cross(h1, h2)));
  return size != 0 && abs(dot(d, cross(h1, h2))) <= size && abs(dot(h0, cross(d, h2))) <= size &&
         abs(dot(h0, cross(h1, d))) <= size;
}

bool containsExactly(const Aabb& box, const Exact& p) {
  for (int k = 0; k < 3; ++k) {
    const Rational& x = p[static_cast<std::size_t>(k)];
    if (x < Rational(box.min[k]) || x > Rational(box.max[k])) return false;
  }
  return true;
}

bool containsExactly(const Sphere& sphere, const Exact& p) {
  const Exact d = plus(p, -1, exact(sphere.center));
  const Rational radius(sphere.radius);
  return dot(d, d) <= radius * radius;
}

std::array<Exact, 8> exactCorners(const Vec3& center, const std::array<Vec3, 3>& axes) {
  std::array<Exact, 8> out;
  for (unsigned i = 0; i < 8; ++i) {
    out[i] = exact(center);
    for (unsigned k = 0; k < 3; ++k)
      out[i] = plus(out[i], i >> k & 1 ? 1 : -1, exact(axes[k]));
  }
  return out;
}

std::array<Exact, 8> exactCorners(const Aabb& box) {
  std::array<Exact, 8> out;
  for (unsigned i = 0; i < 8; ++i)
    out[i] = exact({i & 1 ? box.max.x() : box.min.x(), i & 2 ? box.max.y() : box.min.y(),
                    i & 4 ? box.max.z() : box.min.z()});
  return out;
}

/// A point of the sphere in about this direction, no further from its centre than the radius.
Exact pointOf(const Sphere& sphere, const Vec3& direction) {
  const Exact d = exact(direction.normalized() * (1 - 1e-15));
  EXPECT_LE(dot(d, d), 1);
  return plus(exact(sphere.center), Rational(sphere.radius), d);
}

struct Case {
  const char* name;
  double offset, size;  ///< of the thing at rest
  double shift;         ///< of the map
  Vec3 scale;           ///< along random axes
  Vec3 flatness;        ///< of the thing's extents
  double shear = 0;

  friend void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }
};

class Random {
 public:
  double unit() { return unit_(engine_); }
  Vec3 vector() { return {unit(), unit(), unit()}; }
  Mat3 turn() { return Eigen::Quaterniond(unit(), unit(), unit(), unit()).normalized().toRotationMatrix(); }

 private:
  std::mt19937_64 engine_{3};
  std::uniform_real_distribution<double> unit_{-1, 1};
};

Mat4 mapOf(const Case& c, Random& random, bool alongAxes) {
  const Mat3 first = alongAxes ? Mat3(Mat3::Identity()) : random.turn();
  const Mat3 second = alongAxes ? Mat3(Mat3::Identity()) : random.turn();
  Mat3 shear = Mat3::Identity();
  shear(0, 1) = c.shear;
  Mat4 map = Mat4::Identity();
  map.topLeftCorner<3, 3>() = second * shear * c.scale.asDiagonal() * first;
  map.topRightCorner<3, 1>() = c.shift * random.vector();
  return map;
}

Bounds thingOf(const Case& c, Random& random, bool alongAxes) {
  const Mat3 turn = alongAxes ? Mat3(Mat3::Identity()) : random.turn();
  std::vector<Vec3> points;
  for (int i = 0; i < 12; ++i) {
    points.push_back(turn * (c.size * random.vector().cwiseProduct(c.flatness)) +
                     Vec3(c.offset, -c.offset / 3, c.offset / 7));
  }
  Bounds bounds = boundsOf(points, Vec3::Zero());
  if (alongAxes) bounds.obb = Obb::fromAabb(bounds.aabb);
  return bounds;
}

class TransformedBounds : public ::testing::TestWithParam<Case> {};

TEST_P(TransformedBounds, HoldTheExactImage) {
  const Case& c = GetParam();
  Random random;
  for (int round = 0; round < 40; ++round) {
    SCOPED_TRACE(round);
    const bool alongAxes = round % 4 == 0;
    const Bounds rest = thingOf(c, random, alongAxes);
    const Mat4 map = mapOf(c, random, alongAxes);
    for (const BoxFit fit : {BoxFit::Pca, BoxFit::AxisAligned}) {
      const std::optional<Bounds> now = transformed(rest, map, fit);
      ASSERT_TRUE(now);
      for (const Exact& corner : exactCorners(rest.aabb)) {
        ASSERT_TRUE(containsExactly(now->aabb, image(map, corner)));
        if (fit == BoxFit::AxisAligned) {
          ASSERT_TRUE(containsExactly(now->obb, image(map, corner)));
        }
      }
      if (fit == BoxFit::Pca) {
        for (const Exact& corner : exactCorners(rest.obb.center, rest.obb.halfAxes))
          ASSERT_TRUE(containsExactly(now->obb, image(map, corner)));
      }
      const Eigen::JacobiSVD<Mat3, Eigen::ComputeFullV> svd(map.topLeftCorner<3, 3>());
      for (const Vec3& direction : {Vec3(svd.matrixV().col(0)), Vec3(-svd.matrixV().col(0)), random.vector()})
        ASSERT_TRUE(containsExactly(now->sphere, image(map, pointOf(rest.sphere, direction))));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Maps, TransformedBounds,
    ::testing::Values(
        Case{"rigid", 0, 1, 5, {1, 1, 1}, {1, 1, 1}}, Case{"mirrored", 3, 1, 5, {-1, 1, 1}, {1, 1, 1}},
        Case{"pipe", 10, 5, 100, {1, 1, 1}, {1, 0.01, 0.01}}, Case{"flat", 0, 1, 5, {1, 1, 1}, {1, 1, 0}},
        Case{"line", 0, 1, 5, {1, 1, 1}, {1, 0, 0}}, Case{"point", 2, 1, 5, {1, 1, 1}, {0, 0, 0}},
        Case{"pointAtOrigin", 0, 1, 0, {1, 1, 1}, {0, 0, 0}},
        Case{"sheared", 1, 1, 5, {1, 2, 1}, {1, 1, 1}, 3},
        Case{"shearedAway", 1, 1, 5, {1, 2, 1}, {1, 1, 1}, 1e9},
        Case{"oneStretched", 1, 1, 5, {1e9, 1, 1}, {1, 1, 1}},
        Case{"ontoAPlane", 1, 1, 5, {1, 1, 0}, {1, 1, 1}}, Case{"ontoALine", 1, 1, 5, {1, 0, 0}, {1, 1, 1}},
        Case{"ontoAPoint", 1, 1, 5, {0, 0, 0}, {1, 1, 1}},
        Case{"nearlyOntoAPlane", 1, 1, 5, {1, 1, 1e-15}, {1, 1, 1}},
        Case{"far", 1e7, 1, 1e7, {1, 1, 1}, {1, 1, 1}},
        Case{"farther", 1e12, 1, 1e12, {1, 1, 1}, {1, 0.3, 0.1}},
        Case{"farFlat", 1e12, 1e-3, 1e7, {1, 1, 1}, {1, 1, 0}},
        Case{"shrunk", 1, 1, 5, {1e-9, 1e-9, 1e-9}, {1, 1, 1}},
        Case{"grown", 1, 1, 5, {1e9, 1e9, 1e9}, {1, 1, 1}},
        Case{"tinyThing", 0, 1e-9, 0, {1e-9, 1e-9, 1e-9}, {1, 1, 1}},
        Case{"barelyThere", 0, 1e-100, 0, {1e-100, 1e-100, 1e-100}, {1, 1, 1}}),
    [](const auto& c) { return c.param.name; });

TEST(TransformedBounds, AreHardlyLargerThanTheImage) {
  Random random;
  const Case c{"", 100, 1, 1000, {2, 2, 2}, {1, 0.5, 0.01}};
  const Bounds rest = thingOf(c, random, false);
  const Bounds now = transformed(rest, mapOf(c, random, false), BoxFit::Pca).value();
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(now.obb.halfAxes[k].norm(), 2 * rest.obb.halfAxes[k].norm(), 1e-11);
  EXPECT_NEAR(now.sphere.radius, 2 * rest.sphere.radius, 1e-11);
  Mat4 shift = Mat4::Identity();
  shift(0, 3) = 7;
  const Bounds shifted = transformed(rest, shift, BoxFit::Pca).value();
  EXPECT_LT((shifted.aabb.min - rest.aabb.min - 7 * Vec3::UnitX()).norm(), 1e-12);
  EXPECT_LT((shifted.aabb.max - rest.aabb.max - 7 * Vec3::UnitX()).norm(), 1e-12);
}

TEST(TransformedBounds, OfTheShadowOfAPipeStayThin) {
  std::vector<Vec3> points;
  for (int i = 0; i < 50; ++i)
    points.emplace_back(i + 0.01 * std::cos(i), i + 0.01 * std::sin(i), i);
  Mat4 flatten = Mat4::Identity();
  flatten(2, 2) = 0;
  const Bounds now = transformed(boundsOf(points, Vec3::Zero()), flatten, BoxFit::Pca).value();
  EXPECT_EQ(now.aabb.center().z(), 0);
  EXPECT_LT(now.aabb.max.z(), 1e-12);
}

constexpr HierarchyKind kKinds[] = {HierarchyKind::Bvh, HierarchyKind::Octree, HierarchyKind::LooseOctree,
                                    HierarchyKind::Kd};

std::vector<Bounds> city(std::size_t count) {
  Random random;
  const Case thing{"", 0, 1, 0, {1, 1, 1}, {1, 0.5, 0.1}};
  std::vector<Bounds> items;
  for (std::size_t i = 0; i < count; ++i) {
    Mat4 place = Mat4::Identity();
    place.topRightCorner<3, 1>() = 100 * random.vector();
    items.push_back(transformed(thingOf(thing, random, false), place, BoxFit::Pca).value());
  }
  return items;
}

ObjectHierarchy hierarchyOf(HierarchyKind kind, std::size_t count) {
  return buildSpatialHierarchy(kind, city(count), std::vector<std::uint64_t>(count, 1), 0).hierarchy;
}

Bounds boundsOfNode(const ObjectHierarchy& oh, std::uint32_t node) {
  return {oh.aabb(node), oh.obb(node), oh.sphere(node)};
}

bool areSame(const Bounds& a, const Bounds& b) {
  return a.aabb.min == b.aabb.min && a.aabb.max == b.aabb.max && a.obb.center == b.obb.center &&
         a.obb.halfAxes == b.obb.halfAxes && a.sphere.center == b.sphere.center &&
         a.sphere.radius == b.sphere.radius;
}

std::vector<Bounds> allBounds(const ObjectHierarchy& oh) {
  std::vector<Bounds> out;
  for (std::uint32_t node = 0; node < oh.nodeCount(); ++node)
    out.push_back(boundsOfNode(oh, node));
  return out;
}

class Refit : public ::testing::TestWithParam<std::tuple<HierarchyKind, BoxFit>> {};

TEST_P(Refit, BoundsHoldEveryMovedLeafExactlyAndTheRestIsUntouched) {
  const auto [kind, fit] = GetParam();
  ObjectHierarchy oh = hierarchyOf(kind, 120);
  const std::vector<Bounds> before = allBounds(oh);
  BoundsRefit refit(oh, fit);
  Random random;
  const Case motion{"", 0, 1, 1e3, {1, 2, 1}, {1, 1, 1}, 0.5};
  std::vector<std::optional<Mat4>> maps(oh.leafCount());
  for (int frame = 0; frame < 3; ++frame) {
    for (std::uint32_t leaf = 5; leaf < oh.leafCount(); leaf += 29) {
      maps[leaf] = mapOf(motion, random, false);
      ASSERT_EQ(refit.move(leaf, *maps[leaf]), BoundsRefit::Moved::Done);
    }
    EXPECT_EQ(oh.revision(), static_cast<std::uint64_t>(frame));
    EXPECT_GT(refit.refit(), 0U);
    EXPECT_EQ(oh.revision(), static_cast<std::uint64_t>(frame) + 1);
  }

  std::vector<bool> touched(oh.nodeCount(), false);
  for (std::uint32_t leaf = 0; leaf < oh.leafCount(); ++leaf) {
    if (!maps[leaf]) continue;
    const Bounds& rest = before[oh.nodeOfLeaf(leaf)];
    for (std::uint32_t n = oh.nodeOfLeaf(leaf); n != ObjectHierarchy::kNoParent; n = oh.parent(n)) {
      touched[n] = true;
      for (const Exact& corner : exactCorners(rest.aabb)) {
        ASSERT_TRUE(containsExactly(oh.aabb(n), image(*maps[leaf], corner)));
        if (fit == BoxFit::AxisAligned) {
          ASSERT_TRUE(containsExactly(oh.obb(n), image(*maps[leaf], corner)));
        }
      }
      if (fit == BoxFit::Pca) {
        for (const Exact& corner : exactCorners(rest.obb.center, rest.obb.halfAxes)) {
          ASSERT_TRUE(containsExactly(oh.obb(n), image(*maps[leaf], corner)));
        }
      }
      ASSERT_TRUE(containsExactly(oh.sphere(n), image(*maps[leaf], exact(rest.sphere.center))));
    }
  }
  for (std::uint32_t node = 0; node < oh.nodeCount(); ++node) {
    EXPECT_EQ(oh.isMoving(node), touched[node]);
    if (!touched[node]) {
      EXPECT_TRUE(areSame(boundsOfNode(oh, node), before[node]));
    }
  }
}

TEST_P(Refit, EqualsBuildingTheBoundsAnew) {
  const auto [kind, fit] = GetParam();
  ObjectHierarchy oh = hierarchyOf(kind, 2000);
  BoundsRefit refit(oh, fit);
  Random random;
  const Case motion{"", 0, 1, 50, {1, 1, 1}, {1, 1, 1}};
  for (std::uint32_t leaf = 0; leaf < oh.leafCount(); ++leaf)
    ASSERT_EQ(refit.move(leaf, mapOf(motion, random, false)), BoundsRefit::Moved::Done);
  refit.refit();
  for (std::uint32_t node = 0; node < oh.nodeCount(); ++node) {
    if (oh.isTerminal(node)) continue;
    EnclosingBounds enclosing;
    for (std::uint32_t child = node + 1; child != oh.subtreeEnd(node); child = oh.subtreeEnd(child))
      enclosing.add(boundsOfNode(oh, child));
    ASSERT_TRUE(areSame(enclosing.result(fit), boundsOfNode(oh, node))) << node;
  }
}

TEST_P(Refit, RecomputesOnlyThePathsAndReturnsWithTheIdentity) {
  const auto [kind, fit] = GetParam();
  ObjectHierarchy oh = hierarchyOf(kind, 500);
  const Bounds rest = boundsOfNode(oh, oh.nodeOfLeaf(123));
  BoundsRefit refit(oh, fit);
  EXPECT_EQ(refit.refit(), 0U);
  EXPECT_EQ(oh.revision(), 0U);
  Mat4 map = Mat4::Identity();
  map(1, 3) = 4;
  refit.move(123, map);
  std::uint32_t path = 0;
  for (std::uint32_t n = oh.parent(oh.nodeOfLeaf(123)); n != ObjectHierarchy::kNoParent; n = oh.parent(n))
    ++path;
  EXPECT_EQ(refit.refit(), path);
  EXPECT_EQ(oh.revision(), 1U);
  refit.move(123, map);  // stands still
  EXPECT_EQ(refit.refit(), 0U);
  EXPECT_EQ(oh.revision(), 1U);
  refit.move(123, Mat4::Identity());
  EXPECT_EQ(refit.refit(), path);
  const Bounds back = boundsOfNode(oh, oh.nodeOfLeaf(123));
  EXPECT_EQ(back.aabb.min, rest.aabb.min);
  EXPECT_EQ(back.sphere.radius, rest.sphere.radius);
  if (fit == BoxFit::Pca) {
    EXPECT_EQ(back.obb.halfAxes, rest.obb.halfAxes);
  }
}

TEST_P(Refit, KeepsTheLastPlaceOfALeafWhoseNewOneIsNotFinite) {
  const auto [kind, fit] = GetParam();
  ObjectHierarchy oh = hierarchyOf(kind, 50);
  BoundsRefit refit(oh, fit);
  const std::vector<Bounds> before = allBounds(oh);
  std::vector<Mat4> bad(5, Mat4::Identity());
  bad[0](1, 2) = std::numeric_limits<double>::quiet_NaN();
  bad[1](0, 3) = std::numeric_limits<double>::infinity();
  bad[2](2, 2) = 1e300;
  bad[3](3, 0) = 1;
  bad[4](0, 3) = -1e308;
  for (const Mat4& map : bad)
    EXPECT_EQ(refit.move(7, map), BoundsRefit::Moved::KeptLastPlace);
  Bounds empty = before[0], unbounded = before[0];
  empty.aabb = {};
  unbounded.sphere.radius = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refit.setBounds(7, empty), BoundsRefit::Moved::KeptLastPlace);
  EXPECT_EQ(refit.setBounds(7, unbounded), BoundsRefit::Moved::KeptLastPlace);
  EXPECT_EQ(refit.refusedMoves(), 7U);
  EXPECT_EQ(refit.refit(), 0U);
  const std::vector<Bounds> after = allBounds(oh);
  for (std::size_t node = 0; node < before.size(); ++node)
    EXPECT_TRUE(areSame(before[node], after[node]));
  EXPECT_FALSE(oh.isMoving(0));
}

TEST_P(Refit, TakesNewBoundsAndMovesThem) {
  const auto [kind, fit] = GetParam();
  ObjectHierarchy oh = hierarchyOf(kind, 50);
  BoundsRefit refit(oh, fit);
  const std::vector<Vec3> points = {{500, 500, 500}, {501, 502, 503}};
  const Bounds bounds = boundsOf(points, Vec3::Zero());
  EXPECT_EQ(refit.setBounds(3, bounds), BoundsRefit::Moved::Done);
  refit.refit();
  EXPECT_TRUE(areSame(boundsOfNode(oh, oh.nodeOfLeaf(3)), bounds));
  EXPECT_TRUE(oh.aabb(0).contains(bounds.aabb));
  Mat4 map = Mat4::Identity();
  map(0, 3) = 1000;
  EXPECT_EQ(refit.move(3, map), BoundsRefit::Moved::Done);
  refit.refit();
  EXPECT_GE(oh.aabb(0).max.x(), 1501);
  EXPECT_GE(oh.aabb(oh.nodeOfLeaf(3)).min.x(), 1499.999);
}

INSTANTIATE_TEST_SUITE_P(All, Refit,
                         ::testing::Combine(::testing::ValuesIn(kKinds),
                                            ::testing::Values(BoxFit::Pca, BoxFit::AxisAligned)),
                         [](const auto& c) {
                           std::string name(nameOf(std::get<0>(c.param)));
                           std::erase(name, '-');
                           return name + (std::get<1>(c.param) == BoxFit::Pca ? "_pca" : "_axisAligned");
                         });

TEST(BoundsRefit, MovesOneOfAMillionChildren) {
  constexpr std::uint32_t kCount = 1'000'000;
  ObjectHierarchyBuilder builder;
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 1, 1}};
  Bounds bounds = boundsOf(points, Vec3::Zero());
  bounds.obb = Obb::fromAabb(bounds.aabb);
  for (std::uint32_t i = 0; i < kCount; ++i)
    builder.addLeaf(bounds);
  ObjectHierarchy oh = builder.finish();
  for (const BoxFit fit : {BoxFit::Pca, BoxFit::AxisAligned}) {
    BoundsRefit refit(oh, fit);
    Mat4 map = Mat4::Identity();
    map(2, 3) = fit == BoxFit::Pca ? 10 : 30;
    EXPECT_EQ(refit.move(kCount / 2, map), BoundsRefit::Moved::Done);
    EXPECT_EQ(refit.refit(), 1U);
    EXPECT_TRUE(oh.aabb(0).contains(oh.aabb(oh.nodeOfLeaf(kCount / 2))));
    EXPECT_GE(oh.aabb(0).max.z(), 11);
  }
}

TEST(BoundsRefit, OfOneLeafThatIsTheRoot) {
  ObjectHierarchy oh = hierarchyOf(HierarchyKind::Bvh, 1);
  BoundsRefit refit(oh, BoxFit::Pca);
  Mat4 map = Mat4::Identity();
  map(0, 3) = 1;
  EXPECT_EQ(refit.move(0, map), BoundsRefit::Moved::Done);
  EXPECT_EQ(refit.refit(), 0U);
  EXPECT_EQ(oh.revision(), 1U);
  EXPECT_TRUE(oh.isMoving(0));
}

TEST(BoundsRefitDeathTest, ALeafOfAGroupCannotMoveAlone) {
  const std::vector<Bounds> items = city(4);
  ObjectHierarchy oh =
      buildSpatialHierarchy(HierarchyKind::Bvh, items, std::vector<std::uint64_t>(4, 1), 100).hierarchy;
  BoundsRefit refit(oh, BoxFit::Pca);
  EXPECT_DEATH(refit.move(0, Mat4::Identity()), "");
}

}  // namespace
}  // namespace tessera
