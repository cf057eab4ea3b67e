#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry/frustum.h"
#include "common/geometry/vec.h"

namespace tessera {

/// Limits of the vertical field of view. Outside them the image plane degenerates numerically.
inline constexpr double kMinFovYDeg = 0.001;
inline constexpr double kMaxFovYDeg = 179.9;

/// A flat rectangle of the wall, one that tiles lie on. Lengths on it are in millimetres, which are exact
/// where a file gives whole ones or nothing but pixels (then one to a pixel).
struct Screen {
  std::string name;
  double widthMm = 1, heightMm = 1;
  /// Its middle in the room, metres, and its axes as the viewer sees it: unit, at right angles.
  Vec3 centerM = Vec3::Zero(), right = Vec3::UnitX(), up = Vec3::UnitY();
  std::uint32_t firstTile = 0, tileCount = 0;
  /// Where its tiles are an even grid (no place empty, one size, all turned alike, none by other than quarter
  /// turns), stored row by row from the top; 0 else.
  int columns = 0, rows = 0;
  /// The grid's lattice, of which each cell holds one tile, about the screen's middle: in half the screen's
  /// sizes. Larger than 1 where bezels lie between the tiles, smaller where tiles overlap.
  double latticeWidth = 1, latticeHeight = 1;

  /// Towards the viewer.
  [[nodiscard]] Vec3 normal() const;
};

/// Which of an observer's eyes a tile is for.
enum class TileEye : std::uint8_t { Both, Left, Right };

/// What a tile does with its picture, and where it shows it.
struct TileOutput {
  std::string host;                                 ///< for people and start scripts; may be empty
  std::string monitor;                              ///< full screen there; empty: a window
  std::optional<std::array<int, 2>> windowPx = {};  ///< a window's upper left corner on the desktop
  std::array<double, 3> gainRgb = {1, 1, 1};        ///< of light
  std::array<double, 3> blackRgb = {0, 0, 0};       ///< the least encoded value
  double gamma = 2.2;                               ///< light = encoded ^ gamma
  std::array<double, 4> blendPx = {0, 0, 0, 0};     ///< ramps at left, right, bottom, top of the picture
  std::string warpFile, warpRegion;                 ///< MPCDI; empty: no warp
};

/// What one client draws: a rectangle of a screen.
struct Tile {
  std::string name;
  std::uint32_t screen = 0;
  /// On the screen, from its middle in halves of its width (x, right) and height (y, up): lower left, lower
  /// right, upper right, upper left of the tile as it is mounted and seen.
  std::array<Vec2, 4> corners = {Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1)};
  int widthPx = 0, heightPx = 0;     ///< of its picture
  double widthMm = 0, heightMm = 0;  ///< along the picture's rows and columns
  /// Where its middle is mounted, millimetres from the screen's, x right, y up: as `corners` say, but for
  /// walls whose picture is pushed together over the bezels.
  Vec2 mountMm = Vec2::Zero();
  /// By so many quarters of a turn is the panel mounted clockwise: with 1 the picture's upper edge is at the
  /// viewer's right.
  int quarterTurns = 0;
  double freeTurnRad = 0;  ///< beyond those, clockwise; then `corners` are no upright rectangle
  /// The picture that tiles of a screen draw parts of, where they lie on one lattice of pixels: its size and
  /// this tile's place from the upper left. Else the tile's own size, at 0, 0.
  int canvasWidthPx = 0, canvasHeightPx = 0, xPx = 0, yPx = 0;
  TileEye eye = TileEye::Both;
  TileOutput output;
};

/// How an observer's two eyes are shown.
enum class Stereo : std::uint8_t {
  None,
  SideBySide,  ///< the left eye in the left half of each tile's pixels
  TopBottom,   ///< the left eye in the upper half
  Tiles,       ///< each eye by tiles of its own (TileEye)
  QuadBuffer,  ///< by the graphics card
};

/// Somebody who stands in the room before the screens.
struct Observer {
  Vec3 eyeM = Vec3::Zero();  ///< between the eyes; the camera path's eye is here
  double scale = 1;          ///< lengths of the scene for a metre of the room
  int oscPort = 0;           ///< where a tracker says /tessera/head; 0: nowhere
  Stereo stereo = Stereo::None;
  double separationM = 0.065;  ///< of the eyes, along the room's x
};

