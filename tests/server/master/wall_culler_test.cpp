#include "server/master/wall_culler.h"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "common/cull/footprint/kernels.h"
#include "common/wall/wall_file.h"
#include "tests/support/cull_scene.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> shippedWalls() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(fs::path(TESSERA_SOURCE_DIR) / "configs")) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("wall-") && name.ends_with(".json")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// What each tile must show: in stereo what either eye sees, or its own.
std::vector<std::vector<bool>> mustSee(const WallView& view, std::span<const Triangle> leaves) {
  if (view.left.empty()) return exactVisibility(view.tiles, leaves);
  auto meets = exactVisibility(view.left, leaves);
  const auto right = exactVisibility(view.right, leaves);
  for (std::size_t t = 0; t < meets.size(); ++t) {
    for (std::size_t leaf = 0; leaf < meets[t].size(); ++leaf)
      meets[t][leaf] = meets[t][leaf] || right[t][leaf];
  }
  return meets;
}

/// Random triangles, many of them on the edges of the tiles' frusta.
TriangleScene sceneFor(const WallView& view, Geometry& geometry, double size, int leaves) {
  TriangleScene scene;
  for (int i = 0; i < leaves; ++i)
    scene.leaves.push_back(geometry.any(Vec3::Zero(), size));
  for (int i = 0; i < leaves; ++i)
    scene.leaves.push_back(geometry.hard(view.left.empty() ? view.tiles
                                         : i % 2 != 0      ? view.left
                                                           : view.right));
  for (int i = 0; i < leaves / 4; ++i)
    scene.leaves.push_back(geometry.aboutTheEye(view.tiles[0].eye, size));
  scene.build(geometry.engine());
  return scene;
}

CameraPose randomPose(Geometry& geometry, double size) {
  CameraPose pose;
  pose.eye = geometry.vector(size);
  pose.target = pose.eye + geometry.vector(size);
  pose.up = Vec3(0, 1, 0) + geometry.vector(0.3);
  return pose;
}

/// Every algorithm that walls may meet; the contract of single hierarchies has all switches.
std::vector<cull::Options> someOptions() {
  std::vector<cull::Options> all;
  for (const cull::Algorithm algorithm :
       {cull::Algorithm::Naive, cull::Algorithm::Oh, cull::Algorithm::Fh, cull::Algorithm::Adaptive,
        cull::Algorithm::AdaptiveListing, cull::Algorithm::Auto, cull::Algorithm::Table}) {
    for (const cull::BoundsKind bounds : {cull::BoundsKind::Obb, cull::BoundsKind::Sphere})
      if (const cull::Options options = {.algorithm = algorithm, .bounds = bounds}; check(options))
        all.push_back(options);
  }
  return all;
}

void expectContract(const Wall& wall, Geometry& geometry, int rounds, int leaves) {
  constexpr double kSize = 5;
  for (int round = 0; round < rounds; ++round) {
    CameraPose pose = randomPose(geometry, kSize);
    if (wall.observer && round % 2 != 0) {  // tracked
      pose.hasHead = true;
      pose.headM = wall.observer->eyeM + geometry.vector(0.1);
      if (screenNotBefore(wall, pose.headM)) pose.hasHead = false;
    }
    const WallView view = viewOf(wall, pose, Vec3::Zero(), 2 * kSize);
    const TriangleScene scene = sceneFor(view, geometry, kSize, leaves);
    const auto meets = mustSee(view, scene.leaves);
    for (const cull::Options& options : someOptions()) {
      WallCuller culler(scene.hierarchy, wall, options);
      culler.update(view);
      const std::string drop = firstDrop(culler.cull(), meets);
      ASSERT_EQ(drop, "") << wall.source << ", " << cull::nameOf(options.algorithm) << ", round " << round;
      // As changes from nothing, and once more as changes from itself.
      WallCuller byChanges(scene.hierarchy, wall, options);
      byChanges.update(view);
      const cull::Changes& changes = byChanges.cullChanges();
      VisibleList list;
      for (std::uint32_t tile = 0; tile < wall.tiles.size(); ++tile) {
        ASSERT_EQ(changes.leafCounts[tile], leafCount(changes.toggled[tile]));
        byChanges.listOf(tile, list);
        ASSERT_EQ(list, changes.toggled[tile]);
      }
      for (const VisibleList& toggled : byChanges.cullChanges().toggled)
        ASSERT_TRUE(toggled.empty());
    }
  }
}

