#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "common/wall/frustum_groups.h"
#include "common/wall/wall_file.h"
#include "common/wall/wall_picture.h"
#include "common/wall/wall_svg.h"
#include "common/wall/wall_writer.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

Wall wallFrom(const std::string& text) {
  const Result<Wall> wall = parseWall(text, "w.json");
  EXPECT_TRUE(wall.ok()) << wall.error().text();
  return wall.ok() ? *wall : gridWall(1, 1, 8, 8, 1);
}

Wall shipped(const std::string& name) {
  const Result<Wall> wall = readWallFile(fs::path(TESSERA_SOURCE_DIR) / "configs" / name);
  EXPECT_TRUE(wall.ok()) << wall.error().text();
  return *wall;
}

void expectError(const std::string& text, int line, const std::string& what, const std::string& mend) {
  const Result<Wall> wall = parseWall(text, "w.json");
  ASSERT_FALSE(wall.ok()) << text;
  EXPECT_EQ(wall.error().where, "w.json:" + std::to_string(line)) << wall.error().text();
  EXPECT_NE(wall.error().what.find(what), std::string::npos) << wall.error().text();
  EXPECT_NE(wall.error().mend.find(mend), std::string::npos) << wall.error().text();
  EXPECT_EQ(wall.error().exitStatus(), 2);
}

WallView viewFromOrigin(const Wall& wall) {
  return viewOf(wall, {.eye = {0, 0, 0}, .target = {0, 0, -1}}, Vec3::Zero(), 1);
}

/// Where the ray from the eye to a corner pierces z = -1.
Vec2 onPlane(const Frustum& frustum, std::size_t corner) {
  const Vec3 ray = frustum.corners[corner] - frustum.eye;
  return Vec2(ray.x(), ray.y()) / -ray.z();
}

TEST(WallShapes, bezelsHideWhatIsBehindThem) {
  // Two panels of 100 mm with 10 mm between them: 210 mm, the middle of the gap in the middle.
  const Wall wall =
      wallFrom(R"({"grid": {"columns": 2, "rows": 1, "tile_px": [100, 105], "tile_mm": [100, 105],
                                 "bezel_mm": {"left": 4, "right": 6}}, "camera": {"fov_y_deg": 90}})");
  ASSERT_TRUE(wall.warnings.empty());
  const WallView view = viewFromOrigin(wall);
  EXPECT_NEAR(onPlane(view.tiles[0], 0).x(), -2, 1e-14);
  EXPECT_NEAR(onPlane(view.tiles[0], 1).x(), -10 / 105.0, 1e-14);
  EXPECT_NEAR(onPlane(view.tiles[1], 0).x(), 10 / 105.0, 1e-14);
  EXPECT_NEAR(onPlane(view.tiles[1], 2).y(), 1, 1e-14);
  EXPECT_GT(wall.screens[0].latticeWidth, 1);
  // 10 mm are 10 pixels, so the tiles lie on one canvas.
  EXPECT_EQ(wall.tiles[1].xPx, 110);
  EXPECT_EQ(wall.tiles[1].canvasWidthPx, 210);
}

TEST(WallShapes, compressedBezelsLoseNothing) {
  const Wall wall =
      wallFrom(R"({"grid": {"columns": 2, "rows": 1, "tile_px": [100, 100], "tile_mm": [100, 100],
                                 "bezel_mm": 5, "bezel": "compress"}, "camera": {"fov_y_deg": 90}})");
  const WallView view = viewFromOrigin(wall);
  EXPECT_EQ(view.tiles[0].corners[1], view.tiles[1].corners[0]);
  EXPECT_NEAR(onPlane(view.tiles[0], 0).x(), -2, 1e-14);
  // But mounted they are apart.
  EXPECT_DOUBLE_EQ(wall.tiles[1].mountMm.x() - wall.tiles[0].mountMm.x(), 110);
  const WallPicture picture = wallPicture(wall);
  EXPECT_EQ(picture.widthPx, 210);
  EXPECT_EQ(picture.tiles[1].corner, Vec2(110, 0));
}

