#include "common/wall/import/mpcdi_wall.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include <Eigen/Geometry>

#include "common/wall/import/formats.h"
#include "common/wall/import/wall_text.h"
#include "common/wall/import/warning_list.h"
#include "common/wall/mpcdi/warp_mesh.h"

namespace tessera {

namespace {

constexpr double kScreenDistanceM = 1;
constexpr double kGapBetweenBuffersM = 0.1;
constexpr double kEyeHeightM = 1.6;

class Importer {
 public:
  Importer(const Mpcdi& mpcdi, const std::string& fileName) : mpcdi_(mpcdi), fileName_(fileName) {}

  Result<ImportedWall> run() {
    if (mpcdi_.profile == MpcdiProfile::Media2d) {
      buffers();
    } else if (mpcdi_.profile == MpcdiProfile::Simulation) {
      frusta();
    } else {
      points();
    }
    if (error_) return *error_;
    warnings_.add("warps and masks", 0,
                  "stay in the archive; keep " + archiveName() + " beside the wall file");
    wall_.name = wallNameOf(fileName_);
    wall_.origin = "From the MPCDI archive " + archiveName();
    Result<std::string> json = wallText(wall_, fileName_);
    if (!json) return json.error();
    std::vector<std::string> warnings = mpcdi_.warnings;
    for (std::string& warning : warnings_.texts(fileName_))
      warnings.push_back(std::move(warning));
    return ImportedWall{std::move(*json), std::move(warnings)};
  }

 private:
  [[nodiscard]] std::string archiveName() const {
    return std::filesystem::path(fileName_).filename().string();
  }

  walltext::Tile tile(const MpcdiRegion& region) {
    walltext::Tile tile;
    tile.name = tileNames_.make(region.id);
    tile.px = {region.widthPx, region.heightPx};
    tile.settings.warp = walltext::Warp{archiveName(), region.id};
    return tile;
  }

  /// A screen that one region's tile covers.
  void addScreen(const MpcdiRegion& region, const walltext::Corners& corners) {
    walltext::Screen screen;
    screen.corners = corners;
    screen.tiles.push_back(tile(region));
    screen.name = screen.tiles[0].name;
    screen.tiles[0].sizeMm = {lengthOf(corners.lowerRight - corners.lowerLeft) * 1000,
                              lengthOf(corners.upperLeft - corners.lowerLeft) * 1000};
    wall_.screens.push_back(std::move(screen));
  }

  void buffers() {
    NameMaker screenNames;
    double x = 0, width = 0, height = 0;
    for (const MpcdiBuffer& buffer : mpcdi_.buffers) {
      double widthPx = buffer.widthPx, heightPx = buffer.heightPx;
      for (const MpcdiRegion& region : mpcdi_.regions) {
        if (region.buffer != buffer.id) continue;
        if (buffer.widthPx == 0) widthPx = std::max(widthPx, region.widthPx / region.width);
        if (buffer.heightPx == 0) heightPx = std::max(heightPx, region.heightPx / region.height);
      }
      walltext::Screen screen;
      screen.name = screenNames.make(buffer.id);
      for (const MpcdiRegion& region : mpcdi_.regions) {
        if (region.buffer != buffer.id) continue;
        walltext::Tile tile = this->tile(region);
        tile.sizeMm = {region.width * widthPx, region.height * heightPx};
        tile.atMm = {region.x * widthPx, (1 - region.y - region.height) * heightPx};
        screen.tiles.push_back(std::move(tile));
      }
      if (screen.tiles.empty()) {
        warnings_.add("buffer without a region", 0, "left out");
        continue;
      }
      screen.corners = {Vec3(x, 0, 0), Vec3(x + widthPx / 1000, 0, 0), Vec3(x, heightPx / 1000, 0)};
      width = x + widthPx / 1000;
      height = std::max(height, heightPx / 1000);
      x = width + kGapBetweenBuffersM;
      wall_.screens.push_back(std::move(screen));
    }
    if (wall_.screens.size() == 1) {
      wall_.screens[0].corners.reset();
      return;
    }
    walltext::Observer observer;
    observer.eyeM = Vec3(width / 2, height / 2, std::max(width, height));
    wall_.observer = observer;
    warnings_.add(
        "several buffers", 0,
        "the archive does not say where they stand; placed side by side in one plane, and the eye before "
        "the middle, as far away as the wall is wide or high");
  }

  void frusta() {
    constexpr double kRadians = std::numbers::pi / 180;
    wall_.observer = walltext::Observer{};
    for (const MpcdiRegion& region : mpcdi_.regions) {
      const MpcdiFrustum& frustum = *region.frustum;
      const Eigen::Quaterniond turn = Eigen::AngleAxisd(-frustum.yawDeg * kRadians, Vec3::UnitY()) *
                                      Eigen::AngleAxisd(frustum.pitchDeg * kRadians, Vec3::UnitX()) *
                                      Eigen::AngleAxisd(-frustum.rollDeg * kRadians, Vec3::UnitZ());
      const auto at = [&](double acrossDeg, double upDeg) -> Vec3 {
        return turn * Vec3(std::tan(acrossDeg * kRadians), std::tan(upDeg * kRadians), -1) * kScreenDistanceM;
      };
      if (region.frame && lengthOf(region.frame->position) > 0) {
        warnings_.add("position of a region in the profile 3d", 0, "all regions have one eye; left out");
      }
      addScreen(region, {at(frustum.leftDeg, frustum.downDeg), at(frustum.rightDeg, frustum.downDeg),
                         at(frustum.leftDeg, frustum.upDeg)});
    }
    warnings_.add("frusta without a distance", 0, "their screens are placed 1 m before the eye");
  }

  void points() {
    std::optional<MpcdiWarp::Origin> origin;
    for (const MpcdiRegion& region : mpcdi_.regions) {
      if (!region.warp) return fail("the region " + region.id + " has no map of the points that it lights");
      if (origin && *origin != region.warp->origin) return fail("the maps of points have different origins");
      origin = region.warp->origin;
    }
    walltext::Observer observer;
    if (origin == MpcdiWarp::Origin::CenterOfMass) {
      return fail("says where the lit points lie from their own middle only, so not where the eye is");
    }
    if (origin != MpcdiWarp::Origin::IdealEyePoint) {
      observer.eyeM = Vec3(0, kEyeHeightM, 0);
      warnings_.add("points measured from the floor", 0, "the eye is taken to be 1.6 m above the origin");
    }
    wall_.observer = observer;
    for (const MpcdiRegion& region : mpcdi_.regions) {
      const Result<PictureRectangle> picture = pictureAround(region, observer.eyeM);
      if (!picture) return fail(picture.error().text());
      addScreen(region, {picture->lowerLeft, picture->lowerRight, picture->upperLeft});
    }
    warnings_.add("surfaces that are not flat", 0,
                  "are drawn on a flat screen each, as the eye sees them; the warp holds for this eye alone");
  }

  void fail(std::string what) {
    if (!error_) error_ = inputError(fileName_, std::move(what));
  }

  const Mpcdi& mpcdi_;
  std::string fileName_;
  std::optional<Error> error_;
  WarningList warnings_;
  NameMaker tileNames_;
  walltext::Wall wall_;
};

}  // namespace

Result<ImportedWall> wallOfMpcdi(const Mpcdi& mpcdi, const std::string& fileName) {
  return Importer(mpcdi, fileName).run();
}

}  // namespace tessera