TEST(WallCuller, everyShippedWallKeepsTheContract) {
  Geometry geometry(5);
  const std::vector<fs::path> files = shippedWalls();
  ASSERT_GE(files.size(), 14u);
  for (const fs::path& file : files) {
    const Result<Wall> wall = readWallFile(file);
    ASSERT_TRUE(wall.ok()) << wall.error().text();
    expectContract(*wall, geometry, wall->tiles.size() > 64 ? 1 : 4, wall->tiles.size() > 64 ? 20 : 40);
  }
}

/// A wall of random shape as its file.
std::string randomWall(Geometry& geometry) {
  const auto number = [](double x) { return std::to_string(x); };
  const auto grid = [&](bool fits) {
    const int columns = 1 + static_cast<int>(geometry.below(5)),
              rows = 1 + static_cast<int>(geometry.below(4));
    std::string text = "{\"columns\": " + std::to_string(columns) + ", \"rows\": " + std::to_string(rows) +
                       ", \"tile_px\": [64, 48]";
    switch (geometry.below(4)) {
      case 0:
        text += R"(, "bezel_mm": {"left": 1, "right": 2.5, "top": 0.5, "bottom": 3})";
        break;
      case 1:
        text += R"(, "overlap_px": [11, 7])";
        break;
      case 2:
        text += R"(, "bezel_mm": 9, "bezel": "compress")";
        break;
      default:
        break;
    }
    if (!fits && geometry.below(2) == 0) text += R"(, "rotation_deg": 90)";
    if (columns * rows > 2 && geometry.below(3) == 0) text += R"(, "missing": ["r0c0"])";
    return text + "}";
  };
  const auto freeTiles = [&] {
    std::string text = "[";
    const int count = 1 + static_cast<int>(geometry.below(6));
    for (int i = 0; i < count; ++i) {
      text += std::string(i > 0 ? "," : "") + "{\"name\": \"t" + std::to_string(i) +
              "\", \"px\": [64, 48], \"size_mm\": [" + number(200 + 300 * geometry.unit01()) + ", " +
              number(150 + 200 * geometry.unit01()) + "], \"center_mm\": [" +
              number(2000 * geometry.unit01()) + ", " + number(1000 * geometry.unit01()) +
              "], \"rotation_deg\": " + (i % 2 != 0 ? number(360 * geometry.unit01()) : std::string("180")) +
              "}";
    }
    return text + "]";
  };
  const std::string stereo[] = {"", R"(, "stereo": {"mode": "side-by-side", "separation_mm": 70})",
                                R"(, "stereo": {"mode": "quad-buffer", "separation_mm": 300})"};
  switch (geometry.below(4)) {
    case 0:
      return "{\"grid\": " + grid(false) +
             ", \"camera\": {\"fov_y_deg\": " + number(10 + 130 * geometry.unit01()) + "}}";
    case 1:
      return "{\"screens\": [{\"tiles\": " + freeTiles() + "}]}";
    case 2:
      return "{\"screens\": [{\"tiles\": " + freeTiles() + "}], \"observer\": {\"eye_m\": [0.1, 0.2, 1.5]" +
             stereo[geometry.below(3)] + "}}";
    default:
      break;
  }
  // Screens all about an eye at the origin, some grids, some single tiles.
  std::string screens;
  const int count = 2 + static_cast<int>(geometry.below(5));
  for (int s = 0; s < count; ++s) {
    const Mat3 turn = Eigen::Quaterniond::UnitRandom().toRotationMatrix();
    const double width = 1 + geometry.unit01(), height = 1 + geometry.unit01(),
                 distance = 0.5 + geometry.unit01();
    const auto corner = [&](double x, double y) {
      const Vec3 p = turn * Vec3(x * width, y * height, -distance);
      return "[" + number(p.x()) + ", " + number(p.y()) + ", " + number(p.z()) + "]";
    };
    const std::string prefix = "s" + std::to_string(s);
    std::string tiles = "\"grid\": {\"columns\": 2, \"rows\": 3, \"tile_px\": [64, 48], \"names\": [";
    for (int r = 0; r < 3; ++r)
      tiles += std::string(r > 0 ? "," : "") + "[\"" + prefix + "a" + std::to_string(r) + "\", \"" + prefix +
               "b" + std::to_string(r) + "\"]";
    tiles += "]}";
    if (geometry.below(2) == 0)
      tiles =
          "\"grid\": {\"columns\": 1, \"rows\": 1, \"tile_px\": [64, 48], \"names\": [[\"" + prefix + "\"]]}";
    screens += std::string(s > 0 ? "," : "") + "{\"name\": \"" + prefix +
               "\", \"corners_m\": {\"lower_left\": " + corner(-1, -1) +
               ", \"lower_right\": " + corner(1, -1) + ", \"upper_left\": " + corner(-1, 1) + "}, " + tiles +
               "}";
  }
  return "{\"screens\": [" + screens + "], \"observer\": {\"eye_m\": [0, 0, 0]" + stereo[geometry.below(3)] +
         "}}";
}

