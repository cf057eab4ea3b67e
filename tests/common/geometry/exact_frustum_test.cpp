#include "common/geometry/exact_frustum.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <ostream>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using Triangle = ExactFrustum::Triangle;

/// Eye at the origin, looking along -z at the square [-1, 1]^2 at z = -1.
Frustum square() {
  return {.eye = Vec3::Zero(),
          .corners = {Vec3(-1, -1, -1), Vec3(1, -1, -1), Vec3(1, 1, -1), Vec3(-1, 1, -1)},
          .near = {},
          .far = {}};
}

Triangle point(const Vec3& p) {
  return {p, p, p};
}

bool meets(const Frustum& frustum, const Triangle& triangle) {
  const ExactFrustum exact(frustum);
  const bool answer = exact.meetsExactly(triangle);
  EXPECT_EQ(exact.meets(triangle), answer);
  return answer;
}

double up(double x) {
  return std::nextafter(x, HUGE_VAL);
}
double down(double x) {
  return std::nextafter(x, -HUGE_VAL);
}

TEST(ExactFrustum, PointsOnSidesEdgesAndEyeAreInside) {
  const Frustum f = square();
  EXPECT_TRUE(meets(f, point({0, 0, -5})));
  EXPECT_TRUE(meets(f, point({0, 0, 0})));
  EXPECT_TRUE(meets(f, point({5, 0, -5})));
  EXPECT_TRUE(meets(f, point({5, -5, -5})));
  EXPECT_FALSE(meets(f, point({up(5), 0, -5})));
  EXPECT_TRUE(meets(f, point({down(5), 0, -5})));
  EXPECT_FALSE(meets(f, point({0, 0, 5})));
  EXPECT_FALSE(meets(f, point({0, 0, 0x1p-1074})));
  EXPECT_TRUE(meets(f, point({0x1p-1074, 0, -0x1p-1074})));
  EXPECT_FALSE(meets(f, point({0x1p-1073, 0, -0x1p-1074})));
}

TEST(ExactFrustum, TrianglesWithoutAVertexInside) {
  const Frustum f = square();
  EXPECT_TRUE(meets(f, {Vec3(-100, -100, -2), Vec3(100, -100, -2), Vec3(0, 100, -2)}));
  EXPECT_TRUE(meets(f, {Vec3(-100, 0, -2), Vec3(100, 0, -2), Vec3(0, 0, 50)}));
  EXPECT_TRUE(meets(f, {Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(0, 5, 0)}));  // touches the eye
  EXPECT_FALSE(meets(f, {Vec3(-1, 0, 0x1p-60), Vec3(1, 0, 0x1p-60), Vec3(0, 5, 0)}));
  // Outside of no single side, and of all together.
  EXPECT_FALSE(meets(f, {Vec3(3, 0, -1), Vec3(0, 3, -1), Vec3(3, 3, -1)}));
  EXPECT_TRUE(meets(f, {Vec3(2, 0, -1), Vec3(0, 2, -1), Vec3(3, 3, -1)}));  // touches the edge's corner
  EXPECT_FALSE(meets(f, {Vec3(up(2), 0, -1), Vec3(0, 2, -1), Vec3(3, 3, -1)}));
}

TEST(ExactFrustum, NearAndFarAreDistancesAlongTheNormal) {
  Frustum f = square();
  f.near = 2, f.far = 8;
  EXPECT_TRUE(meets(f, point({0, 0, -2})));
  EXPECT_FALSE(meets(f, point({0, 0, up(-2)})));
  EXPECT_TRUE(meets(f, point({8, 8, -8})));
  EXPECT_FALSE(meets(f, point({0, 0, down(-8)})));
  EXPECT_TRUE(meets(f, {Vec3(0, 0, 0), Vec3(0, 0, -100), Vec3(50, 1, 3)}));
  EXPECT_FALSE(meets(f, {Vec3(0, 0, 0), Vec3(0, 0, -1), Vec3(1, 0, -1)}));
  // The rectangle's distance and the order of its corners about the axis have no meaning for them.
  for (Vec3& c : f.corners)
    c *= 1024;
  EXPECT_TRUE(meets(f, point({0, 0, -2})));
  EXPECT_FALSE(meets(f, point({0, 0, up(-2)})));
}

TEST(ExactFrustum, NearOfAnIrrationalNormal) {
  // The normal is (0, -1, -1) / sqrt 2.
  Frustum f = {.eye = Vec3::Zero(),
               .corners = {Vec3(-1, -2, 0), Vec3(1, -2, 0), Vec3(1, 0, -2), Vec3(-1, 0, -2)},
               .near = {},
               .far = {}};
  f.near = 1;
  const double half = std::sqrt(0.5);  // its square is a little more than 1/2
  ASSERT_GT(static_cast<long double>(half) * half, 0.5L);
  EXPECT_TRUE(meets(f, point({0, -half, -half})));
  EXPECT_FALSE(meets(f, point({0, -down(half), -down(half)})));
  f.near.reset(), f.far = 1;
  EXPECT_FALSE(meets(f, point({0, -half, -half})));
  EXPECT_TRUE(meets(f, point({0, -down(half), -down(half)})));
}