TEST(WallShapes, overlapsShareTheirPixels) {
  const Wall wall = shipped("wall-projectors-3x1.json");
  EXPECT_EQ(wall.tiles[0].canvasWidthPx, 3 * 480 - 2 * 96);
  EXPECT_EQ(wall.tiles[1].xPx, 480 - 96);
  EXPECT_EQ(wall.tiles[0].output.blendPx, (std::array<double, 4>{0, 96, 0, 0}));
  EXPECT_EQ(wall.tiles[1].output.blendPx, (std::array<double, 4>{96, 96, 0, 0}));
  const WallView view = viewFromOrigin(wall);
  EXPECT_GT(onPlane(view.tiles[0], 1).x(), onPlane(view.tiles[1], 0).x());
  EXPECT_GT(wallPicture(wall).gamma, 0);
}

TEST(WallShapes, turnedTilesDrawWithTheirOwnUp) {
  for (const int degrees : {0, 90, 180, 270}) {
    const Wall wall =
        wallFrom(R"({"grid": {"columns": 1, "rows": 1, "tile_px": [160, 90], "rotation_deg": )" +
                 std::to_string(degrees) + R"(}, "camera": {"fov_y_deg": 90}})");
    const WallView view = viewFromOrigin(wall);
    const Tile& tile = wall.tiles[0];
    const Frustum drawn = drawnFrustum(tile, view.tiles[0]);
    const ImageAxes axes = drawnAxes(tile, view.axes[0]);
    // Its pictures' rows run along its right axis, and are 160 pixels whichever way the panel hangs.
    const Vec3 across = drawn.corners[1] - drawn.corners[0], up = drawn.corners[3] - drawn.corners[0];
    EXPECT_NEAR(across.normalized().dot(axes.right), 1, 1e-14) << degrees;
    EXPECT_NEAR(up.normalized().dot(axes.up), 1, 1e-14) << degrees;
    EXPECT_NEAR(across.norm() / up.norm(), 160.0 / 90, 1e-12) << degrees;
    // Clockwise: at 90 degrees the picture's up points to the viewer's right.
    const double angle = degrees * std::numbers::pi / 180;
    EXPECT_NEAR(axes.up.x(), std::sin(angle), 1e-14) << degrees;
    EXPECT_NEAR(axes.up.y(), std::cos(angle), 1e-14) << degrees;
    EXPECT_EQ(wall.screens[0].widthMm, degrees % 180 == 0 ? 160 : 90);
  }
}

TEST(WallShapes, freelyTurnedTilesAreRectangles) {
  const Wall wall = wallFrom(R"({"screens": [{"size_mm": [1000, 500], "tiles": [
      {"name": "t", "px": [100, 50], "size_mm": [200, 100], "center_mm": [500, 250], "rotation_deg": 30}]}],
      "camera": {"fov_y_deg": 90}})");
  const WallView view = viewFromOrigin(wall);
  const Frustum drawn = drawnFrustum(wall.tiles[0], view.tiles[0]);
  const ImageAxes axes = drawnAxes(wall.tiles[0], view.axes[0]);
  const Vec3 across = drawn.corners[1] - drawn.corners[0], up = drawn.corners[3] - drawn.corners[0];
  EXPECT_NEAR(across.dot(up) / across.norm() / up.norm(), 0, 1e-14);
  EXPECT_NEAR(across.norm() / up.norm(), 2, 1e-12);
  EXPECT_NEAR(across.normalized().dot(axes.right), 1, 1e-14);
  EXPECT_NEAR(axes.up.x(), std::sin(std::numbers::pi / 6), 1e-14);
  EXPECT_NEAR((onPlane(drawn, 1) - onPlane(drawn, 0)).norm(), 0.8, 1e-12);  // 200 of 500 mm, of two
}

TEST(WallShapes, facesOfACaveMeetInTheirEdges) {
  const Wall wall = shipped("wall-cave-4.json");
  for (const Vec3& head : {Vec3(0, 1.7, 0.2), Vec3(0.9, 1.1, -0.8), Vec3(-1.2, 2.5, 1)}) {
    for (const Vec3& eye : {Vec3(0, 0, 0), Vec3(1e6, -3e5, 2e6)}) {
      CameraPose pose{.eye = eye, .target = eye + Vec3(0.3, -0.1, -1)};
      pose.hasHead = true;
      pose.headM = head;
      const WallView view = viewOf(wall, pose, eye, 50);
      const auto angle = [&](int a, std::size_t i, int b, std::size_t k) {
        const Vec3 p = (view.tiles[static_cast<std::size_t>(a)].corners[i] - view.tiles[0].eye).normalized();
        const Vec3 q = (view.tiles[static_cast<std::size_t>(b)].corners[k] - view.tiles[0].eye).normalized();
        return p.cross(q).norm();
      };
      // front 0, left 1, right 2, floor 3; a pixel is about 1e-3.
      EXPECT_LT(angle(0, 0, 1, 1), 1e-13);
      EXPECT_LT(angle(0, 3, 1, 2), 1e-13);
      EXPECT_LT(angle(0, 1, 2, 0), 1e-13);
      EXPECT_LT(angle(0, 2, 2, 3), 1e-13);
      EXPECT_LT(angle(0, 0, 3, 3), 1e-13);
      EXPECT_LT(angle(2, 1, 3, 1), 1e-13);
      EXPECT_LT(angle(1, 0, 3, 0), 1e-13);
    }
  }
}

