#include "common/wall/wall_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace tessera {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMostSidePx = 65535;
/// Between what does not hang together, of the height.
constexpr double kGap = 0.06;

using Quad = std::array<Vec2, 4>;

struct Extent {
  Vec2 least = Vec2(kInfinity, kInfinity), most = Vec2(-kInfinity, -kInfinity);
  void add(const Vec2& p) {
    least = least.cwiseMin(p);
    most = most.cwiseMax(p);
  }
};

/// A tile as mounted: lower left, lower right, upper right, upper left, from the screen's middle, y up.
Quad mountedQuad(const Tile& tile) {
  const bool isTurned = tile.quarterTurns % 2 != 0;
  const double halfWidth = (isTurned ? tile.heightMm : tile.widthMm) / 2;
  const double halfHeight = (isTurned ? tile.widthMm : tile.heightMm) / 2;
  const double c = std::cos(tile.freeTurnRad), s = std::sin(tile.freeTurnRad);
  Quad quad;
  constexpr std::array<std::array<int, 2>, 4> kSigns = {{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for (std::size_t i = 0; i < 4; ++i) {
    const double x = kSigns[i][0] * halfWidth, y = kSigns[i][1] * halfHeight;
    quad[i] = tile.mountMm + (tile.freeTurnRad == 0 ? Vec2(x, y) : Vec2(c * x + s * y, c * y - s * x));
  }
  return quad;
}

/// What a screen and its tiles cover, from its middle, y up.
Extent extentOf(const Wall& wall, const Screen& screen) {
  Extent extent;
  extent.add(Vec2(-screen.widthMm, -screen.heightMm) / 2);
  extent.add(Vec2(screen.widthMm, screen.heightMm) / 2);
  for (std::uint32_t t = screen.firstTile; t < screen.firstTile + screen.tileCount; ++t) {
    for (const Vec2& corner : mountedQuad(wall.tiles[t]))
      extent.add(corner);
  }
  return extent;
}

Quad flatQuad(const FlatScreen& flat, const Screen& screen) {
  const double w = screen.widthMm / 2, h = screen.heightMm / 2;
  return {flat.at({-w, -h}), flat.at({w, -h}), flat.at({w, h}), flat.at({-w, h})};
}

std::array<Vec3, 4> roomQuad(const Screen& screen) {
  const Vec3 right = screen.right * (screen.widthMm / 2000), up = screen.up * (screen.heightMm / 2000);
  return {screen.centerM - right - up, screen.centerM + right - up, screen.centerM + right + up,
          screen.centerM - right + up};
}

/// Two convex quads that cover each other by more than a sliver.
bool cover(const Quad& a, const Quad& b) {
  constexpr double kSliver = 0.01;
  const auto isApart = [](const Quad& p, const Quad& q) {
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 edge = p[(i + 1) % 4] - p[i], normal(edge.y(), -edge.x());
      double pLeast = kInfinity, pMost = -kInfinity, qLeast = kInfinity, qMost = -kInfinity;
      for (std::size_t k = 0; k < 4; ++k) {
        const double x = normal.dot(p[k]), y = normal.dot(q[k]);
        pLeast = std::min(pLeast, x), pMost = std::max(pMost, x);
        qLeast = std::min(qLeast, y), qMost = std::max(qMost, y);
      }
      const double sliver = kSliver * std::min(pMost - pLeast, qMost - qLeast);
      if (pMost <= qLeast + sliver || qMost <= pLeast + sliver) return true;
    }
    return false;
  };
  return !isApart(a, b) && !isApart(b, a);
}

/// Lays screens out; see WallPicture.
class Unfolding {
 public:
  explicit Unfolding(const Wall& wall)
      : wall_(wall), flat_(wall.screens.size()), group_(wall.screens.size(), 0) {
    std::vector<std::vector<std::size_t>> pieces;
    for (std::size_t first = 0; first < flat_.size(); ++first) {
      if (group_[first] != 0) continue;
      std::vector<std::size_t>& open = pieces.emplace_back(1, first);
      group_[first] = static_cast<int>(pieces.size());
      for (std::size_t i = 0; i < open.size(); ++i)
        unfoldAbout(open[i], open);
    }
    setInRows(pieces);
  }

  [[nodiscard]] std::vector<FlatScreen> take() { return std::move(flat_); }

 private:
  void add(std::size_t s, Extent& extent) const {
    const Extent own = extentOf(wall_, wall_.screens[s]);
    for (const double x : {own.least.x(), own.most.x()}) {
      for (const double y : {own.least.y(), own.most.y()})
        extent.add(flat_[s].at({x, y}));
    }
  }

  /// Side by side, as lines of text are set, to a picture about twice as wide as high.
  void setInRows(const std::vector<std::vector<std::size_t>>& pieces) {
    std::vector<Extent> extents(pieces.size());
    double area = 0, widest = 0, tallest = 0;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      for (const std::size_t s : pieces[i])
        add(s, extents[i]);
      const Vec2 size = extents[i].most - extents[i].least;
      area += size.x() * size.y();
      widest = std::max(widest, size.x());
      tallest = std::max(tallest, size.y());
    }
    const double mostWidth = std::max(widest, std::sqrt(2 * area)) * (1 + kGap), gap = kGap * tallest;
    double x = 0, y = 0, rowHeight = 0;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const Vec2 size = extents[i].most - extents[i].least;
      if (x > 0 && x + size.x() > mostWidth) {
        y += rowHeight + gap;
        x = rowHeight = 0;
      }
      for (const std::size_t s : pieces[i])
        flat_[s].center += Vec2(x, y) - extents[i].least;
      x += size.x() + gap;
      rowHeight = std::max(rowHeight, size.y());
    }
  }

  void unfoldAbout(std::size_t from, std::vector<std::size_t>& open) {
    for (std::size_t s = 0; s < flat_.size(); ++s) {
      if (group_[s] != 0) continue;
      const std::optional<FlatScreen> placed = hinged(from, s);
      if (!placed || coversAny(*placed, s, group_[from])) continue;
      flat_[s] = *placed;
      group_[s] = group_[from];
      open.push_back(s);
    }
  }

  [[nodiscard]] bool coversAny(const FlatScreen& placed, std::size_t s, int group) const {
    const Quad quad = flatQuad(placed, wall_.screens[s]);
    for (std::size_t other = 0; other < flat_.size(); ++other) {
      if (other != s && group_[other] == group && cover(quad, flatQuad(flat_[other], wall_.screens[other])))
        return true;
    }
    return false;
  }

  /// Screen `s`, turned over the edge that it shares with one that is placed.
  [[nodiscard]] std::optional<FlatScreen> hinged(std::size_t from, std::size_t s) const {
    const Screen &a = wall_.screens[from], &b = wall_.screens[s];
    const auto roomA = roomQuad(a), roomB = roomQuad(b);
    const Quad flatA = flatQuad(flat_[from], a), flatB = flatQuad({}, b);
    const double tolerance =
        0.002 + 0.01 * std::min(std::min(a.widthMm, a.heightMm), std::min(b.widthMm, b.heightMm)) / 1000;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t iNext = (i + 1) % 4, kNext = (k + 1) % 4;
        if ((roomA[i] - roomB[kNext]).norm() > tolerance || (roomA[iNext] - roomB[k]).norm() > tolerance)
          continue;
        const Vec2 edge = flatA[iNext] - flatA[i], own = flatB[k] - flatB[kNext];
        FlatScreen placed;
        placed.turnRad = std::remainder(std::atan2(edge.y(), edge.x()) - std::atan2(own.y(), own.x()),
                                        2 * std::numbers::pi);
        const double quarters = placed.turnRad / (std::numbers::pi / 2);
        if (std::abs(quarters - std::round(quarters)) < 1e-6)
          placed.turnRad = std::round(quarters) * (std::numbers::pi / 2);
        placed.center =
            (flatA[i] + flatA[iNext]) / 2 - (flatQuad(placed, b)[k] + flatQuad(placed, b)[kNext]) / 2;
        return placed;
      }
    }
    return std::nullopt;
  }

  const Wall& wall_;
  std::vector<FlatScreen> flat_;
  std::vector<int> group_;  ///< what hangs together, from 1; 0: not placed yet
};

