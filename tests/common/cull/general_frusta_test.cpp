// Frusta that are no grid: gaps, overlaps, different sizes, several screens about the eye; and frusta in a
// model's coordinates.
#include "common/hierarchy/general_frusta.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <boost/multiprecision/cpp_int.hpp>
#include <gtest/gtest.h>

#include "common/geometry/projection.h"
#include "common/hierarchy/grid_frusta.h"
#include "common/hierarchy/placed_frusta.h"
#include "tests/support/cull_scene.h"

namespace tessera::test {
namespace {

/// A rectangle [x0, x1] x [y0, y1] at distance 1 before an eye that is turned about the vertical.
struct Screen {
  double turnRad, x0, x1, y0, y1;
};

Frustum frustumOf(const Vec3& eye, const Screen& screen) {
  const Mat3 turn = Eigen::AngleAxisd(screen.turnRad, Vec3::UnitY()).toRotationMatrix();
  Frustum frustum;
  frustum.eye = eye;
  frustum.corners = {eye + turn * Vec3(screen.x0, screen.y0, -1), eye + turn * Vec3(screen.x1, screen.y0, -1),
                     eye + turn * Vec3(screen.x1, screen.y1, -1),
                     eye + turn * Vec3(screen.x0, screen.y1, -1)};
  return frustum;
}

struct Arrangement {
  const char* name;
  std::vector<Screen> screens;
  friend void PrintTo(const Arrangement& arrangement, std::ostream* out) { *out << arrangement.name; }
};

std::vector<Screen> grid(int columns, int rows, double step, double width) {
  std::vector<Screen> screens;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const double x = step * (c - columns / 2.0), y = step * (r - rows / 2.0);
      screens.push_back({0, x, x + width, y, y + width});
    }
  }
  return screens;
}

std::vector<Screen> scattered() {
  std::vector<Screen> screens;
  Geometry geometry(21);
  for (int i = 0; i < 24; ++i) {
    const double x = 2 * geometry.unit01() - 1, y = 2 * geometry.unit01() - 1;
    screens.push_back({6.2 * geometry.unit01(), x, x + 0.05 + 0.6 * geometry.unit01(), y,
                       y + 0.05 + 0.4 * geometry.unit01()});
  }
  return screens;
}

std::vector<Screen> cave() {
  std::vector<Screen> screens;
  for (int side = 0; side < 4; ++side)
    screens.push_back({side * std::numbers::pi / 2, -1, 1, -1, 1});
  return screens;
}

class GeneralFrustaContract : public ::testing::TestWithParam<Arrangement> {};

TEST_P(GeneralFrustaContract, HoldsForEveryAlgorithm) {
  for (const double offset : {0.0, 1e7}) {
    for (const bool separates : {true, false}) {
      for (const PlaneSource source : {PlaneSource::Corners, PlaneSource::Matrix}) {
        Geometry geometry(17);
        GeneralFrusta frusta({.separateOverlaps = separates, .source = source});
        for (int frame = 0; frame < 2; ++frame) {
          const Vec3 eye = Vec3(offset, -offset / 3, 0) + geometry.vector(1);
          std::vector<Frustum> tiles;
          for (Screen screen : GetParam().screens) {
            screen.turnRad += 0.7 * frame;
            tiles.push_back(frustumOf(eye, screen));
          }
          frusta.update(tiles);
          TriangleScene scene;
          for (int i = 0; i < 60; ++i)
            scene.leaves.push_back(geometry.any(eye, 10));
          for (int i = 0; i < 100; ++i)
            scene.leaves.push_back(geometry.hard(tiles));
          for (int i = 0; i < 15; ++i)
            scene.leaves.push_back(geometry.aboutTheEye(eye, 10));
          scene.build(geometry.engine());
          const auto meets = exactVisibility(tiles, scene.leaves);
          for (const Candidate& candidate : allCandidates()) {
            cull::Culler culler(scene.hierarchy, candidate.options);
            ASSERT_EQ(firstDrop(culler.cull(frusta), meets), "")
                << candidate.name << ", offset " << offset << ", frame " << frame;
          }
        }
      }
    }
  }
}