TEST(WallCuller, randomWallsKeepTheContract) {
  Geometry geometry(77);
  std::srand(3);  // of Eigen's random turns
  int grids = 0, severalGroups = 0;
  for (int i = 0; i < 60; ++i) {
    const std::string text = randomWall(geometry);
    const Result<Wall> wall = parseWall(text, "random wall " + std::to_string(i));
    ASSERT_TRUE(wall.ok()) << wall.error().text() << "\n" << text;
    const auto groups = frustumGroups(*wall, Grouping::Hierarchies);
    grids += groups[0].columns > 0 ? 1 : 0;
    severalGroups += groups.size() > 1 ? 1 : 0;
    expectContract(*wall, geometry, 2, 24);
  }
  EXPECT_GT(grids, 5);
  EXPECT_GT(severalGroups, 5);
}

/// Invariants of every shipped wall in exact arithmetic: what a tile sees its screen sees, and where the
/// tiles cover their screen one of them sees what the screen does.
TEST(WallCuller, tilesTogetherSeeWhatTheirScreensSee) {
  Geometry geometry(15);
  int covered = 0;
  for (const fs::path& file : shippedWalls()) {
    const Result<Wall> wall = readWallFile(file);
    ASSERT_TRUE(wall.ok());
    if (wall->tiles.size() > 64) continue;
    CameraPose pose = randomPose(geometry, 3);
    const WallView view = viewOf(*wall, pose, Vec3::Zero(), 6);
    // None on the very edge of the screen, where a tile's corner in between may be rounded inwards by an ulp.
    TriangleScene scene;
    for (int leaf = 0; leaf < 400; ++leaf)
      scene.leaves.push_back(geometry.any(Vec3::Zero(), 3));
    scene.build(geometry.engine());
    const auto byTile = exactVisibility(view.tiles, scene.leaves);
    const auto byScreen = exactVisibility(view.screens, scene.leaves);
    const Wall untiled = wall->untiled();
    WallCuller whole(scene.hierarchy, untiled, {.algorithm = cull::Algorithm::Auto});
    whole.update(viewOf(untiled, pose, Vec3::Zero(), 6));
    const std::vector<VisibleList> listed = whole.cull().lists;
    for (std::uint32_t s = 0; s < wall->screens.size(); ++s) {
      const Screen& screen = wall->screens[s];
      const bool covers = screen.columns > 0 && screen.latticeWidth <= 1 && screen.latticeHeight <= 1 &&
                          std::abs(wall->tiles[screen.firstTile].corners[0].x() + 1) < 1e-12;
      covered += covers ? 1 : 0;
      for (std::size_t leaf = 0; leaf < scene.leaves.size(); ++leaf) {
        bool some = false;
        for (std::uint32_t t = screen.firstTile; t < screen.firstTile + screen.tileCount; ++t)
          some = some || byTile[t][leaf];
        const auto id = static_cast<std::uint32_t>(leaf);
        // Tiles of rounded corners may see an ulp beyond their screen, but no more than the untiled list has.
        if (some && view.left.empty()) {
          ASSERT_TRUE(containsLeaf(listed[s], id)) << file << " leaf " << leaf;
        }
        if (covers && byScreen[s][leaf]) {
          ASSERT_TRUE(some) << file << " screen " << screen.name << " leaf " << leaf;
        }
      }
    }
  }
  EXPECT_GT(covered, 10);
}