/// Snaps what differs from whole numbers by rounding alone.
double snapped(double x, double slack) {
  const double whole = std::round(x);
  return std::abs(x - whole) < slack ? whole : x;
}

PicturePlace placeOf(const Tile& tile, const FlatScreen& flat, const WallPicture& picture,
                     const Vec2& origin) {
  const Quad quad = mountedQuad(tile);
  // Of what it draws: lower left, lower right, upper right, upper left.
  const auto corner = [&](std::size_t i) {
    const Vec2 mm = flat.at(quad[(i + 3 * static_cast<std::size_t>(tile.quarterTurns)) % 4]) - origin;
    return Vec2(mm.x() * picture.pxPerMmAcross, mm.y() * picture.pxPerMmDown);
  };
  PicturePlace place{corner(3), (corner(2) - corner(3)) / tile.widthPx,
                     (corner(0) - corner(3)) / tile.heightPx};
  constexpr double kSlack = 1e-6;
  for (Vec2* step : {&place.across, &place.down})
    *step = Vec2(snapped(step->x(), kSlack), snapped(step->y(), kSlack));
  const auto isUnit = [](const Vec2& v) { return v.cwiseAbs().sum() == 1 && v.x() * v.y() == 0; };
  if (isUnit(place.across) && isUnit(place.down))
    place.corner = Vec2(std::round(place.corner.x()), std::round(place.corner.y()));
  return place;
}

