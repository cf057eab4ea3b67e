#include "common/wall/grown_wall.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "common/wall/wall_file.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

std::vector<Wall> shippedWalls() {
  std::vector<Wall> walls;
  for (const auto& entry : fs::directory_iterator(fs::path(TESSERA_SOURCE_DIR) / "configs")) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("wall-") || !name.ends_with(".json")) continue;
    auto wall = readWallFile(entry.path());
    EXPECT_TRUE(wall.ok()) << name;
    if (wall) walls.push_back(std::move(*wall));
  }
  return walls;
}

CameraPose pose(bool withFov) {
  CameraPose pose{.eye = Vec3(3, 2, 10), .target = Vec3(-1, 0.5, 1), .up = Vec3(0.1, 1, 0)};
  if (withFov) pose.fovYRad = 0.7;
  return pose;
}

/// As seen from the eye: where a point `c` of the plain tile, about its middle `m`, has gone.
void expectGrown(const Frustum& plain, const Frustum& grown, double share) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& corner : plain.corners)
    middle += corner / 4;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 meant = middle + (1 + 2 * share) * (plain.corners[i] - middle) - plain.eye;
    const Vec3 is = grown.corners[i] - grown.eye;
    ASSERT_LT((meant.normalized() - is.normalized()).norm(), 1e-12);
  }
  ASSERT_EQ(plain.eye, grown.eye);
}

TEST(GrownWall, EveryTileShowsMoreOnEachSide) {
  const std::vector<Wall> walls = shippedWalls();
  ASSERT_GE(walls.size(), 14u);
  for (const Wall& wall : walls) {
    for (const double share : {0.0, 0.125, 0.3}) {
      const GrownWall grown = grownWall(wall, share);
      ASSERT_EQ(grown.wall.tiles.size(), wall.tiles.size());
      for (const bool withFov : {false, true}) {
        const WallView before = viewOf(wall, pose(withFov), Vec3::Zero(), 8);
        const WallView now = viewOf(grown.wall, grown.poseFor(pose(withFov)), Vec3::Zero(), 8);
        for (std::size_t t = 0; t < wall.tiles.size(); ++t) {
          expectGrown(before.tiles[t], now.tiles[t], share);
          if (!before.left.empty()) {
            expectGrown(before.left[t], now.left[t], share);
            expectGrown(before.right[t], now.right[t], share);
          }
        }
      }
    }
  }
}

TEST(GrownWall, ScreensHoldTheirTilesAndLatticesStay) {
  for (const Wall& wall : shippedWalls()) {
    const GrownWall grown = grownWall(wall, 0.125);
    for (const Tile& tile : grown.wall.tiles) {
      for (const Vec2& corner : tile.corners)
        EXPECT_LE(corner.cwiseAbs().maxCoeff(), 1 + 1e-12) << wall.source;
    }
    for (std::size_t s = 0; s < wall.screens.size(); ++s) {
      const Screen &before = wall.screens[s], &now = grown.wall.screens[s];
      EXPECT_NEAR(now.latticeWidth * now.widthMm, before.latticeWidth * before.widthMm, 1e-6);
      EXPECT_NEAR(now.latticeHeight * now.heightMm, before.latticeHeight * before.heightMm, 1e-6);
    }
  }
}

}  // namespace
}  // namespace tessera