TEST(ExactFrustum, DegenerateFrusta) {
  Frustum f = square();
  f.corners = {Vec3(-1, 0, -1), Vec3(1, 0, -1), Vec3(1, 0, -1), Vec3(-1, 0, -1)};
  EXPECT_TRUE(meets(f, point({0, 0, -1})));
  EXPECT_FALSE(meets(f, point({0, 0x1p-1074, -1})));
  EXPECT_TRUE(meets(f, {Vec3(0, -1, -1), Vec3(0, 1, -1), Vec3(5, 1, -1)}));
  f.near = 0.5;
  EXPECT_FALSE(meets(f, point({0, 0, -1})));  // no normal
  f = square();
  f.corners = {f.eye, f.eye, f.eye, f.eye};
  EXPECT_TRUE(meets(f, point({3, 4, 5})));  // no condition at all
}

TEST(ExactFrustum, NonFiniteNumbers) {
  const double inf = HUGE_VAL, nan = std::nan("");
  Frustum f = square();
  EXPECT_FALSE(meets(f, {Vec3(0, 0, -1), Vec3(0, 0, -1), Vec3(nan, 0, 0)}));
  EXPECT_FALSE(meets(f, {Vec3(0, 0, -1), Vec3(0, 0, -1), Vec3(0, 0, -inf)}));
  f.near = -inf, f.far = inf;
  EXPECT_TRUE(meets(f, point({0, 0, -1})));
  f.near = inf;
  EXPECT_FALSE(meets(f, point({0, 0, -1})));
  f.near = nan;
  EXPECT_FALSE(meets(f, point({0, 0, -1})));
  f = square();
  f.corners[2].y() = inf;
  EXPECT_FALSE(meets(f, point({0, 0, -1})));
}

TEST(ExactFrustum, ExtremeMagnitudes) {
  for (const double s : {0x1p-1060, 0x1p-700, 0x1p-300, 0x1p300, 0x1p700, 0x1p1020}) {
    for (const double t : {0x1p-1060, 0x1p-440, 1.0, 0x1p490, 0x1p1015}) {
      Frustum f = square();
      for (Vec3& c : f.corners)
        c *= s;
      EXPECT_TRUE(meets(f, point(t * Vec3(5, -5, -5)))) << s << ", " << t;
      EXPECT_FALSE(meets(f, point(t * Vec3(5, -6, -5)))) << s << ", " << t;
      f.near = 5 * t;
      EXPECT_TRUE(meets(f, point(t * Vec3(5, -5, -5)))) << s << ", " << t;
      EXPECT_FALSE(meets(f, point(t * Vec3(1, 1, -4)))) << s << ", " << t;
    }
  }
}

struct Setting {
  const char* name;
  double offset, size, fovDeg;
  int tiles;         ///< the frustum is one of tiles x tiles
  double nearToFar;  ///< 0: neither

  friend void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.name; }
};

class ExactFrustumFilter : public ::testing::TestWithParam<Setting> {
 protected:
  Vec3 unit3() { return {unit_(random_), unit_(random_), unit_(random_)}; }
  double spread(double least) { return std::pow(least, unit01_(random_)); }