/// Against the room's geometry, done with nothing but similar triangles.
TEST(WallShapes, anObserverSeesThroughScreensAsThroughWindows) {
  const Wall wall = wallFrom(R"({"screens": [{"name": "front",
      "corners_m": {"lower_left": [-2, 0, -3], "lower_right": [2, 0, -3], "upper_left": [-2, 2, -3]},
      "grid": {"columns": 2, "rows": 1, "tile_px": [100, 100]}}],
      "observer": {"eye_m": [0.5, 1.5, 1], "scale": 10}})");
  CameraPose pose{.eye = {100, 200, 300}, .target = {100, 200, 200}};
  const auto ray = [&](const WallView& view, std::size_t tile, std::size_t corner) {
    const Vec3 r = view.tiles[tile].corners[corner] - view.tiles[tile].eye;
    return Vec3(r / -r.z());
  };
  WallView view = viewOf(wall, pose, pose.eye, 10);
  EXPECT_EQ(view.tiles[0].eye, pose.eye);  // the camera is where the observer stands
  EXPECT_LT((ray(view, 0, 0) - Vec3(-2.5 / 4, -1.5 / 4, -1)).norm(), 1e-13);
  EXPECT_LT((ray(view, 1, 2) - Vec3(1.5 / 4, 0.5 / 4, -1)).norm(), 1e-13);
  pose.hasHead = true;
  pose.headM = Vec3(1.5, 1.5, 0);
  view = viewOf(wall, pose, pose.eye, 10);
  EXPECT_LT((view.tiles[0].eye - Vec3(110, 200, 290)).norm(), 1e-12);  // a metre is 10 of the scene
  EXPECT_LT((ray(view, 0, 0) - Vec3(-3.5 / 3, -1.5 / 3, -1)).norm(), 1e-13);
}

TEST(WallShapes, stereoEyesAreApartAndShareTheScreen) {
  const Wall wall = shipped("wall-stereo-2x1.json");
  const CameraPose pose{.eye = {5, 6, 7}, .target = {5, 6, 0}};
  const WallView view = viewOf(wall, pose, Vec3::Zero(), 20);
  ASSERT_EQ(view.left.size(), 2u);
  ASSERT_EQ(view.right.size(), 2u);
  EXPECT_LT((view.right[0].eye - view.left[0].eye - Vec3(0.065, 0, 0)).norm(), 1e-13);
  // Rays of both eyes through one corner meet on the screen, 1.8 m before the eyes.
  for (std::size_t t = 0; t < 2; ++t) {
    for (std::size_t i = 0; i < 4; ++i) {
      const auto onScreen = [&](const Frustum& f) {
        const Vec3 r = f.corners[i] - f.eye;
        return Vec3(f.eye + r * (1.8 / -r.z()));
      };
      EXPECT_LT((onScreen(view.left[t]) - onScreen(view.right[t])).norm(), 1e-12);
      EXPECT_LT((onScreen(view.left[t]) - onScreen(view.tiles[t])).norm(), 1e-12);
    }
  }
}

