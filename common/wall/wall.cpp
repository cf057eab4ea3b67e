#include "common/wall/wall.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "common/wall/view_axes.h"

namespace tessera {

namespace {

/// One tile may be so large on a side.
constexpr int kMostUntiledPx = 65535;

struct Axes {
  Vec3 right, up, forward;
};

struct DepthRange {
  double near, far;
};

Axes axesOf(const CameraPose& pose) {
  const Vec3 forward = direction(pose.target - pose.eye).value_or(-Vec3::UnitZ());
  const std::optional<Vec3> maybeUp = upAcross(forward, pose.up);
  const Vec3 up = maybeUp ? *maybeUp : anyUpAcross(forward);
  return {forward.cross(up).normalized(), up, forward};
}

/// Depths that hold the whole scene sphere, as far as it is before the eye. `spread`: how far eyes may be
/// from the one that is meant.
DepthRange fittedDepths(const Vec3& eye, double spread, const Vec3& forward, const Vec3& center,
                        double radius) {
  constexpr double kSlack = 1e-3;
  constexpr double kDeepestRatio =
      2e3;  // as OpenSceneGraph; deeper wastes the depth buffer: surfaces flicker
  // The second term outweighs the rounding of coordinates that are large against the sphere.
  const double largest = std::max(eye.cwiseAbs().maxCoeff(), center.cwiseAbs().maxCoeff());
  const double margin = kSlack * radius + 64 * kUnitRoundoff * largest + spread;
  const double depth = forward.dot(center - eye);
  const double far = std::max(depth + radius + margin, radius);
  return {std::max(depth - radius - margin, far / kDeepestRatio), far};
}

/// The wall's own distances where it has them, the fitted ones else, and near < far in any case.
DepthRange depthsOf(const Wall& wall, const DepthRange& fitted) {
  DepthRange depths{wall.near.value_or(fitted.near), wall.far.value_or(fitted.far)};
  if (depths.near < depths.far) return depths;
  if (wall.near) return {depths.near, 2 * depths.near};
  return {depths.far / 2, depths.far};
}

/// A screen as one eye sees it: its points are origin + right * x + up * y, x and y in halves of its sizes.
/// Every point is computed in the same way, so tiles that share a corner share its doubles.
struct ScreenImage {
  Vec3 eye, origin, right, up;
  double halfWidth, halfHeight;

