#include "common/wall/wall.h"

#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "common/wall/wall_file.h"

namespace tessera {
namespace {

using LongVec3 = Eigen::Matrix<long double, 3, 1>;

struct Scene {
  Vec3 center = Vec3::Zero();
  double radius = 1;
};

Wall gridOf(int columns, int rows, int widthPx, int heightPx, double fovYDeg) {
  Result<Wall> wall = parseWall("{\"grid\": {\"columns\": " + std::to_string(columns) +
                                    ", \"rows\": " + std::to_string(rows) + ", \"tile_px\": [" +
                                    std::to_string(widthPx) + ", " + std::to_string(heightPx) + "]}}",
                                "test");
  EXPECT_TRUE(wall.ok());
  wall->fovYRad = fovYDeg * std::numbers::pi / 180;
  return *wall;
}

bool sameBits(const Vec3& a, const Vec3& b) {
  return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0;
}

bool sameBits(const Frustum& a, const Frustum& b) {
  bool same = sameBits(a.eye, b.eye) && a.near == b.near && a.far == b.far;
  for (std::size_t i = 0; i < 4; ++i)
    same = same && sameBits(a.corners[i], b.corners[i]);
  return same;
}

const Frustum& tileAt(const Wall& wall, const WallView& view, int column, int row) {
  return view.tiles[static_cast<std::size_t>(row * wall.screens[0].columns + column)];
}

class Random {
 public:
  double uniform(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(engine_);
  }
  Vec3 unit() {
    Vec3 v;
    do {
      v = Vec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    } while (v.norm() < 0.1 || v.norm() > 1);
    return v.normalized();
  }

 private:
  std::mt19937_64 engine_{7};
};

/// Poses near and far, scenes small and large, narrow and wide fields of view.
template <class Check>
void forRandomViews(Check check) {
  Random random;
  for (const double scale : {1e-9, 1.0, 1e9}) {
    for (const double offset : {0.0, 1.0, 1e8}) {
      for (const double fovYDeg : {kMinFovYDeg, 1.0, 50.0, 120.0, kMaxFovYDeg}) {
        for (int i = 0; i < 20; ++i) {
          const Scene scene{offset * random.unit(), scale};
          CameraPose pose;
          pose.eye = scene.center + random.uniform(0, 5) * scale * random.unit();
          // Far enough for the direction to survive the rounding of the coordinates.
          pose.target = pose.eye + std::max(scale, 1e-6 * offset) * random.unit();
          do {
            pose.up = random.unit();
          } while ((pose.target - pose.eye).normalized().cross(pose.up).norm() < 0.1);
          check(scene, pose, fovYDeg);
        }
      }
    }
  }
}

TEST(Wall, neighboursShareCornersBitForBit) {
  const Wall wall = gridOf(7, 5, 33, 21, 50);
  forRandomViews([&](const Scene& scene, const CameraPose& pose, double) {
    const WallView view = viewOf(wall, pose, scene.center, scene.radius);
    ASSERT_EQ(view.tiles.size(), 35u);
    for (int row = 0; row < wall.screens[0].rows; ++row) {
      for (int column = 0; column < wall.screens[0].columns; ++column) {
        const Frustum& tile = tileAt(wall, view, column, row);
        if (column + 1 < wall.screens[0].columns) {
          const Frustum& right = tileAt(wall, view, column + 1, row);
          ASSERT_TRUE(sameBits(tile.corners[1], right.corners[0]));
          ASSERT_TRUE(sameBits(tile.corners[2], right.corners[3]));
        }
        if (row + 1 < wall.screens[0].rows) {
          const Frustum& below = tileAt(wall, view, column, row + 1);
          ASSERT_TRUE(sameBits(tile.corners[0], below.corners[3]));
          ASSERT_TRUE(sameBits(tile.corners[1], below.corners[2]));
        }
        ASSERT_EQ(tile.near, view.screens[0].near);
        ASSERT_EQ(tile.far, view.screens[0].far);
        ASSERT_TRUE(sameBits(tile.eye, pose.eye));
      }
    }
  });
}

TEST(Wall, aViewIsTheSameInMemoryUsedBefore) {
  WallView view;
  for (const int columns : {7, 3, 5}) {
    const Wall wall = gridOf(columns, 5, 33, 21, 50);
    forRandomViews([&](const Scene& scene, const CameraPose& pose, double) {
      viewInto(wall, pose, scene.center, scene.radius, view);
      const WallView fresh = viewOf(wall, pose, scene.center, scene.radius);
      ASSERT_EQ(view.tiles.size(), fresh.tiles.size());
      for (std::size_t i = 0; i < view.tiles.size(); ++i) {
        for (std::size_t corner = 0; corner < 4; ++corner)
          ASSERT_TRUE(sameBits(view.tiles[i].corners[corner], fresh.tiles[i].corners[corner]));
      }
      ASSERT_TRUE(sameBits(view.axes[0].right, fresh.axes[0].right));
      ASSERT_EQ(view.screens[0].far, fresh.screens[0].far);
    });
  }
}

TEST(Wall, outermostCornersAreThePrimaryFrustums) {
  const Wall wall = gridOf(7, 5, 33, 21, 50);
  forRandomViews([&](const Scene& scene, const CameraPose& pose, double) {
    const WallView view = viewOf(wall, pose, scene.center, scene.radius);
    ASSERT_TRUE(sameBits(view.screens[0].corners[0], tileAt(wall, view, 0, 4).corners[0]));
    ASSERT_TRUE(sameBits(view.screens[0].corners[1], tileAt(wall, view, 6, 4).corners[1]));
    ASSERT_TRUE(sameBits(view.screens[0].corners[2], tileAt(wall, view, 6, 0).corners[2]));
    ASSERT_TRUE(sameBits(view.screens[0].corners[3], tileAt(wall, view, 0, 0).corners[3]));
  });
}

TEST(Wall, untiledHasTheSamePrimaryFrustumBitForBit) {
  Wall wall = gridOf(7, 3, 33, 21, 50);
  const Wall whole = wall.untiled();
  EXPECT_EQ(whole.tiles[0].heightPx, wall.tiles[0].canvasHeightPx);
  ASSERT_EQ(whole.tiles.size(), 1u);
  EXPECT_EQ(whole.tiles[0].name, "wall");
  EXPECT_EQ(whole.tiles[0].widthPx, 231);
  forRandomViews([&](const Scene& scene, CameraPose pose, double fovYDeg) {
    pose.fovYRad = fovYDeg * std::numbers::pi / 180;
    const WallView tiled = viewOf(wall, pose, scene.center, scene.radius);
    const WallView untiled = viewOf(whole, pose, scene.center, scene.radius);
    ASSERT_TRUE(sameBits(tiled.screens[0], untiled.screens[0]));
    ASSERT_EQ(untiled.tiles.size(), 1u);
    ASSERT_TRUE(sameBits(tiled.screens[0], untiled.tiles[0]));
  });
}

/// Where a corner lies in the picture, in units of half its height from its middle, by long double from the
/// pose alone.
struct Oracle {
  LongVec3 forward, right, up;

