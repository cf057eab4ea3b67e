#include "server/master/tile_setup.h"

#include <gtest/gtest.h>

#include "common/wall/wall_file.h"
#include "proto/codec.h"

namespace tessera {
namespace {

Wall wallFrom(const std::string& text) {
  const Result<Wall> wall = parseWall(text, "w.json");
  EXPECT_TRUE(wall.ok()) << wall.error().text();
  return *wall;
}

TEST(TileSetups, tellWhereTilesHangAndWhatTheirDisplaysNeed) {
  const Wall wall =
      wallFrom(R"({"grid": {"columns": 2, "rows": 1, "tile_px": [100, 80], "tile_mm": [500, 400],
      "overlap_px": [20, 0], "tile": {"gamma": 1.8}}, "tiles": {"r0c1": {"gain_rgb": [1, 0.5, 2]}}})");
  const auto setups = TileSetups::make(wall);
  ASSERT_TRUE(setups.ok()) << setups.error().text();
  const proto::TileSetup& right = setups->of(1);
  EXPECT_NEAR(right.screenWidthM, 0.9, 1e-12);
  EXPECT_NEAR(right.cornersM[0].x(), 0.4, 1e-12);
  EXPECT_NEAR(right.cornersM[2].x(), 0.9, 1e-12);
  EXPECT_NEAR(right.cornersM[2].y(), 0.4, 1e-12);
  EXPECT_FLOAT_EQ(right.gamma, 1.8F);
  EXPECT_EQ(right.gainRgb, (std::array<float, 3>{1, 0.5F, 2}));
  EXPECT_EQ(right.blendPx, (std::array<float, 4>{20, 0, 0, 0}));
  EXPECT_EQ(setups->of(0).gainRgb, (std::array<float, 3>{1, 1, 1}));
}

TEST(TileSetups, ofTurnedPanelsAreTurned) {
  const Wall wall =
      wallFrom(R"({"grid": {"columns": 1, "rows": 1, "tile_px": [160, 90], "rotation_deg": 90}})");
  const auto setups = TileSetups::make(wall);
  ASSERT_TRUE(setups.ok());
  const proto::TileSetup& setup = setups->of(0);
  EXPECT_NEAR(setup.screenWidthM, 0.09, 1e-12);
  // The picture's lower left corner is at the screen's upper left, its upper edge at the right.
  EXPECT_LT((setup.cornersM[0] - Vec2(0, 0.16)).norm(), 1e-12);
  EXPECT_LT((setup.cornersM[3] - Vec2(0.09, 0.16)).norm(), 1e-12);
  EXPECT_LT((setup.cornersM[1] - Vec2(0, 0)).norm(), 1e-12);
}

TEST(TileSetups, areMessagesThatTilesAccept) {
  const Wall wall = wallFrom(R"({"screens": [{"size_mm": [1000, 500], "tiles": [
      {"name": "t", "px": [100, 50], "size_mm": [200, 100], "center_mm": [500, 250], "rotation_deg": 30,
       "black_rgb": [0.1, 0, 0]}]}]})");
  const auto setups = TileSetups::make(wall);
  ASSERT_TRUE(setups.ok());
  const proto::Bytes bytes = proto::encode(setups->of(0));
  const auto decoded = proto::decodeTileSetup(std::span<const std::byte>(bytes).subspan(proto::kHeaderBytes));
  ASSERT_TRUE(decoded.ok()) << decoded.error().text();
  EXPECT_EQ(decoded->blackRgb, (std::array<float, 3>{0.1F, 0, 0}));
}

TEST(TileSetups, nameTheWarpFileThatIsNotThere) {
  const Wall wall = wallFrom(R"({"grid": {"columns": 1, "rows": 1, "tile_px": [160, 90]},
      "tiles": {"r0c0": {"warp": {"mpcdi": "none.mpcdi", "region": "p1"}}}})");
  const auto setups = TileSetups::make(wall);
  ASSERT_FALSE(setups.ok());
  EXPECT_NE(setups.error().text().find("none.mpcdi"), std::string::npos) << setups.error().text();
  EXPECT_EQ(setups.error().exitStatus(), 2);
}

}  // namespace
}  // namespace tessera