  [[nodiscard]] Vec3 at(double x, double y) const {
    return origin + right * (halfWidth * x) + up * (halfHeight * y);
  }
  [[nodiscard]] Frustum rectangle(double halfX, double halfY, const DepthRange& depths) const {
    return {eye,
            {at(-halfX, -halfY), at(halfX, -halfY), at(halfX, halfY), at(-halfX, halfY)},
            depths.near,
            depths.far};
  }
  [[nodiscard]] Frustum tile(const Tile& tile, const DepthRange& depths) const {
    Frustum frustum{eye, {}, depths.near, depths.far};
    for (std::size_t i = 0; i < 4; ++i)
      frustum.corners[i] = at(tile.corners[i].x(), tile.corners[i].y());
    return frustum;
  }
};

void addScreen(const Wall& wall, const Screen& screen, const ScreenImage& image, const DepthRange& depths,
               WallView& view) {
  view.screens.push_back(image.rectangle(1, 1, depths));
  view.lattices.push_back(image.rectangle(screen.latticeWidth, screen.latticeHeight, depths));
  for (std::uint32_t t = screen.firstTile; t < screen.firstTile + screen.tileCount; ++t)
    view.tiles.push_back(image.tile(wall.tiles[t], depths));
}

void viewByCamera(const Wall& wall, const CameraPose& pose, const Vec3& center, double radius,
                  WallView& view) {
  const Screen& screen = wall.screens.front();
  const Axes axes = axesOf(pose);
  const DepthRange depths = depthsOf(wall, fittedDepths(pose.eye, 0, axes.forward, center, radius));
  // How far away the rectangle lies has no meaning, but its corners are rounded to steps that grow with the
  // eye's coordinates. At the far distance, and no nearer than the eye is to the origin, a step is no larger
  // an angle than double's roundoff, even for a tiny scene far out.
  const double distance = std::max(depths.far, pose.eye.cwiseAbs().maxCoeff());
  const double halfHeight = distance * std::tan(pose.fovYRad.value_or(wall.fovYRad) / 2);
  const ScreenImage image{pose.eye,
                          pose.eye + axes.forward * distance,
                          axes.right,
                          axes.up,
                          halfHeight * screen.widthMm / screen.heightMm,
                          halfHeight};
  view.axes.push_back({axes.right, axes.up});
  addScreen(wall, screen, image, depths, view);
}

void viewByObserver(const Wall& wall, const Observer& observer, const CameraPose& pose, const Vec3& center,
                    double radius, WallView& view) {
  const Axes axes = axesOf(pose);
  Mat3 roomToWorld;  // directions
  roomToWorld << axes.right, axes.up, -axes.forward;
  const Vec3 headM = pose.hasHead ? pose.headM : observer.eyeM;
  const auto worldOf = [&](const Vec3& roomM) {
    return Vec3(pose.eye + observer.scale * (roomToWorld * (roomM - observer.eyeM)));
  };
  const bool isStereo = observer.stereo != Stereo::None;
  const double halfSeparationM = isStereo ? observer.separationM / 2 : 0;
  const Vec3 eye = worldOf(headM);
  const auto depthsOfScreen = [&](const Screen& screen) {
    const Vec3 forward = -(roomToWorld * screen.normal()).normalized();
    return depthsOf(wall, fittedDepths(eye, observer.scale * halfSeparationM, forward, center, radius));
  };
  double nearestM = std::numeric_limits<double>::infinity(), far = 0;
  for (const Screen& screen : wall.screens) {
    nearestM = std::min(nearestM, screen.normal().dot(headM - screen.centerM));
    far = std::max(far, depthsOfScreen(screen).far);
  }
  // As above; one factor for all screens, so that they meet where they meet in the room.
  const double distance = std::max(far, eye.cwiseAbs().maxCoeff());
  const double toWorld =
      observer.scale * std::max(1.0, distance / (observer.scale * std::max(nearestM, kLeastEyeDistanceM)));
  const auto imageFor = [&](const Screen& screen, const ImageAxes& screenAxes, double sideM) {
    const Vec3 eyeM = headM + Vec3(sideM, 0, 0);
    const Vec3 from = worldOf(eyeM);
    return ScreenImage{from,
                       from + roomToWorld * (screen.centerM - eyeM) * toWorld,
                       screenAxes.right,
                       screenAxes.up,
                       screen.widthMm / 2000 * toWorld,
                       screen.heightMm / 2000 * toWorld};
  };
  for (const Screen& screen : wall.screens) {
    const Vec3 up = (roomToWorld * screen.up).normalized();
    const Vec3 right = up.cross(roomToWorld * screen.normal()).normalized();
    view.axes.push_back({right, up});
    const DepthRange depths = depthsOfScreen(screen);
    addScreen(wall, screen, imageFor(screen, view.axes.back(), 0), depths, view);
    if (!isStereo) continue;
    const ScreenImage left = imageFor(screen, view.axes.back(), -halfSeparationM);
    const ScreenImage rightImage = imageFor(screen, view.axes.back(), halfSeparationM);
    view.leftLattices.push_back(left.rectangle(screen.latticeWidth, screen.latticeHeight, depths));
    view.rightLattices.push_back(rightImage.rectangle(screen.latticeWidth, screen.latticeHeight, depths));
    for (std::uint32_t t = screen.firstTile; t < screen.firstTile + screen.tileCount; ++t) {
      const Tile& tile = wall.tiles[t];
      view.left.push_back((tile.eye == TileEye::Right ? rightImage : left).tile(tile, depths));
      view.right.push_back((tile.eye == TileEye::Left ? left : rightImage).tile(tile, depths));
    }
  }
}

/// Pixels of a whole screen: those of its canvas, or as fine as the finest of its tiles.
std::array<int, 2> pixelsOf(const Wall& wall, const Screen& screen) {
  const auto first = wall.tiles.begin() + screen.firstTile, end = first + screen.tileCount;
  const auto hasOwnCanvas = [&](const Tile& tile) {
    return screen.tileCount > 1 && tile.canvasWidthPx == tile.widthPx && tile.canvasHeightPx == tile.heightPx;
  };
  if (first == end) return {1, 1};
  if (std::none_of(first, end, hasOwnCanvas)) return {first->canvasWidthPx, first->canvasHeightPx};
  double finest = 0;  // pixels to a millimetre
  for (auto tile = first; tile != end; ++tile)
    finest = std::max({finest, tile->widthPx / tile->widthMm, tile->heightPx / tile->heightMm});
  const auto rounded = [](double px) {
    return static_cast<int>(std::clamp(std::round(px), 1.0, double{kMostUntiledPx}));
  };
  return {rounded(screen.widthMm * finest), rounded(screen.heightMm * finest)};
}

}  // namespace

Vec3 Screen::normal() const {
  return right.cross(up);
}

Wall gridWall(int columns, int rows, int tileWidthPx, int tileHeightPx, double fovYRad) {
  Wall wall;
  wall.source = std::to_string(columns) + "x" + std::to_string(rows);
  wall.fovYRad = fovYRad;
  Screen screen;
  screen.name = "wall";
  screen.widthMm = columns * tileWidthPx;
  screen.heightMm = rows * tileHeightPx;
  screen.tileCount = static_cast<std::uint32_t>(columns * rows);
  screen.columns = columns;
  screen.rows = rows;
  wall.screens.push_back(screen);
  // The quotients run from exactly -1 to exactly 1 and are symmetric, so the outermost corners do not
  // depend on how the wall is divided.
  const auto x = [&](int column) { return static_cast<double>(2 * column - columns) / columns; };
  const auto y = [&](int row) { return static_cast<double>(rows - 2 * row) / rows; };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      Tile tile;
      tile.name = "r" + std::to_string(row) + "c" + std::to_string(column);
      tile.corners = {Vec2(x(column), y(row + 1)), Vec2(x(column + 1), y(row + 1)),
                      Vec2(x(column + 1), y(row)), Vec2(x(column), y(row))};
      tile.widthPx = tileWidthPx;
      tile.heightPx = tileHeightPx;
      tile.widthMm = tileWidthPx;
      tile.heightMm = tileHeightPx;
      tile.mountMm = Vec2((2 * column + 1 - columns) * tileWidthPx, (rows - 1 - 2 * row) * tileHeightPx) / 2;
      tile.canvasWidthPx = columns * tileWidthPx;
      tile.canvasHeightPx = rows * tileHeightPx;
      tile.xPx = column * tileWidthPx;
      tile.yPx = row * tileHeightPx;
      wall.tiles.push_back(std::move(tile));
    }
  }
  return wall;
}