TEST_P(GeneralFrustaContract, ListsHardlyMoreThanNaiveCulling) {
  Geometry geometry(18);
  std::vector<Frustum> tiles;
  for (const Screen& screen : GetParam().screens)
    tiles.push_back(frustumOf(Vec3::Zero(), screen));
  GeneralFrusta frusta;
  frusta.update(tiles);
  TriangleScene scene;
  for (int i = 0; i < 2000; ++i)
    scene.leaves.push_back(geometry.any(Vec3::Zero(), 10));
  scene.build(geometry.engine());
  const auto pairs = [&](cull::Algorithm algorithm) {
    cull::Culler culler(scene.hierarchy, {.algorithm = algorithm});
    return static_cast<double>(culler.cull(frusta).pairs);
  };
  const double naive = pairs(cull::Algorithm::Naive);
  for (const cull::Algorithm algorithm : {cull::Algorithm::Fh, cull::Algorithm::Adaptive}) {
    EXPECT_LE(pairs(algorithm), 1.002 * naive + 2);
    EXPECT_GE(pairs(algorithm), 0.7 * naive - 2);  // bisections are more planes to be outside of
  }
}

INSTANTIATE_TEST_SUITE_P(
    Arrangements, GeneralFrustaContract,
    ::testing::Values(Arrangement{"single", {{0, -1, 1, -1, 1}}}, Arrangement{"gaps", grid(4, 3, 0.5, 0.4)},
                      Arrangement{"overlaps", grid(4, 3, 0.5, 0.6)},
                      Arrangement{"filled", grid(4, 4, 0.25, 0.25)},
                      Arrangement{"sizes", {{0, -1, 0, -1, 1}, {0, 0, 0.3, 0, 1}, {0, 0.3, 1, -1, 0.2}}},
                      Arrangement{"same", {{0, -1, 1, -1, 1}, {0, -1, 1, -1, 1}, {0, -1, 1, -1, 1}}},
                      Arrangement{"nested", {{0, -1, 1, -1, 1}, {0, -0.1, 0.1, -0.1, 0.1}}},
                      Arrangement{"noArea", {{0, 0.2, 0.2, -1, 1}, {0, -1, 0, -1, 1}, {0, 0.5, 1, 0, 0}}},
                      Arrangement{"cave", cave()}, Arrangement{"scattered", scattered()}),
    [](const auto& arrangement) { return arrangement.param.name; });

/// Plane classifications for a crowd of things of at most that size.
std::uint64_t testsOf(const FrustumHierarchy& frusta, cull::Algorithm algorithm, double size = 0.2) {
  Geometry geometry(19);
  TriangleScene scene;
  for (int i = 0; i < 3000; ++i)
    scene.leaves.push_back(geometry.any(Vec3(0, 0, -10) + geometry.vector(8), size));
  scene.build(geometry.engine());
  cull::Culler culler(scene.hierarchy, {.algorithm = algorithm});
  return culler.cull(frusta).tests.classifications();
}

std::vector<Frustum> frustaOf(const std::vector<Screen>& screens, const Vec3& eye = Vec3::Zero()) {
  std::vector<Frustum> frusta;
  for (const Screen& screen : screens)
    frusta.push_back(frustumOf(eye, screen));
  return frusta;
}

// Corners far from the origin are rounded to coarse steps, so rows and columns are not straight: a bisection
// plane then cuts into tiles on both sides, and has to give way by as much.
TEST(Frusta, HoldTheContractForALatticeThatIsNotStraight) {
  for (const double step : {1e-12, 1e-7, 1e-3}) {
    Geometry geometry(37);
    constexpr int kColumns = 6, kRows = 5;
    std::vector<Vec3> lattice;
    for (int row = 0; row <= kRows; ++row) {
      for (int column = 0; column <= kColumns; ++column)
        lattice.push_back(Vec3(0.2 * column - 0.6, 0.5 - 0.2 * row, -1) + geometry.vector(step));
    }
    const auto at = [&](int column, int row) {
      return lattice[static_cast<std::size_t>(row * (kColumns + 1) + column)];
    };
    Frustum wall;
    wall.corners = {at(0, kRows), at(kColumns, kRows), at(kColumns, 0), at(0, 0)};
    std::vector<Frustum> tiles;
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        tiles.emplace_back();
        tiles.back().corners = {at(column, row + 1), at(column + 1, row + 1), at(column + 1, row),
                                at(column, row)};
      }
    }
    TriangleScene scene;
    for (int i = 0; i < 400; ++i)
      scene.leaves.push_back(geometry.hard(tiles));
    for (int i = 0; i < 400; ++i) {  // small things by the lattice's points
      const Vec3 p =
          3 * at(static_cast<int>(geometry.below(kColumns + 1)), static_cast<int>(geometry.below(kRows + 1)));
      scene.leaves.push_back(
          {p + geometry.vector(3 * step), p + geometry.vector(3 * step), p + geometry.vector(3 * step)});
    }
    scene.build(geometry.engine());
    const auto meets = exactVisibility(tiles, scene.leaves);
    for (const PlaneSource source : {PlaneSource::Corners, PlaneSource::Matrix}) {
      GridFrusta frusta(kColumns, kRows, source);
      frusta.update(wall, tiles);
      GeneralFrusta general({.separateOverlaps = true, .source = source});
      general.update(tiles);
      for (const Candidate& candidate : allCandidates()) {
        cull::Culler culler(scene.hierarchy, candidate.options);
        ASSERT_EQ(firstDrop(culler.cull(frusta), meets), "") << candidate.name << ", step " << step;
        ASSERT_EQ(firstDrop(culler.cull(general), meets), "")
            << candidate.name << ", as any frusta, step " << step;
      }
    }
  }
}