TEST(WallShapes, groupsAreGridsAndOneOfAllElse) {
  EXPECT_EQ(frustumGroups(shipped("wall-4x4.json"), Grouping::Hierarchies).size(), 1u);
  EXPECT_EQ(frustumGroups(shipped("wall-4x4.json"), Grouping::Hierarchies)[0].columns, 4);
  EXPECT_TRUE(frustumGroups(shipped("wall-4x4.json"), Grouping::Hierarchies)[0].touch);
  EXPECT_FALSE(frustumGroups(shipped("wall-bezels-4x3.json"), Grouping::Hierarchies)[0].touch);
  const auto cave = frustumGroups(shipped("wall-cave-4.json"), Grouping::Hierarchies);
  ASSERT_EQ(cave.size(), 1u);
  EXPECT_EQ(cave[0].columns, 0);
  EXPECT_EQ(cave[0].tiles.size(), 4u);
  EXPECT_EQ(frustumGroups(shipped("wall-portrait-4x1.json"), Grouping::Hierarchies)[0].columns,
            0);  // one is missing
  EXPECT_EQ(frustumGroups(shipped("wall-portrait-4x1.json"), Grouping::Grids).size(), 3u);
  EXPECT_EQ(frustumGroups(shipped("wall-curved-6x2.json"), Grouping::Grids).size(), 6u);
  EXPECT_EQ(frustumGroups(shipped("wall-bezels-4x3.json"), Grouping::Grids).size(), 1u);
}

TEST(WallShapes, theCaveUnfoldsIntoACross) {
  const WallPicture picture = wallPicture(shipped("wall-cave-4.json"));
  EXPECT_NEAR(picture.widthMm, 9000, 1e-6);
  EXPECT_NEAR(picture.heightMm, 6000, 1e-6);
  ASSERT_EQ(picture.tiles.size(), 4u);
  EXPECT_EQ(picture.widthPx, 1200);
  EXPECT_EQ(picture.tiles[0].corner, Vec2(400, 0));    // front
  EXPECT_EQ(picture.tiles[1].corner, Vec2(0, 0));      // left
  EXPECT_EQ(picture.tiles[2].corner, Vec2(800, 0));    // right
  EXPECT_EQ(picture.tiles[3].corner, Vec2(400, 400));  // floor
  for (const PicturePlace& place : picture.tiles) {
    EXPECT_EQ(place.across, Vec2(1, 0));
    EXPECT_EQ(place.down, Vec2(0, 1));
  }
}

TEST(WallShapes, turnedPanelsStandOnTheirSideInThePicture) {
  const WallPicture picture = wallPicture(shipped("wall-portrait-4x1.json"));
  const PicturePlace& first = picture.tiles[0];
  EXPECT_EQ(first.across, Vec2(0, 1));  // the picture's rows run down the wall
  EXPECT_EQ(first.down, Vec2(-1, 0));   // and its upper edge is at the right
  EXPECT_EQ(first.corner, Vec2(270, 0));
}

TEST(WallShapes, everyShippedWallIsDrawnAndReadsBackFromWhatItPrints) {
  for (const auto& entry : fs::directory_iterator(fs::path(TESSERA_SOURCE_DIR) / "configs")) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("wall-") || !name.ends_with(".json")) continue;
    SCOPED_TRACE(name);
    const Wall wall = shipped(name);
    const std::string svg = wallSvg(wall);
    for (const Tile& tile : wall.tiles)
      EXPECT_TRUE(wall.tiles.size() > 64 || svg.find(">" + tile.name + "<") != std::string::npos)
          << tile.name;
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
    const Result<Wall> again = parseWall(writeWall(wall), "printed");
    ASSERT_TRUE(again.ok()) << again.error().text();
    ASSERT_EQ(again->tiles.size(), wall.tiles.size());
    const CameraPose pose{.eye = {1, 2, 3}, .target = {0, 1, -5}};
    const WallView a = viewOf(wall, pose, Vec3::Zero(), 3), b = viewOf(*again, pose, Vec3::Zero(), 3);
    for (std::size_t t = 0; t < wall.tiles.size(); ++t) {
      EXPECT_EQ(again->tiles[t].name, wall.tiles[t].name);
      EXPECT_EQ(again->tiles[t].output.blendPx, wall.tiles[t].output.blendPx);
      for (std::size_t i = 0; i < 4; ++i) {
        const Vec3 p = (a.tiles[t].corners[i] - a.tiles[t].eye).normalized();
        const Vec3 q = (b.tiles[t].corners[i] - b.tiles[t].eye).normalized();
        EXPECT_LT(p.cross(q).norm(), 1e-11);
      }
    }
  }
}