Wall Wall::untiled() const {
  Wall whole = *this;
  whole.tiles.clear();
  whole.warnings.clear();  // they are about seams
  const bool hasEyes = observer && observer->stereo == Stereo::Tiles;
  for (Screen& screen : whole.screens) {
    const auto [widthPx, heightPx] = pixelsOf(*this, screen);
    Tile tile;
    tile.name = screens.size() == 1 ? "wall" : screen.name;
    tile.screen = static_cast<std::uint32_t>(&screen - whole.screens.data());
    tile.widthPx = tile.canvasWidthPx = widthPx;
    tile.heightPx = tile.canvasHeightPx = heightPx;
    tile.widthMm = screen.widthMm;
    tile.heightMm = screen.heightMm;
    screen.firstTile = static_cast<std::uint32_t>(whole.tiles.size());
    screen.tileCount = hasEyes ? 2 : 1;
    screen.columns = screen.rows = hasEyes ? 0 : 1;
    screen.latticeWidth = screen.latticeHeight = 1;
    if (!hasEyes) {
      whole.tiles.push_back(tile);
      continue;
    }
    for (const TileEye eye : {TileEye::Left, TileEye::Right}) {
      whole.tiles.push_back(tile);
      whole.tiles.back().eye = eye;
      whole.tiles.back().name += eye == TileEye::Left ? "-left" : "-right";
    }
  }
  return whole;
}