void setFineness(const Wall& wall, double mostPixels, WallPicture& picture) {
  const Tile& first = wall.tiles.front();
  const Screen& screen = wall.screens.front();
  double across = 0;
  for (const Tile& tile : wall.tiles)
    across = std::max({across, tile.widthPx / tile.widthMm, tile.heightPx / tile.heightMm});
  double down = across;
  const bool isLattice = wall.screens.size() == 1 && first.quarterTurns == 0 &&
                         (first.canvasWidthPx > first.widthPx || first.canvasHeightPx > first.heightPx ||
                          wall.tiles.size() == 1);
  if (isLattice) {
    across = first.canvasWidthPx / screen.widthMm;
    down = first.canvasHeightPx / screen.heightMm;
  }
  const double pixels = picture.widthMm * across * picture.heightMm * down;
  const double side = std::max(picture.widthMm * across, picture.heightMm * down);
  const double shrink = std::min({1.0, std::sqrt(mostPixels / pixels), kMostSidePx / side});
  picture.pxPerMmAcross = across * shrink;
  picture.pxPerMmDown = down * shrink;
}

}  // namespace

Vec2 FlatScreen::at(const Vec2& mm) const {
  const Vec2 down(mm.x(), -mm.y());
  const double quarters = std::round(turnRad / (std::numbers::pi / 2));
  if (turnRad == quarters * (std::numbers::pi / 2)) {  // no rounding in the usual case
    Vec2 turned = down;
    for (int i = 0; i < (static_cast<int>(quarters) % 4 + 4) % 4; ++i)
      turned = Vec2(-turned.y(), turned.x());
    return center + turned;
  }
  const double c = std::cos(turnRad), s = std::sin(turnRad);
  return center + Vec2(c * down.x() - s * down.y(), s * down.x() + c * down.y());
}

WallPicture wallPicture(const Wall& wall, double mostPixels) {
  WallPicture picture;
  picture.screens = Unfolding(wall).take();
  Extent extent;
  for (std::size_t s = 0; s < wall.screens.size(); ++s) {
    const Extent own = extentOf(wall, wall.screens[s]);
    for (const double x : {own.least.x(), own.most.x()}) {
      for (const double y : {own.least.y(), own.most.y()})
        extent.add(picture.screens[s].at({x, y}));
    }
  }
  for (FlatScreen& flat : picture.screens)
    flat.center -= extent.least;
  picture.widthMm = extent.most.x() - extent.least.x();
  picture.heightMm = extent.most.y() - extent.least.y();
  const bool hasEyes = wall.observer && wall.observer->stereo == Stereo::Tiles;
  const double secondMm = picture.widthMm * (1 + kGap);
  if (hasEyes) picture.widthMm += secondMm;
  setFineness(wall, mostPixels, picture);
  const auto pixels = [](double px) {
    return static_cast<int>(std::clamp(std::round(px), 1.0, kMostSidePx));
  };
  picture.widthPx = pixels(picture.widthMm * picture.pxPerMmAcross);
  picture.heightPx = pixels(picture.heightMm * picture.pxPerMmDown);
  for (const Tile& tile : wall.tiles) {
    const Vec2 origin(tile.eye == TileEye::Right ? -secondMm : 0, 0);
    picture.tiles.push_back(placeOf(tile, picture.screens[tile.screen], picture, origin));
    const auto& blend = tile.output.blendPx;
    if (!tile.output.warpFile.empty() ||
        std::any_of(blend.begin(), blend.end(), [](double px) { return px > 0; }))
      picture.gamma = tile.output.gamma;
  }
  return picture;
}

}  // namespace tessera