TEST(WallCuller, gridsWithGapsAndOverlapsAreCulledByFootprints) {
  for (const char* gap : {R"("bezel_mm": 3)", R"("overlap_px": 9)", R"("bezel_mm": {"left": 1, "top": 6})"}) {
    const Result<Wall> wall = parseWall(
        std::string(R"({"grid": {"columns": 5, "rows": 4, "tile_px": [64, 48], )") + gap + "}}", gap);
    ASSERT_TRUE(wall.ok()) << wall.error().text();
    Geometry geometry(9);
    const WallView view = viewOf(*wall, randomPose(geometry, 3), Vec3::Zero(), 6);
    const TriangleScene scene = sceneFor(view, geometry, 3, 200);
    WallCuller culler(scene.hierarchy, *wall, {.algorithm = cull::Algorithm::Auto});
    culler.update(view);
    const cull::Result& result = culler.cull();
    EXPECT_EQ(culler.picked(), cull::Algorithm::Footprint) << gap;
    EXPECT_EQ(firstDrop(result, exactVisibility(view.tiles, scene.leaves)), "") << gap;
  }
}

/// One list, whether by the tree, by the table with what it remembers, or by any instruction set.
TEST(WallCuller, gapsAndOverlapsAreTheSameForTreeTableAndInstructionSets) {
  for (const char* gap : {R"("bezel_mm": [3, 5])", R"("overlap_px": [12, 7])"}) {
    const Result<Wall> wall = parseWall(
        std::string(R"({"grid": {"columns": 6, "rows": 5, "tile_px": [64, 48], )") + gap + "}}", gap);
    ASSERT_TRUE(wall.ok()) << wall.error().text();
    Geometry geometry(21);
    CameraPose pose = randomPose(geometry, 3);
    const TriangleScene scene = sceneFor(viewOf(*wall, pose, Vec3::Zero(), 6), geometry, 3, 400);
    using cull::Algorithm, cull::Reuse;
    WallCuller remembering(scene.hierarchy, *wall,
                           {.algorithm = Algorithm::Table, .switches = {.coherent = Reuse::Always}});
    for (int frame = 0; frame < 12; ++frame) {
      pose.eye += geometry.vector(0.002);
      pose.target += geometry.vector(0.002);
      const WallView view = viewOf(*wall, pose, Vec3::Zero(), 6);
      const auto meets = exactVisibility(view.tiles, scene.leaves);
      remembering.update(view);
      const std::vector<VisibleList> expected = remembering.cull().lists;
      EXPECT_EQ(remembering.picked(), Algorithm::Table);
      for (const std::string_view name : cull::instructionSets()) {
        ASSERT_TRUE(cull::chooseInstructionSet(name));
        WallCuller tree(scene.hierarchy, *wall, {.algorithm = Algorithm::Footprint});
        tree.update(view);
        const cull::Result& result = tree.cull();
        ASSERT_EQ(firstDrop(result, meets), "") << gap << ' ' << name;
        ASSERT_EQ(result.lists, expected) << gap << ' ' << name << " frame " << frame;
      }
      ASSERT_TRUE(cull::chooseInstructionSet(""));
    }
  }
}