std::string summaryOf(const Wall& wall) {
  const auto size = [](int width, int height) {
    return std::to_string(width) + " x " + std::to_string(height);
  };
  const Screen& screen = wall.screens.front();
  const Tile& first = wall.tiles.front();
  const bool isAlike = std::all_of(wall.tiles.begin(), wall.tiles.end(), [&](const Tile& tile) {
    return tile.widthPx == first.widthPx && tile.heightPx == first.heightPx;
  });
  std::string text;
  if (wall.screens.size() == 1 && screen.columns > 0) {
    text = size(screen.columns, screen.rows) + " tiles";
  } else {
    text = std::to_string(wall.tiles.size()) + (wall.tiles.size() == 1 ? " tile" : " tiles");
  }
  text += isAlike ? " of " + size(first.widthPx, first.heightPx) + " pixels" : " of several sizes";
  if (wall.screens.size() > 1) text += " on " + std::to_string(wall.screens.size()) + " screens";
  if (wall.screens.size() == 1 && first.canvasWidthPx > 0 &&
      (first.canvasWidthPx > first.widthPx || first.canvasHeightPx > first.heightPx ||
       wall.tiles.size() == 1))
    text += ", " + size(first.canvasWidthPx, first.canvasHeightPx) + " in all";
  return text;
}

WallView viewOf(const Wall& wall, const CameraPose& pose, const Vec3& sceneCenter, double sceneRadius) {
  WallView view;
  viewInto(wall, pose, sceneCenter, sceneRadius, view);
  return view;
}

void viewInto(const Wall& wall, const CameraPose& pose, const Vec3& sceneCenter, double sceneRadius,
              WallView& view) {
  view.screens.clear();
  view.lattices.clear();
  view.tiles.clear();
  view.left.clear();
  view.right.clear();
  view.leftLattices.clear();
  view.rightLattices.clear();
  view.axes.clear();
  view.tiles.reserve(wall.tiles.size());
  if (wall.observer) {
    viewByObserver(wall, *wall.observer, pose, sceneCenter, sceneRadius, view);
  } else {
    viewByCamera(wall, pose, sceneCenter, sceneRadius, view);
  }
}

std::optional<std::size_t> screenNotBefore(const Wall& wall, const Vec3& headM) {
  const bool isStereo = wall.observer && wall.observer->stereo != Stereo::None;
  const double sideM = isStereo ? wall.observer->separationM / 2 : 0;
  for (std::size_t s = 0; s < wall.screens.size(); ++s) {
    const Vec3 normal = wall.screens[s].normal();
    const double distanceM = normal.dot(headM - wall.screens[s].centerM) - std::abs(normal.x()) * sideM;
    if (!(distanceM >= kLeastEyeDistanceM)) return s;
  }
  return std::nullopt;
}

Frustum drawnFrustum(const Tile& tile, const Frustum& mounted) {
  Frustum drawn = mounted;
  for (std::size_t i = 0; i < 4; ++i)
    drawn.corners[i] = mounted.corners[(i + 3 * static_cast<std::size_t>(tile.quarterTurns)) % 4];
  return drawn;
}

ImageAxes drawnAxes(const Tile& tile, const ImageAxes& screen) {
  ImageAxes axes = screen;
  for (int turn = 0; turn < tile.quarterTurns; ++turn)
    axes = {-axes.up, axes.right};
  if (tile.freeTurnRad == 0) return axes;
  const double c = std::cos(tile.freeTurnRad), s = std::sin(tile.freeTurnRad);
  return {(c * axes.right - s * axes.up).normalized(), (s * axes.right + c * axes.up).normalized()};
}

}  // namespace tessera