TEST(WallShapes, newWallsAreWallFiles) {
  WallRequest request;
  request.columns = 4, request.rows = 3;
  request.tileMm = {1210, 680};
  request.bezelMm = 12;
  request.name = "a \"wall\"";
  const Wall wall = wallFrom(writeNewWall(request));
  EXPECT_EQ(wall.name, request.name);
  EXPECT_EQ(wall.tiles.size(), 12u);
  EXPECT_DOUBLE_EQ(wall.screens[0].widthMm, 4 * 1210 + 3 * 24);
  EXPECT_EQ(*parseLengthMm("12mm", "x", 1), 12);
  EXPECT_EQ(*parseLengthMm("0.5in", "x", 1), 12.7);
  EXPECT_EQ(*parseLengthMm("1.21", "x", 1000), 1210);
  for (const char* bad : {"", "mm", "12 parsec", "-1mm", "1e999", "nan", "0x10mm"})
    EXPECT_FALSE(parseLengthMm(bad, "x", 1).ok()) << bad;
  for (const char* bad : {"", "4", "x", "4x", "x3", "4x3x2", "-4x3", "0x3", "4 x 3"})
    EXPECT_FALSE(parsePair(bad, "x").ok()) << bad;
}

TEST(WallShapes, untiledWallsHaveATileToAScreen) {
  const Wall cave = shipped("wall-cave-4.json").untiled();
  ASSERT_EQ(cave.tiles.size(), 4u);
  EXPECT_EQ(cave.tiles[3].name, "floor");
  EXPECT_EQ(cave.tiles[3].widthPx, 400);
  // Hidden bezels are part of the whole picture.
  const Wall panels =
      wallFrom(R"({"grid": {"columns": 2, "rows": 1, "tile_px": [100, 50], "tile_mm": [100, 50],
                                   "bezel_mm": 5}})")
          .untiled();
  ASSERT_EQ(panels.tiles.size(), 1u);
  EXPECT_EQ(panels.tiles[0].widthPx, 210);
}

// --- what is wrong, where, and how to mend it

constexpr const char* kGrid = R"({"columns": 2, "rows": 1, "tile_px": [64, 48])";

TEST(WallErrors, namesWhatIsWrongOfGrids) {
  const auto grid = [](const std::string& more) {
    return std::string("{\"grid\":\n") + kGrid + ",\n" + more + "}}";
  };
  expectError(grid(R"("bezel_mm": -3)"), 3, "\"bezel_mm\" must be from 0", "");
  expectError(grid(R"("bezel_mm": {"left": 1, "middle": 2})"), 3, "unknown key \"middle\"", "did you mean");
  expectError(grid(R"("bezel": "hidden")"), 3, "cannot be \"hidden\"", "did you mean \"hide\"");
  expectError(grid(R"("overlap_px": 64)"), 3, "more than a tile has", "smaller");
  expectError(grid(R"("overlap_px": [3, 49])"), 3, "49 px down", "smaller");
  expectError(grid(R"("overlap_mm": 5)"), 3, "without the size of a tile", "tile_mm");
  expectError(grid(R"("overlap_px": 5, "overlap_mm": 5)"), 3, "twice", "keep one");
  expectError(grid(R"("overlap_px": 5, "bezel_mm": 5)"), 3, "bezels and overlap", "projectors");
  expectError(R"({"grid": {"columns": 3, "rows": 1, "tile_px": [64, 48], "overlap_px": 40}})", 1,
              "blend ramps", "");
  expectError(grid(R"("rotation_deg": 45)"), 3, "cannot be turned by 45", "one by one");
  expectError(grid(R"("missing": ["r0c2"])"), 3, "no tile \"r0c2\"", "r0c0 to r0c1");
  expectError(grid(R"("missing": ["r0c0", "r0c1"])"), 2, "no tile left", "at least one");
  expectError(grid(R"("tile": {"gama": 2})"), 3, "unknown key \"gama\"", "did you mean \"gamma\"");
  expectError(grid(R"("tile_mm": [0, 3])"), 3, "\"tile_mm\"", "");
  expectError("{\"grid\": {\"columns\": 1, \"rows\": 1,\n\"tile_px\": [0, 48]}}", 2, "whole number from 1",
              "");
}

