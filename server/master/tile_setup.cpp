#include "server/master/tile_setup.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "common/wall/mpcdi/mpcdi.h"
#include "common/wall/mpcdi/warp_mesh.h"

namespace tessera {

namespace {

void append(std::vector<std::byte>& bytes, std::uint32_t value, int count) {
  for (int i = 0; i < count; ++i)
    bytes.push_back(static_cast<std::byte>(value >> (8 * i)));
}

std::vector<std::byte> bytesOf(const std::vector<float>& values) {
  std::vector<std::byte> bytes;
  bytes.reserve(values.size() * 4);
  for (const float value : values)
    append(bytes, std::bit_cast<std::uint32_t>(value), 4);
  return bytes;
}

std::vector<std::byte> bytesOf(const std::vector<std::uint16_t>& values) {
  std::vector<std::byte> bytes;
  bytes.reserve(values.size() * 2);
  for (const std::uint16_t value : values)
    append(bytes, value, 2);
  return bytes;
}

Vec3 roomPoint(const Screen& screen, const Vec2& corner) {
  return screen.centerM + screen.right * (corner.x() * screen.widthMm / 2000) +
         screen.up * (corner.y() * screen.heightMm / 2000);
}

/// The map in the pixels of another, the nearest of its own.
std::vector<std::uint16_t> resized(const MpcdiMap& map, std::int32_t widthPx, std::int32_t heightPx) {
  std::vector<std::uint16_t> values;
  values.reserve(static_cast<std::size_t>(widthPx) * static_cast<std::size_t>(heightPx));
  for (std::int64_t y = 0; y < heightPx; ++y) {
    for (std::int64_t x = 0; x < widthPx; ++x) {
      const std::int64_t from = (2 * y + 1) * map.heightPx / (2 * heightPx) * map.widthPx +
                                (2 * x + 1) * map.widthPx / (2 * widthPx);
      values.push_back(map.values[static_cast<std::size_t>(from)]);
    }
  }
  return values;
}

}  // namespace

std::span<const std::byte> TileSetups::keep(std::vector<std::byte> bytes) {
  return kept_.emplace_back(std::move(bytes));
}

Result<TileSetups> TileSetups::make(const Wall& wall) {
  TileSetups setups;
  for (const Tile& tile : wall.tiles) {
    const Screen& screen = wall.screens[tile.screen];
    proto::TileSetup setup;
    setup.screenName = screen.name.substr(0, proto::kMaxNameBytes);
    // Of a wall that is pushed together over its bezels the picture is told, not the panels.
    setup.screenWidthM = screen.widthMm / 1000;
    setup.screenHeightM = screen.heightMm / 1000;
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2& corner = tile.corners[(i + 3 * static_cast<std::size_t>(tile.quarterTurns)) % 4];
      setup.cornersM[i] =
          Vec2((corner.x() + 1) * screen.widthMm / 2000, (corner.y() + 1) * screen.heightMm / 2000);
    }
    const TileOutput& output = tile.output;
    for (std::size_t i = 0; i < 3; ++i) {
      setup.gainRgb[i] = static_cast<float>(output.gainRgb[i]);
      setup.blackRgb[i] = static_cast<float>(output.blackRgb[i]);
    }
    setup.gamma = static_cast<float>(output.gamma);
    for (std::size_t i = 0; i < 4; ++i)
      setup.blendPx[i] = static_cast<float>(output.blendPx[i]);
    if (!output.warpFile.empty()) {
      if (Status status = setups.addWarp(wall, tile, setup); !status) return status.error();
    }
    setups.setups_.push_back(std::move(setup));
  }
  return setups;
}

Status TileSetups::addWarp(const Wall& wall, const Tile& tile, proto::TileSetup& setup) {
  const Result<Mpcdi> mpcdi = readMpcdi(tile.output.warpFile, tile.output.warpRegion);
  if (!mpcdi) return mpcdi.error();
  const auto region = std::find_if(mpcdi->regions.begin(), mpcdi->regions.end(),
                                   [&](const MpcdiRegion& r) { return r.id == tile.output.warpRegion; });
  if (region == mpcdi->regions.end())
    return inputError(tile.output.warpFile, "it has no region \"" + tile.output.warpRegion + "\"",
                      "check the \"warp\" of tile \"" + tile.name + "\"");
  WarpMesh mesh;
  if (region->warp && region->warp->isInSpace) {
    const Screen& screen = wall.screens[tile.screen];
    const PictureRectangle picture = {roomPoint(screen, tile.corners[0]), roomPoint(screen, tile.corners[1]),
                                      roomPoint(screen, tile.corners[3])};
    const Vec3 eye = wall.observer ? wall.observer->eyeM : Vec3(Vec3::Zero());
    mesh = warpMeshSeenFrom(*region, eye, picture, kMostWarpErrorPx);
  } else {
    mesh = warpMeshOf(*region, kMostWarpErrorPx);
  }
  if (mesh.columns < 2 || mesh.rows < 2)
    return inputError(tile.output.warpFile,
                      "the warp of region \"" + region->id + "\" cannot be seen from the eye",
                      "check the observer and the tile's screen");
  warpErrorPx_ = std::max(warpErrorPx_, mesh.errorPx);
  proto::Warp warp;
  warp.columns = static_cast<std::uint32_t>(mesh.columns);
  warp.rows = static_cast<std::uint32_t>(mesh.rows);
  warp.uv = keep(bytesOf(mesh.uv));
  const MpcdiMap alpha = alphaOf(*region);
  if (!alpha.isEmpty() || !region->beta.isEmpty()) {
    const MpcdiMap& sized = alpha.isEmpty() ? region->beta : alpha;
    warp.maskWidthPx = static_cast<std::uint32_t>(sized.widthPx);
    warp.maskHeightPx = static_cast<std::uint32_t>(sized.heightPx);
    const auto count = static_cast<std::size_t>(sized.widthPx) * static_cast<std::size_t>(sized.heightPx);
    warp.alpha = keep(bytesOf(alpha.isEmpty() ? std::vector<std::uint16_t>(count, 65535) : alpha.values));
    warp.maskGamma = static_cast<float>(std::clamp(alpha.gammaEmbedded, 0.1, 10.0));
    if (!region->beta.isEmpty())
      warp.beta = keep(bytesOf(resized(region->beta, sized.widthPx, sized.heightPx)));
  }
  constexpr std::size_t kMostBytes = std::size_t{60} << 20U;  // a little less than a message may have
  if (warp.uv.size() + warp.alpha.size() + warp.beta.size() > kMostBytes)
    return inputError(tile.output.warpFile,
                      "the warp and masks of region \"" + region->id + "\" take more than 60 MiB",
                      "make its maps smaller");
  setup.warp = warp;
  return Done{};
}

proto::StereoLayout stereoLayout(const Wall& wall) {
  switch (wall.observer ? wall.observer->stereo : Stereo::None) {
    case Stereo::SideBySide:
      return proto::StereoLayout::SideBySide;
    case Stereo::TopBottom:
      return proto::StereoLayout::TopBottom;
    case Stereo::QuadBuffer:
      return proto::StereoLayout::QuadBuffer;
    case Stereo::None:
    case Stereo::Tiles:
      break;
  }
  return proto::StereoLayout::None;
}

}  // namespace tessera