/// Scenes from micrometres to gigametres, far from the origin, heads next to a screen: nothing is dropped.
TEST(WallCuller, extremesKeepTheContract) {
  Geometry geometry(33);
  for (const char* name : {"wall-cave-4.json", "wall-curved-6x2.json", "wall-stereo-2x1.json"}) {
    Result<Wall> wall = readWallFile(fs::path(TESSERA_SOURCE_DIR) / "configs" / name);
    ASSERT_TRUE(wall.ok());
    for (const double scale : {1e-6, 1.0, 1e6}) {
      wall->observer->scale = scale;
      for (const double offset : {0.0, 1e7 * scale}) {
        for (const bool isAtAScreen : {false, true}) {
          CameraPose pose;
          pose.eye = offset * Vec3(1, -0.3, 0.7);
          pose.target = pose.eye + std::max(scale, 1e-3 * offset) * Vec3(0.3, -0.1, -1);
          pose.hasHead = isAtAScreen;
          const Screen& screen = wall->screens.front();
          pose.headM = screen.centerM + 0.05 * screen.normal();
          if (screenNotBefore(*wall, pose.headM)) continue;
          const WallView view = viewOf(*wall, pose, pose.eye, 100 * scale);
          TriangleScene scene;
          for (int i = 0; i < 60; ++i) {
            scene.leaves.push_back(geometry.hard(view.left.empty() ? view.tiles
                                                 : i % 2 != 0      ? view.left
                                                                   : view.right));
            scene.leaves.push_back(geometry.any(pose.eye, 50 * scale));
          }
          scene.build(geometry.engine());
          const auto meets = mustSee(view, scene.leaves);
          for (const cull::Options& options : someOptions()) {
            WallCuller culler(scene.hierarchy, *wall, options);
            culler.update(view);
            ASSERT_EQ(firstDrop(culler.cull(), meets), "") << name << ' ' << cull::nameOf(options.algorithm)
                                                           << " scale " << scale << " offset " << offset;
          }
        }
      }
    }
  }
}

/// In grids with bezels what lies in the gaps alone is shown by nobody, whichever culler.
TEST(WallCuller, gapsAreNotListed) {
  const Result<Wall> wall =
      parseWall(R"({"grid": {"columns": 4, "rows": 3, "tile_px": [64, 48], "bezel_mm": 4}})", "gaps");
  ASSERT_TRUE(wall.ok());
  const WallView view = viewOf(*wall, {}, Vec3::Zero(), 10);
  TriangleScene scene;
  // Between the second and third column, and as large in the middle of a tile.
  const auto at = [&](double x, double y) {
    const Frustum& s = view.screens[0];
    return Vec3(s.eye + 0.5 * (s.corners[3] + x * (s.corners[2] - s.corners[3]) +
                               y * (s.corners[0] - s.corners[3]) - s.eye));
  };
  for (const double x : {0.5, 0.36}) {
    const Vec3 p = at(x, 0.5);
    scene.leaves.push_back({p, Vec3(p + Vec3(1e-3, 0, 0)), Vec3(p + Vec3(0, 1e-3, 0))});
  }
  Geometry geometry(1);
  scene.build(geometry.engine());
  const auto meets = exactVisibility(view.tiles, scene.leaves);
  for (const cull::Options& options : someOptions()) {
    if (options.bounds == cull::BoundsKind::Sphere) continue;
    WallCuller culler(scene.hierarchy, *wall, options);
    culler.update(view);
    EXPECT_EQ(culler.cull().pairs, 1u) << cull::nameOf(options.algorithm);
    EXPECT_EQ(firstDrop(culler.cull(), meets), "");
  }
}