TEST(GeneralFrusta, BisectsWell) {
  GeneralFrusta frusta;
  frusta.update(frustaOf(grid(16, 16, 0.1, 0.09)));
  // 256 tiles with gaps: a balanced tree needs 8 levels or a few more.
  std::vector<std::uint32_t> depth(frusta.nodeCount(), 0);
  std::uint32_t deepest = 0, most = 0;
  for (std::uint32_t i = 0; i < frusta.nodeCount(); ++i) {
    const FrustumHierarchy::Node& node = frusta.node(i);
    deepest = std::max(deepest, depth[i]);
    if (node.isLeaf()) {
      most = std::max(most, node.endLeafTile - node.firstLeafTile);
    } else {
      depth[node.negative] = depth[node.positive] = depth[i] + 1;
    }
  }
  EXPECT_LE(deepest, 16U);
  EXPECT_LE(most, 2U);
  EXPECT_LT(4 * testsOf(frusta, cull::Algorithm::Fh), testsOf(frusta, cull::Algorithm::Naive));
}

TEST(GeneralFrusta, SeparatesOverlapsWhereThatIsCheaper) {
  const std::vector<Frustum> tiles = frustaOf(grid(8, 8, 0.25, 0.3));
  GeneralFrusta separate, together({.separateOverlaps = false});
  separate.update(tiles);
  together.update(tiles);
  for (const double size : {0.02, 0.5, 2.0, 8.0}) {
    EXPECT_LT(2 * testsOf(separate, cull::Algorithm::Fh, size), testsOf(together, cull::Algorithm::Fh, size))
        << size;
  }
  // Frusta that are the same have nothing to separate.
  separate.update(frustaOf({{0, -1, 1, -1, 1}, {0, -1, 1, -1, 1}}));
  EXPECT_EQ(separate.nodeCount(), 1U);
}

TEST(GeneralFrusta, KeepsItsTopologyForAMovingCameraAndRenewsItForAMovingObserver) {
  GeneralFrusta frusta;
  std::vector<Screen> screens = grid(4, 4, 0.5, 0.4);
  for (int frame = 0; frame < 5; ++frame) {
    for (Screen& screen : screens)
      screen.turnRad += 0.3;
    frusta.update(frustaOf(screens, Vec3(frame, 0, 0)));
  }
  EXPECT_EQ(frusta.builds(), 1U);
  for (std::size_t i = 0; i < screens.size(); ++i)
    screens[i].x0 -= 0.3 * static_cast<double>(i % 3);
  frusta.update(frustaOf(screens));
  EXPECT_EQ(frusta.builds(), 2U);
}