  Frustum frustum(const Setting& s) {
    const double half = std::tan(s.fovDeg * std::numbers::pi / 360);
    const auto edge = [&] { return std::uniform_int_distribution(0, s.tiles - 1)(random_); };
    const double width = 2 * half / s.tiles, x = -half + width * edge(), y = -half + width * edge();
    const Mat3 turn = Eigen::Quaterniond(unit_(random_), unit_(random_), unit_(random_), unit_(random_))
                          .normalized()
                          .toRotationMatrix();
    Frustum f;
    f.eye = s.offset * Vec3(1, 1.0 / 3, -1.0 / 7) + s.size * unit3();
    f.corners = {Vec3(x, y, -1), Vec3(x + width, y, -1), Vec3(x + width, y + width, -1),
                 Vec3(x, y + width, -1)};
    for (Vec3& c : f.corners)
      c = f.eye + s.size * (turn * c);
    if (s.nearToFar > 0) f.near = s.size / std::sqrt(s.nearToFar), f.far = s.size * std::sqrt(s.nearToFar);
    return f;
  }
  /// Anywhere about the frustum's rays, of any size.
  Triangle anyTriangle(const Frustum& f) {
    const Vec3 middle = 0.25 * (f.corners[0] + f.corners[1] + f.corners[2] + f.corners[3]) - f.eye;
    const double width = (f.corners[2] - f.corners[0]).norm(),
                 depth = unit_(random_) < -0.9 ? -1 : 2 * spread(1e-3);
    const Vec3 at = f.eye + depth * (middle + width * unit3());
    const double small = std::abs(depth) * width * 3 * spread(1e-3);
    return {at + small * unit3(), at + small * unit3(), at + small * unit3()};
  }
  /// Vertices and edges on the sides, rays and corners, and on near or far, but for an ulp.
  Triangle hardTriangle(const Frustum& f) {
    const std::size_t i = random_() % 4;
    const Vec3 a = f.corners[i] - f.eye, b = f.corners[(i + 1) % 4] - f.eye;
    const auto onSide = [&] {
      double depth = spread(1e-3);
      if (f.near && random_() % 4 == 0) depth *= *f.near / a.norm();
      if (f.far && random_() % 4 == 0) depth *= *f.far / a.norm();
      switch (random_() % 4) {
        case 0:
          return f.corners[i];
        case 1:
          return Vec3(f.eye + depth * a);
        default:
          return Vec3(f.eye + depth * (a + unit01_(random_) * (b - a)));
      }
    };
    Triangle t = {onSide(), onSide(), onSide()};
    const std::size_t on = 1 + random_() % 3;  // a vertex, an edge or all of it
    for (std::size_t k = on; k < 3; ++k)
      t[k] += spread(1e-12) * (a - b).norm() * unit3();
    if (random_() % 8 == 0) t[2] = t[1] = t[0];
    if (random_() % 8 == 0) t[0] = 0.5 * t[1] + 0.5 * t[2];
    for (Vec3& v : t) {
      for (double& x : v) {
        if (random_() % 4 == 0) x = random_() % 2 != 0 ? up(x) : down(x);
      }
    }
    return t;
  }

  std::mt19937_64 random_{23};
  std::uniform_real_distribution<double> unit_{-1, 1}, unit01_{0, 1};
};

TEST_P(ExactFrustumFilter, AgreesWithExactArithmetic) {
  constexpr int kFrusta = 40, kEach = 50;
  std::uint64_t anyUndecided = 0, hardUndecided = 0, anyMet = 0, hardMet = 0;
  for (int round = 0; round < kFrusta; ++round) {
    const Frustum f = frustum(GetParam());
    const ExactFrustum any(f), hard(f);
    for (int i = 0; i < kEach; ++i) {
      const Triangle easy = anyTriangle(f), difficult = hardTriangle(f);
      const bool meetsEasy = any.meetsExactly(easy), meetsDifficult = hard.meetsExactly(difficult);
      ASSERT_EQ(any.meets(easy), meetsEasy) << "round " << round << ", triangle " << i;
      ASSERT_EQ(hard.meets(difficult), meetsDifficult) << "round " << round << ", hard triangle " << i;
      anyMet += meetsEasy ? 1 : 0, hardMet += meetsDifficult ? 1 : 0;
    }
    anyUndecided += any.exactDecisions(), hardUndecided += hard.exactDecisions();
  }
  std::printf("%-12s of %d: random %d meet, %d undecided; hard %d meet, %d undecided\n", GetParam().name,
              kFrusta * kEach, static_cast<int>(anyMet), static_cast<int>(anyUndecided),
              static_cast<int>(hardMet), static_cast<int>(hardUndecided));
  RecordProperty("undecidedOfRandom", static_cast<int>(anyUndecided));
  RecordProperty("undecidedOfHard", static_cast<int>(hardUndecided));
  // Both answers occur.
  EXPECT_GT(anyMet, 0U);
  EXPECT_LT(anyMet, std::uint64_t{kFrusta} * kEach);
}

INSTANTIATE_TEST_SUITE_P(
    Settings, ExactFrustumFilter,
    ::testing::Values(Setting{"plain", 0, 10, 50, 1, 0}, Setting{"tile", 0, 10, 50, 8, 0},
                      Setting{"nearFar", 0, 10, 50, 1, 100}, Setting{"nearFar1e12", 0, 10, 50, 1, 1e12},
                      Setting{"narrow", 0, 10, 0.001, 1, 0}, Setting{"narrowTile", 0, 10, 0.001, 64, 0},
                      Setting{"wide", 0, 10, 179.9, 1, 0}, Setting{"wideTile", 0, 10, 179.9, 64, 1e4},
                      Setting{"far1e6", 1e6, 1, 50, 4, 1e4}, Setting{"far1e8", 1e8, 1, 50, 4, 0},
                      Setting{"far1e12", 1e12, 100, 50, 3, 0}, Setting{"tiny", 0, 1e-9, 50, 3, 1e4},
                      Setting{"huge", 0, 1e9, 50, 3, 1e4}, Setting{"denormal", 0, 1e-311, 50, 3, 1e4},
                      Setting{"immense", 0, 1e150, 50, 3, 1e4}),
    [](const auto& setting) { return setting.param.name; });

}  // namespace
}  // namespace tessera