  explicit Oracle(const CameraPose& pose) {
    forward = (pose.target.cast<long double>() - pose.eye.cast<long double>()).normalized();
    right = forward.cross(pose.up.cast<long double>()).normalized();
    up = right.cross(forward);
  }
  /// Angle between the ray to `corner` and the ray through (x, y) of the picture.
  long double angleTo(const Vec3& eye, const Vec3& corner, long double x, long double y,
                      long double fovYRad) const {
    const long double halfHeight = std::tan(fovYRad / 2);
    const LongVec3 exact = (forward + right * (halfHeight * x) + up * (halfHeight * y)).normalized();
    const LongVec3 ray = (corner.cast<long double>() - eye.cast<long double>()).normalized();
    return exact.cross(ray).norm();
  }
};

TEST(Wall, cornersLieWhereTheFormulaSays) {
  const Wall wall = gridOf(4, 3, 480, 270, 50);
  const long double aspect = (4.0L * 480) / (3.0L * 270);
  forRandomViews([&](const Scene& scene, CameraPose pose, double fovYDeg) {
    pose.fovYRad = fovYDeg * std::numbers::pi / 180;
    const WallView view = viewOf(wall, pose, scene.center, scene.radius);
    const Oracle oracle(pose);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        const long double x = aspect * (2 * column - 4) / 4;
        const long double y = (3 - 2 * row) / 3.0L;
        const Vec3& upperLeft = tileAt(wall, view, column, row).corners[3];
        // A handful of roundings; even at 0.001 degrees over 810 rows a pixel is 2e-8 rad.
        ASSERT_LT(static_cast<double>(oracle.angleTo(pose.eye, upperLeft, x, y, *pose.fovYRad)),
                  16 * kUnitRoundoff)
            << "fov " << fovYDeg << " row " << row << " column " << column;
      }
    }
  });
}

TEST(Wall, axesAreOrthonormalAndFollowTheWall) {
  const Wall wall = gridOf(2, 2, 480, 270, 50);
  forRandomViews([&](const Scene& scene, const CameraPose& pose, double) {
    const WallView view = viewOf(wall, pose, scene.center, scene.radius);
    ASSERT_NEAR(view.axes[0].right.norm(), 1, 1e-15);
    ASSERT_NEAR(view.axes[0].up.norm(), 1, 1e-15);
    ASSERT_NEAR(view.axes[0].right.dot(view.axes[0].up), 0, 1e-15);
    ASSERT_GT(view.axes[0].right.dot(view.screens[0].corners[1] - view.screens[0].corners[0]), 0);
    ASSERT_GT(view.axes[0].up.dot(view.screens[0].corners[3] - view.screens[0].corners[0]), 0);
    ASSERT_GT(view.axes[0].up.dot(pose.up), 0);
  });
}

