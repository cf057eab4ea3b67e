#include "common/wall/import/mpcdi_wall.h"

#include <cmath>

#include "tests/common/wall/import/imported.h"
#include "tests/support/mpcdi_archive.h"
#include "tests/support/process.h"

namespace tessera {
namespace {

using test::contains;
using test::expectPair;
using test::expectPoint;
using test::Sample;
using Json = nlohmann::json;

MpcdiRegion region(const std::string& buffer, const std::string& id) {
  MpcdiRegion region;
  region.buffer = buffer;
  region.id = id;
  region.widthPx = 100;
  region.heightPx = 50;
  return region;
}

Json wallOf(const Mpcdi& mpcdi) {
  const Result<ImportedWall> wall = wallOfMpcdi(mpcdi, "dir/a.mpcdi");
  if (!wall) {
    ADD_FAILURE() << wall.error().text();
    return nullptr;
  }
  return Json::parse(wall->json, nullptr, true, true);
}

std::string errorOf(const Mpcdi& mpcdi) {
  const Result<ImportedWall> wall = wallOfMpcdi(mpcdi, "a.mpcdi");
  return wall ? "no error" : wall.error().text();
}

TEST(ImportMpcdi, archivesAreRecognisedByTheirContent) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "two.walls";
  const auto warp = [](int c, int r) { return Sample{float(c), float(r), 0}; };
  const auto grey = [](int, int, int) { return std::uint16_t{1}; };
  test::writeArchive(path, {{"mpcdi.xml", test::twoRegions2d()},
                            {"left.pfm", test::pfm(2, 2, warp)},
                            {"right.pfm", test::pfm(2, 2, warp)},
                            {"maps/left.png", test::png(2, 2, 1, 8, false, grey)},
                            {"right.png", test::png(2, 2, 1, 8, false, grey)},
                            {"beta.png", test::png(2, 2, 1, 8, false, grey)}});
  const Result<ImportedWall> imported = importWall(path);
  ASSERT_TRUE(imported.ok()) << imported.error().text();
  const Json wall = Json::parse(imported->json, nullptr, true, true);
  ASSERT_EQ(wall["screens"].size(), 1u);
  const Json& screen = wall["screens"][0];
  EXPECT_EQ(screen["name"], "front");
  EXPECT_FALSE(screen.contains("corners_m"));
  EXPECT_FALSE(wall.contains("observer"));
  ASSERT_EQ(screen["tiles"].size(), 2u);
  expectPair(screen["tiles"][0]["at_mm"], 0, 0);
  expectPair(screen["tiles"][0]["size_mm"], 180, 100);
  EXPECT_EQ(screen["tiles"][0]["warp"], Json({{"mpcdi", "two.walls"}, {"region", "left"}}));
  // 0.25 of the buffer from the bottom and half as high: 0.25 from the top as well.
  expectPair(screen["tiles"][1]["at_mm"], 120, 25);
  expectPair(screen["tiles"][1]["size_mm"], 180, 50);
  EXPECT_EQ(screen["tiles"][1]["px"], Json({180, 50}));
  ASSERT_FALSE(imported->warnings.empty());
  EXPECT_TRUE(contains(imported->warnings.back(), "keep two.walls beside the wall file"));
}

TEST(ImportMpcdi, severalBuffersStandSideBySide) {
  Mpcdi mpcdi;
  mpcdi.buffers = {{"a", 200, 100}, {"b", 0, 0}};
  mpcdi.regions = {region("a", "r1"), region("b", "r2")};
  mpcdi.regions[0].width = 0.5;
  mpcdi.regions[0].y = 0.25;
  mpcdi.regions[0].height = 0.5;
  const Json wall = wallOf(mpcdi);
  ASSERT_EQ(wall["screens"].size(), 2u);
  expectPoint(wall["screens"][0]["corners_m"]["lower_right"], 0.2, 0, 0);
  expectPair(wall["screens"][0]["tiles"][0]["at_mm"], 0, 25);
  expectPoint(wall["screens"][1]["corners_m"]["lower_left"], 0.3, 0, 0);
  expectPoint(wall["screens"][1]["corners_m"]["lower_right"], 0.4, 0, 0);
  expectPoint(wall["observer"]["eye_m"], 0.2, 0.05, 0.4);
}

TEST(ImportMpcdi, frustaBecomeCorners) {
  Mpcdi mpcdi;
  mpcdi.profile = MpcdiProfile::Simulation;
  mpcdi.buffers = {{"b", 0, 0}};
  mpcdi.regions = {region("b", "ahead"), region("b", "right"), region("b", "up"), region("b", "rolled")};
  const double tan30 = std::tan(30 * M_PI / 180), tan10 = std::tan(10 * M_PI / 180);
  mpcdi.regions[0].frustum = MpcdiFrustum{0, 0, 0, -45, 30, -10, 45};
  mpcdi.regions[1].frustum = MpcdiFrustum{90, 0, 0, -45, 45, -45, 45};
  mpcdi.regions[2].frustum = MpcdiFrustum{0, 90, 0, -45, 45, -45, 45};
  mpcdi.regions[3].frustum = MpcdiFrustum{0, 0, 90, -45, 45, -45, 45};
  const Json wall = wallOf(mpcdi);
  ASSERT_EQ(wall["screens"].size(), 4u);
  const auto corners = [&](std::size_t i) { return wall["screens"][i]["corners_m"]; };
  expectPoint(corners(0)["lower_left"], -1, -tan10, -1);
  expectPoint(corners(0)["lower_right"], tan30, -tan10, -1);
  expectPoint(corners(0)["upper_left"], -1, 1, -1);
  expectPair(wall["screens"][0]["tiles"][0]["size_mm"], (1 + tan30) * 1000, (1 + tan10) * 1000);
  // Turned to the right the picture stands at x = 1, its left edge towards -z.
  expectPoint(corners(1)["lower_left"], 1, -1, -1);
  expectPoint(corners(1)["lower_right"], 1, -1, 1);
  // Up: at y = 1, its lower edge before the viewer.
  expectPoint(corners(2)["lower_left"], -1, 1, -1);
  expectPoint(corners(2)["upper_left"], -1, 1, 1);
  // Rolled clockwise: what was the lower left corner is the upper left one.
  expectPoint(corners(3)["lower_left"], -1, 1, -1);
  expectPoint(corners(3)["upper_left"], 1, 1, -1);
  expectPoint(wall["observer"]["eye_m"], 0, 0, 0);
}

TEST(ImportMpcdi, pointsInSpaceGetAPictureAroundThem) {
  Mpcdi mpcdi;
  mpcdi.profile = MpcdiProfile::ShaderLamps;
  mpcdi.buffers = {{"b", 0, 0}};
  mpcdi.regions = {region("b", "r")};
  EXPECT_TRUE(contains(errorOf(mpcdi), "region r has no map of the points"));
  MpcdiWarp warp;
  warp.columns = warp.rows = 2;
  warp.isInSpace = true;
  warp.xyz = {-1, 1, -2, 1, 1, -2, -1, -1, -2, 1, -1, -2};
  warp.origin = MpcdiWarp::Origin::IdealEyePoint;
  mpcdi.regions[0].warp = warp;
  const Json wall = wallOf(mpcdi);
  expectPoint(wall["observer"]["eye_m"], 0, 0, 0);
  expectPoint(wall["screens"][0]["corners_m"]["lower_left"], -1, -1, -2);
  expectPoint(wall["screens"][0]["corners_m"]["lower_right"], 1, -1, -2);
  expectPoint(wall["screens"][0]["corners_m"]["upper_left"], -1, 1, -2);
  EXPECT_EQ(wall["screens"][0]["tiles"][0]["warp"]["region"], "r");
  mpcdi.regions[0].warp->origin = MpcdiWarp::Origin::FloorCenter;
  EXPECT_NEAR(wallOf(mpcdi)["observer"]["eye_m"][1], 1.6, 1e-9);
  mpcdi.regions[0].warp->origin = MpcdiWarp::Origin::CenterOfMass;
  EXPECT_TRUE(contains(errorOf(mpcdi), "not where the eye is"));
  mpcdi.regions[0].warp->origin = MpcdiWarp::Origin::IdealEyePoint;
  mpcdi.regions[0].warp->xyz[2] = 5;
  EXPECT_TRUE(contains(errorOf(mpcdi), "no flat picture holds them"));
}

}  // namespace
}  // namespace tessera
