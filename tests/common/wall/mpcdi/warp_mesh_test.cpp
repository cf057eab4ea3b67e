#include "common/wall/mpcdi/warp_mesh.h"

#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace tessera {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A region of so many pixels with a map of as many samples; `at(s, t)` gives u from the left and v from the
/// top for the point (s, t) of the projector's picture, from its upper left corner.
MpcdiRegion regionOf(int columns, int rows, const std::function<std::array<double, 2>(double, double)>& at) {
  MpcdiRegion region;
  region.widthPx = columns;
  region.heightPx = rows;
  MpcdiWarp warp;
  warp.columns = columns;
  warp.rows = rows;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const auto [u, v] = at((column + 0.5) / columns, (row + 0.5) / rows);
      warp.xyz.push_back(static_cast<float>(u));
      warp.xyz.push_back(static_cast<float>(1 - v));
      warp.xyz.push_back(0);
    }
  }
  region.warp = std::move(warp);
  return region;
}

/// Where the mesh looks from (s, t), by the rule that warp_mesh.h states; NaN in cells with a hole.
std::array<double, 2> lookedAt(const WarpMesh& mesh, double s, double t) {
  const double x = s * (mesh.columns - 1), y = t * (mesh.rows - 1);
  const int c = std::min(static_cast<int>(x), mesh.columns - 2),
            r = std::min(static_cast<int>(y), mesh.rows - 2);
  const auto vertex = [&](int column, int row, int i) {
    return double{mesh.uv[static_cast<std::size_t>(2 * (row * mesh.columns + column) + i)]};
  };
  std::array<double, 2> uv{};
  for (int i = 0; i < 2; ++i) {
    const double upper = vertex(c, r, i) * (1 - (x - c)) + vertex(c + 1, r, i) * (x - c);
    const double lower = vertex(c, r + 1, i) * (1 - (x - c)) + vertex(c + 1, r + 1, i) * (x - c);
    uv[static_cast<std::size_t>(i)] = upper * (1 - (y - r)) + lower * (y - r);
  }
  return uv;
}

/// The largest distance between mesh and map over all samples, in pixels.
double measuredPx(const WarpMesh& mesh, const MpcdiRegion& region) {
  double worst = 0;
  const MpcdiWarp& warp = *region.warp;
  for (int row = 0; row < warp.rows; ++row) {
    for (int column = 0; column < warp.columns; ++column) {
      const float* xyz = warp.xyz.data() + 3 * (row * warp.columns + column);
      if (std::isnan(xyz[0])) continue;
      const auto [u, v] = lookedAt(mesh, (column + 0.5) / warp.columns, (row + 0.5) / warp.rows);
      const double du = (u - double{xyz[0]}) * region.widthPx;
      const double dv = (v - (1 - double{xyz[1]})) * region.heightPx;
      worst = std::max(worst, std::isnan(du) ? INFINITY : std::hypot(du, dv));
    }
  }
  return worst;
}

/// A projector's usual lot: keystone, rotation and the barrel of a lens.
std::array<double, 2> lens(double s, double t) {
  const double x = s - 0.5, y = t - 0.5, radius = x * x + y * y;
  const double bx = x * (1 + 0.08 * radius), by = y * (1 + 0.08 * radius), w = 1 + 0.1 * bx - 0.05 * by;
  return {0.5 + (0.9 * bx - 0.03 * by) / w, 0.5 + (0.9 * by + 0.03 * bx) / w};
}

TEST(WarpMesh, withoutAMapNothingIsBent) {
  MpcdiRegion region;
  region.widthPx = region.heightPx = 10;
  const WarpMesh mesh = warpMeshOf(region, 0.1);
  EXPECT_EQ(mesh.columns, 2);
  EXPECT_EQ(mesh.rows, 2);
  EXPECT_EQ(mesh.uv, (std::vector<float>{0, 0, 1, 0, 0, 1, 1, 1}));
  EXPECT_EQ(mesh.errorPx, 0);
  EXPECT_TRUE(alphaOf(region).isEmpty());
}

TEST(WarpMesh, aMapThatBendsNothingNeedsFourVertices) {
  const MpcdiRegion region = regionOf(64, 48, [](double s, double t) { return std::array{s, t}; });
  const WarpMesh mesh = warpMeshOf(region, 0.01);
  EXPECT_EQ(mesh.columns, 2);
  EXPECT_EQ(mesh.rows, 2);
  const float corners[8] = {0, 0, 1, 0, 0, 1, 1, 1};
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_NEAR(mesh.uv[i], corners[i], 1e-5) << "the outer vertices lie on the picture's edges";
}