TEST(PlacedFrusta, HoldTheContractForModelsPlacedAnyhow) {
  Geometry geometry(23);
  const auto placement = [&](int kind) {
    Mat4 matrix = Mat4::Identity();
    Mat3 linear =
        Eigen::AngleAxisd(geometry.unit01() * 6, geometry.vector(1).normalized()).toRotationMatrix();
    if (kind == 1) linear *= 1e-6;
    if (kind == 2) linear.col(0) *= -3;                   // mirrored, not uniform
    if (kind == 3) linear.col(1) += 0.7 * linear.col(0);  // sheared
    if (kind == 4) linear.col(2).setZero();               // flat
    if (kind == 5) linear *= 1e6;
    matrix.topLeftCorner<3, 3>() = linear;
    matrix.topRightCorner<3, 1>() = geometry.vector(kind == 5 ? 1e6 : 1);
    return matrix;
  };
  for (const double offset : {0.0, 1e6, 1e9}) {
    for (int kind = 0; kind < 6; ++kind) {
      Mat4 matrix = placement(kind);
      const Vec3 eye = Vec3(offset, 0, -offset) + geometry.vector(1);
      matrix.topRightCorner<3, 1>() += Vec3(offset, 0, -offset);
      const std::vector<Frustum> tiles = frustaOf(grid(3, 3, 0.4, 0.4), eye);
      GeneralFrusta world;
      world.update(tiles);
      PlacedFrusta placed;
      placed.update(world, matrix);
      TriangleScene model;
      for (int i = 0; i < 200; ++i)
        model.leaves.push_back(geometry.any(Vec3::Zero(), kind == 1 ? 1e6 : kind == 5 ? 1e-6 : 1));
      model.build(geometry.engine());
      // The world's triangles as exact as doubles go: those within a rounding of a plane are left out.
      const auto meets = [&](double shrink) {
        std::vector<Triangle> inWorld;
        for (const Triangle& triangle : model.leaves) {
          Triangle t;
          const Vec3 middle = (triangle[0] + triangle[1] + triangle[2]) / 3;
          for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 p = middle + (1 - shrink) * (triangle[i] - middle);
            t[i] = (matrix * p.homogeneous()).head<3>();
          }
          inWorld.push_back(t);
        }
        return exactVisibility(tiles, inWorld);
      };
      auto certain = meets(0);
      const auto shrunk = meets(1e-3);
      for (std::size_t tile = 0; tile < certain.size(); ++tile) {
        for (std::size_t leaf = 0; leaf < certain[tile].size(); ++leaf)
          certain[tile][leaf] = certain[tile][leaf] && shrunk[tile][leaf];
      }
      for (const Candidate& candidate : allCandidates()) {
        cull::Culler culler(model.hierarchy, candidate.options);
        ASSERT_EQ(firstDrop(culler.cull(placed), certain), "")
            << candidate.name << ", offset " << offset << ", placement " << kind;
      }
    }
  }
}

using Rational = boost::multiprecision::cpp_rational;
using Exact = std::array<Rational, 3>;