TEST(Wall, fittedDepthsContainTheScene) {
  const Wall wall = gridOf(2, 2, 480, 270, 50);
  forRandomViews([&](const Scene& scene, const CameraPose& pose, double) {
    const WallView view = viewOf(wall, pose, scene.center, scene.radius);
    const Oracle oracle(pose);
    const LongVec3 toCenter = scene.center.cast<long double>() - pose.eye.cast<long double>();
    const auto depth = static_cast<double>(oracle.forward.dot(toCenter));
    const double near = *view.screens[0].near;
    const double far = *view.screens[0].far;
    ASSERT_GT(near, 0);
    ASSERT_LT(near, far);
    ASSERT_TRUE(std::isfinite(far));
    ASSERT_GE(far, depth + scene.radius);
    // Nearer than that the scene may be cut for the sake of the depth buffer.
    ASSERT_LE(near, std::max(depth - scene.radius, far / 2e3));
  });
}

TEST(Wall, fitsTightlyAroundASceneInFront) {
  const Wall wall = gridOf(1, 1, 100, 100, 50);
  const WallView view = viewOf(wall, {.eye = {0, 0, 10}, .target = {0, 0, 0}}, Vec3::Zero(), 1);
  EXPECT_NEAR(*view.screens[0].near, 9, 0.01);
  EXPECT_NEAR(*view.screens[0].far, 11, 0.01);
}

TEST(Wall, aSceneBehindTheEyeStillGivesAView) {
  const Wall wall = gridOf(1, 1, 100, 100, 50);
  const WallView view = viewOf(wall, {.eye = {0, 0, 10}, .target = {0, 0, 20}}, Vec3::Zero(), 1);
  EXPECT_GT(*view.screens[0].near, 0);
  EXPECT_GT(*view.screens[0].far, *view.screens[0].near);
}

TEST(Wall, theFilesDistancesComeFirst) {
  Wall wall = gridOf(1, 1, 100, 100, 50);
  const CameraPose pose{.eye = {0, 0, 10}, .target = {0, 0, 0}};
  const auto depths = [&](std::optional<double> near, std::optional<double> far) {
    wall.near = near;
    wall.far = far;
    const Frustum frustum = viewOf(wall, pose, Vec3::Zero(), 1).screens[0];
    EXPECT_LT(*frustum.near, *frustum.far);
    return std::pair(*frustum.near, *frustum.far);
  };
  EXPECT_EQ(depths(0.25, 500.0), std::pair(0.25, 500.0));
  EXPECT_EQ(depths(0.25, {}).first, 0.25);
  EXPECT_NEAR(depths(0.25, {}).second, 11, 0.01);
  EXPECT_NEAR(depths({}, 1e9).first, 9, 0.01);
  EXPECT_EQ(depths({}, 5.0).second, 5.0);   // all of the scene lies behind it
  EXPECT_EQ(depths(50.0, {}).first, 50.0);  // or before it
}

TEST(Wall, knownCornersOfASimpleView) {
  const Wall wall = gridOf(2, 2, 100, 100, 90);
  const WallView view = viewOf(wall, {.eye = {0, 0, 4}, .target = {0, 0, 0}}, Vec3::Zero(), 1);
  const Frustum& upperLeft = tileAt(wall, view, 0, 0);
  const double distance = 4 - upperLeft.corners[2].z();
  const Vec3 expected[4] = {{-1, 0, -1}, {0, 0, -1}, {0, 1, -1}, {-1, 1, -1}};
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 ray = (upperLeft.corners[i] - view.screens[0].eye) / distance;
    EXPECT_LT((ray - expected[i]).norm(), 1e-14) << i;
  }
}

TEST(Wall, brokenPosesGiveFiniteViews) {
  const Wall wall = gridOf(2, 2, 480, 270, 50);
  const CameraPose poses[] = {
      {.eye = {1, 2, 3}, .target = {1, 2, 3}},
      {.eye = {0, 0, 0}, .target = {0, 1, 0}, .up = {0, 1, 0}},
      {.eye = {0, 0, 0}, .target = {0, -1, 0}, .up = {0, 1, 0}},
      {.eye = {0, 0, 0}, .target = {0, 0, 1}, .up = {0, 0, 1}},
      {.eye = {0, 0, 0}, .target = {1, 1, 1}, .up = {1, 1, 1 + 1e-12}},
      {.eye = {0, 0, 0}, .target = {1, 1, 1}, .up = {0, 0, 0}},
      {.eye = {0, 0, 0}, .target = {1e-200, 0, 0}, .up = {0, 1e-200, 0}},
      {.eye = {0, 0, 0}, .target = {1e200, 0, 0}, .up = {0, 1e200, 0}},
  };
  for (const CameraPose& pose : poses) {
    const WallView view = viewOf(wall, pose, Vec3::Zero(), 1);
    for (const Frustum& tile : view.tiles) {
      for (const Vec3& corner : tile.corners)
        EXPECT_TRUE(isFinite(corner));
    }
    EXPECT_NEAR(view.axes[0].right.norm(), 1, 1e-15);
    EXPECT_NEAR(view.axes[0].up.norm(), 1, 1e-15);
    EXPECT_NEAR(view.axes[0].right.dot(view.axes[0].up), 0, 1e-15);
  }
}

}  // namespace
}  // namespace tessera