TEST(WarpMesh, keepsWithinItsBoundAndMeasuresItself) {
  const MpcdiRegion region = regionOf(640, 400, lens);
  std::size_t vertices = 0;
  for (const double bound : {4.0, 1.0, 0.25, 0.0625}) {
    const WarpMesh mesh = warpMeshOf(region, bound);
    EXPECT_LE(mesh.errorPx, bound);
    EXPECT_NEAR(mesh.errorPx, measuredPx(mesh, region), 1e-5) << "the error it states is the error it has";
    EXPECT_GT(mesh.uv.size(), vertices) << "finer bounds need more vertices";
    vertices = mesh.uv.size();
    RecordProperty("vertices at " + std::to_string(bound),
                   std::to_string(mesh.columns) + " x " + std::to_string(mesh.rows));
  }
  EXPECT_LT(vertices, 2u * 100 * 100) << "a smooth map of 640 x 400 samples needs few vertices";
}

TEST(WarpMesh, isNoFinerThanItMustBe) {
  // Bent across, straight down: one cell down is enough.
  const MpcdiRegion region = regionOf(300, 200, [](double s, double t) { return std::array{s * s, t}; });
  const WarpMesh mesh = warpMeshOf(region, 0.1);
  EXPECT_EQ(mesh.rows, 2);
  // A parabola of height 1 over n cells misses by 1 / (4 n^2) in the middle of each: 300 px need n = 28.
  EXPECT_NEAR(mesh.columns - 1, std::ceil(std::sqrt(300 / (4 * 0.1))), 2);
}

TEST(WarpMesh, noiseGetsTheFinestMesh) {
  unsigned state = 1;
  const MpcdiRegion region = regionOf(40, 30, [&](double, double) {
    state = state * 1664525U + 1013904223U;
    return std::array{double(state >> 8) / 0x1000000, 0.5};
  });
  const WarpMesh mesh = warpMeshOf(region, 0.001);
  EXPECT_EQ(mesh.columns, 41);
  EXPECT_EQ(mesh.rows, 31);
  EXPECT_GT(mesh.errorPx, 0.001) << "and says that it missed";
}

TEST(WarpMesh, samplesBesideHolesAreKept) {
  const auto isHole = [](double s, double t) { return std::hypot(s - 0.6, t - 0.4) < 0.2 || s + t < 0.3; };
  const auto inside = [](double s, double t) {
    const auto [u, v] = lens(s, t);
    return std::array{0.1 + 0.8 * u, 0.1 + 0.8 * v};
  };
  const MpcdiRegion region = regionOf(320, 200, [&](double s, double t) {
    return isHole(s, t) ? std::array{double{kNan}, double{kNan}} : inside(s, t);
  });
  const WarpMesh mesh = warpMeshOf(region, 0.05);
  EXPECT_LE(mesh.errorPx, 0.05);
  EXPECT_NEAR(mesh.errorPx, measuredPx(mesh, region), 1e-5);
  const MpcdiMap alpha = alphaOf(region);
  ASSERT_EQ(alpha.widthPx, 320);
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 320; ++x) {
      EXPECT_EQ(alpha.values[static_cast<std::size_t>(y * 320 + x)],
                isHole((x + 0.5) / 320, (y + 0.5) / 200) ? 0 : 65535)
          << x << ' ' << y;
    }
  }
}

TEST(WarpMesh, vertexesFarInsideAHoleShowNothing) {
  const MpcdiRegion region = regionOf(200, 200, [](double s, double t) {
    return s < 0.5 ? std::array{double{kNan}, double{kNan}}
                   : std::array{0.5 + 0.4 * std::sin(s * 20) / 10, t * t};
  });
  const WarpMesh mesh = warpMeshOf(region, 0.05);
  EXPECT_LE(mesh.errorPx, 0.05);
  EXPECT_TRUE(std::isnan(mesh.uv[0])) << "upper left vertex";
  EXPECT_FALSE(std::isnan(mesh.uv[static_cast<std::size_t>(2 * (mesh.columns - 1))])) << "upper right vertex";
}

TEST(WarpMesh, nothingButHoles) {
  const MpcdiRegion region = regionOf(20, 20, [](double, double) {
    return std::array{double{kNan}, double{kNan}};
  });
  const WarpMesh mesh = warpMeshOf(region, 0.1);
  EXPECT_EQ(mesh.columns, 2);
  for (const float value : mesh.uv)
    EXPECT_TRUE(std::isnan(value));
  for (const std::uint16_t value : alphaOf(region).values)
    EXPECT_EQ(value, 0);
}

TEST(WarpMesh, smallestMaps) {
  for (const auto& [columns, rows] : {std::pair{1, 1}, {1, 7}, {7, 1}, {2, 2}}) {
    const MpcdiRegion region = regionOf(columns, rows, [](double s, double t) { return std::array{s, t}; });
    const WarpMesh mesh = warpMeshOf(region, 0.1);
    EXPECT_GE(mesh.columns, 2);
    EXPECT_LE(measuredPx(mesh, region), 0.1) << columns << " x " << rows;
  }
}