Exact exact(const Vec3& v) {
  return {Rational(v.x()), Rational(v.y()), Rational(v.z())};
}
Rational dot(const Exact& a, const Exact& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Boxes of a model that touch a plane of the world as nearly as doubles tell, judged exactly.
TEST(PlacedFrusta, NeverCallABoxOutsideThatIsNot) {
  Geometry geometry(71);
  int outside = 0, touching = 0;
  for (int i = 0; i < 6000; ++i) {
    const double offset = std::array{0.0, 1e4, 1e8}[geometry.below(3)];
    const Vec3 eye = geometry.vector(1) + Vec3(offset, -offset, offset / 3);
    const Vec3 a = eye + geometry.vector(1), b = eye + geometry.vector(1);
    const Mat3 linear = Mat3(Eigen::AngleAxisd(6 * geometry.unit01(), geometry.vector(1).normalized())) *
                        std::pow(10.0, 6 * geometry.unit01() - 3);
    const Vec3 translation = eye + geometry.vector(5);
    const BoundedPlane placed = inModelSpace(planeThroughEye(a - eye, b - eye), linear, translation - eye);
    Obb box;
    box.center = geometry.vector(3);
    for (Vec3& h : box.halfAxes)
      h = geometry.vector(0.1);
    // Moved along the normal until the farthest corner lies on the plane, give or take some ulps.
    const RelativeObb bounds(box, Vec3::Zero());
    const double value = placed.normal.dot(bounds.d) - placed.distance + bounds.radius(placed.normal);
    box.center -= value / placed.normal.squaredNorm() * placed.normal;
    for (double& x : box.center) {
      for (std::uint64_t ulps = geometry.below(4); ulps > 0; --ulps)
        x = std::nextafter(x, geometry.below(2) ? 1e300 : -1e300);
    }
    const Exact e = exact(eye), ea = exact(a), eb = exact(b);
    const Exact p = {eb[0] - e[0], eb[1] - e[1], eb[2] - e[2]},
                q = {ea[0] - e[0], ea[1] - e[1], ea[2] - e[2]};
    const Exact normal = {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
    const Exact t = exact(translation);
    Rational most = dot(normal, {t[0] - e[0], t[1] - e[1], t[2] - e[2]});
    const auto along = [&](const Vec3& v) {  // normal . (linear v)
      Rational sum = 0;
      for (int column = 0; column < 3; ++column)
        sum += dot(normal, exact(linear.col(column))) * Rational(v[column]);
      return sum;
    };
    most += along(box.center);
    for (const Vec3& h : box.halfAxes)
      most += abs(along(h));
    if (most >= 0) {
      ++touching;
      ASSERT_NE(classify(RelativeObb(box, Vec3::Zero()), placed), Side::Outside) << "case " << i;
    } else {
      ++outside;
    }
  }
  EXPECT_GT(touching, 1000);
  EXPECT_GT(outside, 1000);
}

TEST(PlacedFrusta, CullAPlacedModelAsTheWorldWould) {
  Geometry geometry(29);
  Mat4 matrix = Mat4::Identity();
  matrix.topLeftCorner<3, 3>() = Eigen::AngleAxisd(0.8, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  matrix.topRightCorner<3, 1>() = Vec3(0.5, 0.25, -6);
  TriangleScene model, world;
  for (int i = 0; i < 2000; ++i) {
    model.leaves.push_back(geometry.any(Vec3::Zero(), 5));
    Triangle t = model.leaves.back();
    for (Vec3& p : t)
      p = (matrix * p.homogeneous()).head<3>();
    world.leaves.push_back(t);
  }
  std::mt19937_64 same(4), again(4);
  model.build(same);
  world.build(again);
  GeneralFrusta frusta;
  frusta.update(frustaOf(grid(4, 4, 0.25, 0.25)));
  PlacedFrusta placed;
  placed.update(frusta, matrix);
  cull::Culler inModel(model.hierarchy, {}), inWorld(world.hierarchy, {});
  const double a = static_cast<double>(inModel.cull(placed).pairs);
  const double b = static_cast<double>(inWorld.cull(frusta).pairs);
  EXPECT_GT(a, 100);
  EXPECT_NEAR(a, b, 0.1 * b);  // boxes are fitted in different coordinates
}

/// A plane's unit normal and distance from the eye.
Eigen::Vector4d normalized(const Eigen::Vector4d& plane) {
  return plane / plane.head<3>().norm();
}

TEST(GribbHartmann, PlanesOfTheMatrixAreThePlanesOfTheCorners) {
  Geometry geometry(31);
  for (int i = 0; i < 100; ++i) {
    const Screen screen{6 * geometry.unit01(), -1 - geometry.unit01(), 0.5 + geometry.unit01(),
                        -0.2 - geometry.unit01(), geometry.unit01()};
    const Frustum frustum = frustumOf(Vec3::Zero(), screen);
    const Vec3 axis = Eigen::AngleAxisd(screen.turnRad, Vec3::UnitY()) * Vec3(0, 0, -1);
    const Mat4 viewProjection = relativeViewProjection(frustum.corners, axis, 0.5, 40);
    // In model space: the same matrix times a model's.
    Mat4 model = Mat4::Identity();
    model.topLeftCorner<3, 3>() =
        Eigen::AngleAxisd(geometry.unit01() * 6, geometry.vector(1).normalized()).toRotationMatrix() *
        (0.1 + geometry.unit01());
    model.topRightCorner<3, 1>() = geometry.vector(3);
    const auto world = gribbHartmannPlanes(viewProjection);
    const auto inModel = gribbHartmannPlanes(viewProjection * model);
    constexpr std::array kSides = {ClipPlane::Bottom, ClipPlane::Right, ClipPlane::Top, ClipPlane::Left};
    for (std::size_t side = 0; side < 4; ++side) {
      const BoundedPlane corner = planeThroughEye(frustum.corners[side], frustum.corners[(side + 1) % 4]);
      Eigen::Vector4d expected;
      expected << corner.normal, 0;
      const auto index = static_cast<std::size_t>(kSides[side]);
      EXPECT_LT((normalized(world[index]) - normalized(expected)).norm(), 1e-12);
      const BoundedPlane placed =
          inModelSpace(corner, model.topLeftCorner<3, 3>(), model.topRightCorner<3, 1>());
      expected << placed.normal, -placed.distance;
      EXPECT_LT((normalized(inModel[index]) - normalized(expected)).norm(), 1e-12);
    }
    Eigen::Vector4d near, far;
    near << axis, -0.5;
    far << -axis, 40;
    EXPECT_LT((normalized(world[static_cast<std::size_t>(ClipPlane::Near)]) - near).norm(), 1e-11);
    EXPECT_LT((normalized(world[static_cast<std::size_t>(ClipPlane::Far)]) - far).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace tessera::test
