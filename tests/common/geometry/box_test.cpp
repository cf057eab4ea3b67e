#include "common/geometry/box.h"

#include <ostream>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <boost/multiprecision/cpp_int.hpp>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using Rational = boost::multiprecision::cpp_rational;
using Exact = std::array<Rational, 3>;

Exact exact(const Vec3& v) {
  return {Rational(v.x()), Rational(v.y()), Rational(v.z())};
}

Rational dot(const Exact& a, const Exact& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Exact cross(const Exact& a, const Exact& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Exactly: is p in {c + sum t_k h_k, |t_k| <= 1}? By Cramer's rule.
bool containsExactly(const Obb& box, const Vec3& p) {
  const Exact h0 = exact(box.halfAxes[0]), h1 = exact(box.halfAxes[1]), h2 = exact(box.halfAxes[2]);
  const Exact c = exact(box.center), q = exact(p);
  const Exact d = {q[0] - c[0], q[1] - c[1], q[2] - c[2]};
  const Rational determinant = dot(h0, cross(h1, h2));
  if (determinant == 0) return false;
  const Rational size = abs(determinant);
  return abs(dot(d, cross(h1, h2))) <= size && abs(dot(h0, cross(d, h2))) <= size &&
         abs(dot(h0, cross(h1, d))) <= size;
}

struct Cloud {
  const char* name;
  double offset, size;
  Vec3 flatness;  ///< scale of each principal direction

  friend void PrintTo(const Cloud& cloud, std::ostream* out) { *out << cloud.name; }
};

class PcaObb : public ::testing::TestWithParam<Cloud> {};

TEST_P(PcaObb, HoldsEveryPointInExactArithmetic) {
  const Cloud& cloud = GetParam();
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int round = 0; round < 40; ++round) {
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(unit(random), unit(random), unit(random), unit(random)).normalized();
    std::vector<Vec3> points;
    for (int i = 0; i < 30; ++i) {
      const Vec3 local =
          Vec3(unit(random), unit(random), unit(random)).cwiseProduct(cloud.flatness) * cloud.size;
      points.push_back(turn * local + Vec3(cloud.offset, -cloud.offset / 3, cloud.offset / 7));
    }
    const Obb box = pcaObbOf(points, Vec3::Zero());
    for (const Vec3& p : points)
      ASSERT_TRUE(containsExactly(box, p)) << cloud.name << " round " << round;
    const Aabb aabb = aabbOf(points, Vec3::Zero());
    const Obb fromAabb = Obb::fromAabb(aabb);
    const Sphere sphere = sphereOf(points, aabb.center(), Vec3::Zero());
    for (const Vec3& p : points) {
      ASSERT_TRUE(containsExactly(fromAabb, p));
      const Exact d = exact(p), c = exact(sphere.center);
      const Exact r = {d[0] - c[0], d[1] - c[1], d[2] - c[2]};
      ASSERT_LE(dot(r, r), Rational(sphere.radius) * Rational(sphere.radius));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Clouds, PcaObb,
    ::testing::Values(Cloud{"plain", 0, 1, {1, 1, 1}}, Cloud{"pipe", 10, 5, {1, 0.01, 0.01}},
                      Cloud{"plate", 1e4, 3, {1, 1, 0}}, Cloud{"line", 1e6, 2, {1, 0, 0}},
                      Cloud{"point", 1e7, 0, {1, 1, 1}}, Cloud{"far", 1e8, 0.05, {1, 0.5, 0.2}},
                      Cloud{"farther", 1e12, 1, {1, 0.5, 0.2}}, Cloud{"tiny", 0, 1e-9, {1, 0.3, 0.1}},
                      Cloud{"huge", 0, 1e9, {1, 0.3, 0.1}}),
    [](const auto& cloud) { return cloud.param.name; });

TEST(PcaObb, IsMuchTighterThanTheAxisAlignedBoxForADiagonalPipe) {
  std::vector<Vec3> points;
  for (int i = 0; i < 200; ++i) {
    const double t = i / 199.0;
    points.emplace_back(10 * t + 0.1 * std::cos(i), 10 * t + 0.1 * std::sin(i),
                        10 * t + 0.1 * std::sin(2 * i));
  }
  const Obb box = pcaObbOf(points, Vec3::Zero());
  const double volume = 8 * box.halfAxes[0].norm() * box.halfAxes[1].norm() * box.halfAxes[2].norm();
  const Aabb aabb = aabbOf(points, Vec3::Zero());
  EXPECT_LT(volume, 0.01 * (aabb.max - aabb.min).prod());
}

TEST(PcaObb, MarginWidensTheBoxByAtLeastThatMuch) {
  const std::vector<Vec3> points = {{0, 0, 0}, {4, 1, 0}, {1, 3, 1}, {2, 2, 5}};
  const Vec3 margin(0.25, 0.5, 0.125);
  const Obb box = pcaObbOf(points, margin);
  for (const Vec3& p : points) {
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      EXPECT_TRUE(containsExactly(box, p + margin.cwiseProduct(sign)));
    }
  }
}

TEST(Aabb, EmptyBoxTakesTheFirstPoint) {
  Aabb box;
  EXPECT_TRUE(box.empty());
  box.extend(Vec3(1, 2, 3));
  EXPECT_FALSE(box.empty());
  EXPECT_EQ(box.min, Vec3(1, 2, 3));
  EXPECT_EQ(box.max, Vec3(1, 2, 3));
}

}  // namespace
}  // namespace tessera