TEST(WarpMesh, alphaIsCutWhereTheMapLooksPastThePicture) {
  MpcdiRegion region = regionOf(10, 10, [](double s, double t) { return std::array{s * 2 - 0.5, t}; });
  region.alpha.widthPx = 20;
  region.alpha.heightPx = 5;
  region.alpha.gammaEmbedded = 2;
  region.alpha.values.assign(100, 1234);
  const MpcdiMap alpha = alphaOf(region);
  EXPECT_EQ(alpha.widthPx, 20);
  EXPECT_EQ(alpha.gammaEmbedded, 2);
  // Samples 0 and 1 look at -0.4 and -0.2; sample 2, at 0, is the first that looks at the picture.
  EXPECT_EQ(alpha.values[3], 0);
  EXPECT_EQ(alpha.values[4], 1234);
  EXPECT_EQ(alpha.values[15], 1234);
  EXPECT_EQ(alpha.values[16], 0);
}

TEST(WarpMesh, fullHdIsQuick) {
  const MpcdiRegion region = regionOf(1920, 1080, lens);
  const auto begin = std::chrono::steady_clock::now();
  const WarpMesh mesh = warpMeshOf(region, 0.1);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  RecordProperty("mesh", std::to_string(mesh.columns) + " x " + std::to_string(mesh.rows));
  RecordProperty("error_px", std::to_string(mesh.errorPx));
  RecordProperty("seconds", std::to_string(seconds));
  EXPECT_LE(mesh.errorPx, 0.1);
  EXPECT_LT(seconds, 30) << "seconds on any machine that tests run on";
}

/// A region whose projector lights points of the plane z = -4.
MpcdiRegion wallOfPoints() {
  MpcdiRegion region = regionOf(60, 40, [](double s, double t) { return std::array{s, t}; });
  region.id = "w";
  region.warp->isInSpace = true;
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 60; ++column) {
      float* xyz = region.warp->xyz.data() + 3 * (row * 60 + column);
      const double s = (column + 0.5) / 60, t = (row + 0.5) / 40;
      xyz[0] = static_cast<float>(-3 + 6 * s);
      xyz[1] = static_cast<float>(2 - 4 * t + 0.2 * s);
      xyz[2] = -4;
    }
  }
  return region;
}

TEST(WarpMeshSeenFrom, findsThePictureBehindEachPoint) {
  const MpcdiRegion region = wallOfPoints();
  // A picture half as far and half as large: the eye sees it over the whole wall.
  const PictureRectangle picture{Vec3(-1.5, -1, -2), Vec3(1.5, -1, -2), Vec3(-1.5, 1, -2)};
  const WarpMesh mesh = warpMeshSeenFrom(region, Vec3::Zero(), picture, 0.01);
  ASSERT_EQ(mesh.columns, 2);
  ASSERT_EQ(mesh.rows, 2);
  // v counts from the top; the wall's points lean by 0.2 m of 4 m from left to right.
  const double expected[8] = {0, 0, 1, -0.05, 0, 1, 1, 0.95};
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_NEAR(mesh.uv[i], expected[i], 1e-5) << i;
  // An eye beside it sees another part of the picture.
  const WarpMesh beside = warpMeshSeenFrom(region, Vec3(1, 0, 0), picture, 0.01);
  EXPECT_NEAR(beside.uv[0], 0.5 / 3, 1e-5);
  EXPECT_EQ(warpMeshOf(region, 0.1).columns, 0) << "points in space are no map of a picture";
}

TEST(WarpMeshSeenFrom, pointsBehindTheEyeAreHoles) {
  const MpcdiRegion region = wallOfPoints();
  const PictureRectangle picture{Vec3(-1.5, -1, -8), Vec3(1.5, -1, -8), Vec3(-1.5, 1, -8)};
  const WarpMesh mesh = warpMeshSeenFrom(region, Vec3(0, 0, -6), picture, 0.01);
  EXPECT_TRUE(std::isnan(mesh.uv[0]));
  MpcdiRegion plain = region;
  plain.warp->isInSpace = false;
  EXPECT_EQ(warpMeshSeenFrom(plain, Vec3::Zero(), picture, 0.01).columns, 0);
}

TEST(PictureAround, holdsAllPointsAsTheEyeSeesThem) {
  const MpcdiRegion region = wallOfPoints();
  const Vec3 eye(0.5, 1, 0);
  const Result<PictureRectangle> picture = pictureAround(region, eye);
  ASSERT_TRUE(picture.ok()) << picture.error().text();
  const WarpMesh mesh = warpMeshSeenFrom(region, eye, *picture, 0.01);
  double least = 1, most = 0;
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 60; ++column) {
      const auto [u, v] = lookedAt(mesh, (column + 0.5) / 60, (row + 0.5) / 40);
      least = std::min({least, u, v});
      most = std::max({most, u, v});
    }
  }
  EXPECT_NEAR(least, 0, 1e-3);
  EXPECT_NEAR(most, 1, 1e-3);
  EXPECT_FALSE(pictureAround(region, Vec3(0, 0, -4)).ok()) << "in the plane of the points";
  MpcdiRegion none = region;
  none.warp->xyz.assign(none.warp->xyz.size(), kNan);
  EXPECT_FALSE(pictureAround(none, eye).ok());
}

}  // namespace
}  // namespace tessera