TEST(WallErrors, namesWhatIsWrongOfScreens) {
  const auto screen = [](const std::string& corners, const std::string& rest) {
    return "{\"screens\": [{\"name\": \"a\",\n\"corners_m\": {" + corners + "},\n\"grid\": " + kGrid +
           "}}],\n" + rest + "}";
  };
  const std::string good = R"("lower_left": [0,0,0], "lower_right": [2,0,0], "upper_left": [0,1,0])";
  const std::string observer = R"("observer": {"eye_m": [1, 0.5, 1]})";
  EXPECT_TRUE(parseWall(screen(good, observer), "w.json").ok());
  expectError(screen(R"("lower_left": [0,0,0], "lower_right": [2,0,0], "upper_left": [4,0,0])", observer), 2,
              "on one line", "three corners");
  expectError(screen(R"("lower_left": [0,0,0], "lower_right": [0,0,0], "upper_left": [0,1,0])", observer), 2,
              "same point", "");
  expectError(screen(R"("lower_left": [0,0,0], "lower_right": [2,0,0], "upper_left": [0.3,1,0])", observer),
              2, "right angle", "measure again");
  expectError(screen(R"("lower_left": [0,0,0], "lower_right": [2,0,0], "upper_lift": [0,1,0])", observer), 2,
              "unknown key \"upper_lift\"", "upper_left");
  expectError(screen(good, R"("observer": {"eye_m": [5, 7, 0]})"), 4, "plane of screen \"a\"",
              "before every screen");
  expectError(screen(good, R"("observer": {"eye_m": [1, 0.5, -1]})"), 4, "or behind it", "");
  expectError(screen(good, R"("observer": {"eye_m": [1, 0.5, 1]}, "camera": {"fov_y_deg": 50})"), 4,
              "follows from where the eye", "remove");
  expectError(screen(good, R"("observer": {"eye_m": [1, 0.5, 1], "stereo": {"mode": "anaglyph"}})"), 4,
              "cannot be \"anaglyph\"", "one of");
  expectError(screen(good, R"("observer": {"eye_m": [1, 0.5, 1], "stereo": {"mode": "tiles"}})"), 3,
              "which eye", "left");
  const std::string two = "{\"screens\": [{\"name\": \"a\", \"corners_m\": {" + good +
                          "}, \"grid\": " + kGrid + "}},\n{\"name\": \"%\", \"corners_m\": {" + good +
                          "}, \"grid\": " + kGrid + "}}]%%}";
  const auto with = [&](std::string name, std::string rest) {
    std::string text = two;
    text.replace(text.find("%\""), 1, name);
    text.replace(text.find("%%"), 2, rest);
    return text;
  };
  expectError(with("b", ""), 1, "several screens", "observer");
  expectError(with("a", ", " + observer), 2, "two screens are named \"a\"", "rename");
  expectError(with("b", ", " + observer), 2, "two tiles are named \"r0c0\"", "rename");
}

TEST(WallErrors, namesWhatIsWrongOfTiles) {
  const auto tiles = [](const std::string& text, const std::string& size = R"("size_mm": [100, 100],)") {
    return "{\"screens\": [{" + size + " \"tiles\":\n[" + text + "]}]}";
  };
  const std::string one = R"({"name": "t", "px": [8, 8], "size_mm": [40, 40], )";
  EXPECT_TRUE(parseWall(tiles(one + R"("at_mm": [60, 60]})"), "w.json").ok());
  expectError(tiles(one + R"("at_mm": [61, 10]})"), 2, "outside its screen", "move it");
  expectError(tiles(one + R"("center_mm": [50, 15], "rotation_deg": 1})"), 2, "outside its screen", "");
  expectError(tiles(one + R"("at_mm": [1, 1], "center_mm": [50, 50]})"), 2, "said once", "remove");
  expectError(tiles(one + R"("rotation_deg": 3})"), 2, "said once", "add");
  expectError(tiles(one + R"("at_mm": [1, 1], "rotation_deg": 3})"), 2, "no upper left corner", "center_mm");
  expectError(tiles(one + R"("at_mm": [1, 1]}, )" + one + R"("at_mm": [50, 1]})"), 2, "two tiles are named",
              "rename");
  expectError(tiles(one + R"("at_mm": [1, 1], "eye": "left"})"), 2, "not in stereo", "remove");
  expectError(tiles(one + R"("at_mm": [1, 1], "monitor": "A", "window_px": [1, 1]})"), 2, "full screen",
              "keep one");
  expectError(tiles("", ""), 2, "without tiles", "");
  expectError("{\"grid\": " + std::string(kGrid) + "},\n\"tiles\": {\"r0c7\": {}}}", 2, "no tile \"r0c7\"",
              "did you mean \"r0c0\"");
}

}  // namespace
}  // namespace tessera