/// The viewpoint of one frame, world space. Looks from `eye` to `target`; `fovYRad` is the vertical field of
/// view over the whole wall, and overrides the wall's own where present.
struct CameraPose {
  Vec3 eye = Vec3::Zero();
  Vec3 target = Vec3(0, 0, -1);
  Vec3 up = Vec3(0, 1, 0);
  std::optional<double> fovYRad = {};
  bool hasHead = false;
  Vec3 headM =
      Vec3::Zero();  ///< where hasHead: a tracked observer is here in the room, not at Observer::eyeM
};

/// The screens of a wall and their tiles. Either a virtual camera looks through the one screen there is,
/// which then fills `fovYRad`, or an observer stands before screens in a room: x right, y up, z towards the
/// viewer, metres. The camera's right, up and view are then the room's x, y and -z.
struct Wall {
  std::string source;  ///< the file it came from, for messages
  std::string name;    ///< for people; may be empty
  std::vector<Screen> screens;
  std::vector<Tile> tiles;  ///< screen after screen
  double fovYRad = 0;       ///< of the virtual camera
  std::optional<Observer> observer;
  std::optional<double> near, far;    ///< units of the scene; absent: fitted to the scene each frame
  std::vector<std::string> warnings;  ///< allowed but unwise; one sentence each

  /// The same wall with one tile to a screen, named "wall" or, of several, as their screens; of as many
  /// pixels as its tiles' pixels are fine. Where eyes have tiles of their own, one for each eye, named with
  /// "-left" and "-right".
  [[nodiscard]] Wall untiled() const;
};

/// "4 x 3 tiles of 1920 x 1080 pixels" or what else is to be said of a wall in a line.
[[nodiscard]] std::string summaryOf(const Wall& wall);

/// A wall of one screen under a virtual camera: columns x rows tiles of square pixels without gaps, row by
/// row from the top, named r<row>c<column>.
[[nodiscard]] Wall gridWall(int columns, int rows, int tileWidthPx, int tileHeightPx, double fovYRad);

struct ImageAxes {
  Vec3 right = Vec3::UnitX(), up = Vec3::UnitY();  ///< unit, at right angles, world space
};

/// One frame's view of the whole wall. All frusta are of the one eye between the observer's, and their
/// corners as the viewer sees them (Tile::corners); see drawnFrustum for what a tile draws.
struct WallView {
  std::vector<Frustum> screens;   ///< in the order of Wall::screens
  std::vector<Frustum> lattices;  ///< of the screens' grids
  std::vector<Frustum> tiles;     ///< in the order of Wall::tiles
  /// The tiles' by each eye of a stereo observer, those of a tile for one eye both by that; else empty.
  std::vector<Frustum> left, right;
  std::vector<Frustum> leftLattices, rightLattices;  ///< the screens', by each eye
  std::vector<ImageAxes> axes;  ///< of the screens; tiles that are turned have their own (drawnAxes)
};

/// The frusta of one frame. Neighbouring tiles share the doubles of their common corners, so they share
/// planes and leave no gap. Near and far are the wall's own or, where it has none, fitted to the sphere
/// (`sceneCenter`, `sceneRadius` > 0): all tiles of a screen share them. The pose must be finite, its eye
/// different from its target and its up not along the view (CameraPath guarantees it); of a pose that breaks
/// the latter two the result is some finite view. An observer's eyes must be before every screen (isBefore).
[[nodiscard]] WallView viewOf(const Wall& wall, const CameraPose& pose, const Vec3& sceneCenter,
                              double sceneRadius);

/// The same into `view`, whose capacities are reused.
void viewInto(const Wall& wall, const CameraPose& pose, const Vec3& sceneCenter, double sceneRadius,
              WallView& view);

/// How far an eye must be before a screen, metres.
inline constexpr double kLeastEyeDistanceM = 0.01;

/// The first screen that an observer whose eyes have their middle at `headM` is not before, by
/// kLeastEyeDistanceM with each eye; nothing where all is well.
[[nodiscard]] std::optional<std::size_t> screenNotBefore(const Wall& wall, const Vec3& headM);

/// The same frustum with the corners of the tile's picture: lower left, lower right, upper right, upper left
/// of what the tile draws.
[[nodiscard]] Frustum drawnFrustum(const Tile& tile, const Frustum& mounted);
/// The picture's axes in the world.
[[nodiscard]] ImageAxes drawnAxes(const Tile& tile, const ImageAxes& screen);

}  // namespace tessera