/// One traversal for both eyes lists little more than two eyes see.
TEST(WallCuller, aStereoPairTogetherListsWhatTwoEyesSee) {
  const Result<Wall> wall =
      parseWall(R"({"grid": {"columns": 4, "rows": 2, "tile_px": [64, 48], "tile_mm": [600, 450]},
                    "observer": {"eye_m": [0, 0, 2], "stereo": {"mode": "side-by-side"}}})",
                "stereo");
  ASSERT_TRUE(wall.ok()) << wall.error().text();
  Geometry geometry(4);
  std::uint64_t together = 0, apart = 0, byFootprints = 0;
  for (int round = 0; round < 10; ++round) {
    CameraPose pose;
    pose.eye = geometry.vector(2);
    const WallView view = viewOf(*wall, pose, Vec3::Zero(), 60);
    TriangleScene scene;
    for (int i = 0; i < 3000; ++i)
      scene.leaves.push_back(geometry.any(Vec3(0, 0, -20), 20));
    scene.build(geometry.engine());
    WallCuller culler(scene.hierarchy, *wall, {.algorithm = cull::Algorithm::Adaptive});
    culler.update(view);
    together += culler.cull().pairs;
    WallCuller footprints(scene.hierarchy, *wall, {.algorithm = cull::Algorithm::Auto});
    footprints.update(view);
    byFootprints += footprints.cull().pairs;
    EXPECT_EQ(footprints.picked(), cull::Algorithm::Footprint);
    const auto listsOf = [&](const std::vector<Frustum>& tiles) {
      GeneralFrusta frusta;
      frusta.update(tiles);
      cull::Culler one(scene.hierarchy, {.algorithm = cull::Algorithm::Adaptive});
      return one.cull(frusta).lists;
    };
    const auto left = listsOf(view.left), right = listsOf(view.right);
    for (std::size_t t = 0; t < left.size(); ++t) {
      VisibleList differing;
      symmetricDifferenceInto(left[t], right[t], differing);
      apart += (leafCount(left[t]) + leafCount(right[t]) + leafCount(differing)) / 2;
    }
  }
  EXPECT_GE(together, apart);
  // Outlines spare it a few more.
  EXPECT_LE(byFootprints, apart + apart / 100);
  EXPECT_GE(byFootprints, apart - apart / 10);
  // The planes are widened by a degree or so at each side of a tile of 17.
  EXPECT_LT(static_cast<double>(together), 1.35 * static_cast<double>(apart))
      << static_cast<double>(together) / static_cast<double>(apart);
}

TEST(WallCuller, tilesForTwoEyesShareOneFrustum) {
  const Result<Wall> wall = parseWall(R"({"screens": [{"tiles": [
      {"name": "l", "px": [64, 48], "size_mm": [1000, 750], "at_mm": [0, 0], "eye": "left"},
      {"name": "r", "px": [64, 48], "size_mm": [1000, 750], "at_mm": [0, 0], "eye": "right"}]}],
      "observer": {"eye_m": [0, 0, 1], "stereo": {"mode": "tiles"}}})",
                                      "pair");
  ASSERT_TRUE(wall.ok()) << wall.error().text();
  const auto groups = frustumGroups(*wall, Grouping::Hierarchies);
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0].tiles.size(), 1u);
  ASSERT_EQ(groups[0].twins[0].size(), 1u);
  const WallView view = viewOf(*wall, {.eye = {1, 2, 3}, .target = {1, 2, 0}}, Vec3::Zero(), 5);
  EXPECT_EQ(view.left[0].eye, view.right[0].eye);
  EXPECT_NE(view.left[0].eye, view.left[1].eye);
  Geometry geometry(2);
  expectContract(*wall, geometry, 4, 40);
}

}  // namespace
}  // namespace tessera::test
