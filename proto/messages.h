#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/geometry/vec.h"

namespace tessera::proto {

// The messages as plain data. PROTOCOL.md says who sends which when. Spans refer to memory of somebody else:
// of the sender while encoding, of the payload after decoding.

// Limits on what a message may hold; a decoder refuses more.
inline constexpr std::size_t kMaxNameBytes = 64;
inline constexpr std::size_t kMaxTextBytes = 1024;
inline constexpr std::int32_t kMaxImagePx = 16384;
inline constexpr std::size_t kMaxAssetsPerMessage = 65536;
inline constexpr std::size_t kMaxLeavesPerMessage = 65536;
/// An asset up to this size fits into a message of its own.
inline constexpr std::size_t kMaxAssetBytes = 255U << 20U;
/// Vertices of a warp mesh along a side.
inline constexpr std::uint32_t kMaxWarpSide = 4096;
/// Farthest coordinate on a screen, and the largest screen.
inline constexpr double kMaxScreenM = 1e6;

using Sha256 = std::array<std::uint8_t, 32>;

enum class SurfaceKind : std::uint8_t { None = 0, Offscreen = 1, Window = 2, Egl = 3 };

/// Tile to master, the first message.
struct Hello {
  std::string tileName = {};
  std::string programVersion = {};
  std::string clockId = {};  ///< names the clock of Shown::shownNs; equal names may be compared. May be empty
  SurfaceKind surface = SurfaceKind::None;
  std::uint32_t pid = 0;
  std::uint32_t maxWidthPx = 0, maxHeightPx = 0;  ///< largest picture the surface can draw; 0: no limit known
  std::uint64_t cacheBytes = 0;                   ///< budget of the tile's cache (leaf_cache.h); 0: none
  std::uint32_t haveCount = 0;                    ///< assets on its disk, told by Have before Welcome
  friend bool operator==(const Hello&, const Hello&) = default;
};

/// Tile to master, right after Hello until `haveCount` ids are told: assets that lie on its disk.
struct Have {
  std::vector<Sha256> ids = {};
  friend bool operator==(const Have&, const Have&) = default;
};

/// What a tile does with a leaf that is listed but whose assets are not there yet.
enum class OnMiss : std::uint8_t {
  Wait = 0,  ///< nothing is listed before it is there
  Box = 1,   ///< draws its box in its mean colour
  Skip = 2,  ///< leaves it out
};

enum class PictureFormat : std::uint8_t {
  None = 0,
  RawRgb8 = 1,  ///< 3 bytes a pixel, rows without padding, top row first
};

/// Master to tile: the tile is accepted, and this is what it draws.
struct Welcome {
  std::uint64_t session = 0;
  std::string wallName = {};  ///< may be empty
  std::string tileName = {};
  std::int32_t widthPx = 0, heightPx = 0;
  std::int32_t xPx = 0, yPx = 0;  ///< place in the wall's picture, origin at its upper left
  std::uint32_t idleTimeoutMs = 0;
  std::uint32_t leafCount = 0;                     ///< of the scene: every leaf id is below it
  PictureFormat picture = PictureFormat::None;     ///< how to send the pictures that a frame wants
  std::array<float, 3> backgroundRgb = {0, 0, 0};  ///< each in [0, 1]
  std::int32_t wallWidthPx = 0, wallHeightPx = 0;  ///< of the whole picture, which holds the tile
  OnMiss onMiss = OnMiss::Wait;
  float uploadMs = 0;  ///< most time a frame may spend on making assets drawable; 0: as long as it takes
  friend bool operator==(const Welcome&, const Welcome&) = default;
};

enum class AssetKind : std::uint8_t { Drawable = 0, State = 1, Image = 2 };

struct Asset {
  Sha256 id = {};  ///< SHA-256 of `bytes`; the decoder does not check it, the receiver must
  AssetKind kind = AssetKind::Drawable;
  std::span<const std::byte> bytes = {};
  std::uint32_t diskBytes = 0;     ///< not 0: the bytes, as many, lie on the tile's disk; `bytes` is empty
  std::vector<Sha256> needs = {};  ///< of a state: its images; at most kMaxAssetNeeds
  [[nodiscard]] std::uint32_t size() const {
    return diskBytes > 0 ? diskBytes : static_cast<std::uint32_t>(bytes.size());
  }
};
inline constexpr std::size_t kMaxAssetNeeds = 256;

/// Ids in one Lacks.
inline constexpr std::size_t kMaxLacks = 1024;

/// Tile to master: assets that it was told to take from its disk and that are not there.
struct Lacks {
  std::vector<Sha256> ids = {};
  friend bool operator==(const Lacks&, const Lacks&) = default;
};

/// Master to tile: leaves that count as used now (leaf_cache.h), as they will be needed soon.
struct Keep {
  std::span<const std::byte> leaves = {};  ///< a list delta of list_codec.h from the empty list
};

/// Master to tile: assets that the tile lacks.
struct Assets {
  std::vector<Asset> assets = {};
};

enum class BillboardMode : std::uint8_t { PointRotEye = 0, PointRotWorld = 1, AxialRot = 2 };

/// How a leaf turns to the eye, as osg::Billboard does.
struct LeafBillboard {
  BillboardMode mode = BillboardMode::PointRotEye;
  Vec3 axis = Vec3::Zero();
  Vec3 normal = Vec3::Zero();
  Vec3 position = Vec3::Zero();
  friend bool operator==(const LeafBillboard&, const LeafBillboard&) = default;
};

/// What a tile must know of a leaf to draw it.
struct LeafRecord {
  std::uint32_t id = 0;  ///< the receiver checks it against Welcome::leafCount
  Sha256 drawable = {};
  Sha256 state = {};
  Mat4 localToWorld = Mat4::Identity();
  Vec3 center = Vec3::Zero();  ///< of a sphere around the leaf in world space, for sorting
  double radius = 0;           ///< >= 0
  /// Of the leaf's box about `center`, world space: what stands for it while its assets are not there.
  std::array<Vec3, 3> halfAxes = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  std::array<float, 3> meanRgb = {0, 0, 0};  ///< its colour then, each in [0, 1]
  std::optional<LeafBillboard> billboard = {};
  friend bool operator==(const LeafRecord&, const LeafRecord&) = default;
};

/// Master to tile: records that the tile lacks.
struct Leaves {
  std::vector<LeafRecord> leaves = {};
  friend bool operator==(const Leaves&, const Leaves&) = default;
};

/// What a tile shows instead of the scene.
enum class Pattern : std::uint8_t { None = 0, Identify = 1, Alignment = 2 };

/// Where the pictures of both eyes go. Each is the whole image, squeezed into its half.
enum class StereoLayout : std::uint8_t {
  None = 0,
  SideBySide = 1,  ///< left eye in the left half
  TopBottom = 2,   ///< left eye in the upper half
  QuadBuffer = 3,  ///< left and right back buffers of OpenGL
};

/// The second eye of a stereo frame; all else it shares with the left one.
struct RightEye {
  Vec3 eye = Vec3::Zero();
  std::array<Vec3, 4> corners = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  ///< as in Frustum
  friend bool operator==(const RightEye&, const RightEye&) = default;
};

/// Master to tile: draw this and keep it back until Swap.
struct Frame {
  std::uint64_t frame = 0;      ///< from 1, ascending
  std::uint64_t baseFrame = 0;  ///< the frame, acknowledged by Ready, whose list `toggles` starts from;
                                ///< 0: the empty list. Below `frame`
  Vec3 eye = Vec3::Zero();
  std::array<Vec3, 4> corners = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  ///< as in Frustum
  double nearM = 1, farM = 2;                                                              ///< 0 < near < far
  Vec3 right = Vec3::UnitX(), up = Vec3::UnitY();  ///< axes of the image, of unit length, at right angles
  std::span<const std::byte> toggles = {};         ///< a delta, see list_coder.h
  std::uint32_t listLeafCount = 0;                 ///< leaves in the resulting list, as a check
  bool wantPicture = false;                        ///< Shown shall carry the picture
  bool overlay = false;                            ///< statistics in a corner of the picture
  Pattern pattern = Pattern::None;
  std::uint32_t skewUs = 0;                  ///< between the tiles at the last swap, for the overlay
  std::optional<RightEye> rightEye = {};     ///< stereo: eye and corners above are the left eye's
  StereoLayout stereo = StereoLayout::None;  ///< not None just where there is a right eye
};

/// Tile to master: drawn, waiting for Swap. Acknowledges the frame's list.
struct Ready {
  std::uint64_t frame = 0;
  std::uint32_t drawUs = 0;
  std::uint32_t leafCount = 0;      ///< leaves listed
  std::uint32_t missingLeaves = 0;  ///< of these, not drawn as they are, as their assets are not there yet
  std::uint64_t missingPx = 0;      ///< at most so many pixels of the picture differ for that
  friend bool operator==(const Ready&, const Ready&) = default;
};

/// Master to tile: present it now.
struct Swap {
  std::uint64_t frame = 0;
  friend bool operator==(const Swap&, const Swap&) = default;
};

struct Picture {
  std::int32_t widthPx = 0, heightPx = 0;
  PictureFormat format = PictureFormat::RawRgb8;  ///< never None
  std::span<const std::byte> bytes = {};
};

/// Tile to master: presented.
struct Shown {
  std::uint64_t frame = 0;
  std::int64_t shownNs = 0;  ///< monotonic time of Hello::clockId
  std::optional<Picture> picture = {};
};

/// Master to tile: are you there?
struct Ping {
  std::uint64_t nonce = 0;
  friend bool operator==(const Ping&, const Ping&) = default;
};

/// Tile to master: yes, with the nonce of the Ping.
struct Pong {
  std::uint64_t nonce = 0;
  friend bool operator==(const Pong&, const Pong&) = default;
};

/// Either way: the end, in order. The numbers are the tile's; the master sends zeros.
struct Bye {
  std::string reason = {};
  std::uint64_t peakResidentBytes = 0;
  std::uint64_t framesShown = 0;
  friend bool operator==(const Bye&, const Bye&) = default;
};

enum class InputKind : std::uint8_t { Quit = 0, Key = 1, Button = 2, Move = 3, Scroll = 4, Gamepad = 5 };

/// Limits of Input: codes, steps of a wheel at once, bits of modifiers and of a gamepad's buttons.
inline constexpr std::int32_t kMaxInputCode = 1023;
inline constexpr double kMaxScrollSteps = 1000;
inline constexpr std::uint32_t kInputModifierBits = 6, kGamepadButtonBits = 15;

/// Tile to master: what a person did at the tile's window. Numbers of keys, buttons, modifiers and the
/// gamepad's order of axes and buttons are those of GLFW 3.3.
struct Input {
  InputKind kind = InputKind::Quit;
  std::int32_t code = 0;        ///< of Key and Button: which one; of Gamepad: which of the machine's
  bool pressed = false;         ///< of Key and Button: else it was released
  std::uint32_t modifiers = 0;  ///< of Key and Button: bits, held at that time
  double x = 0, y = 0;  ///< Button, Move: place in the tile's picture, 0 to 1 from its upper left. Scroll:
                        ///< steps to the right and up
  std::array<float, 6> axes = {0, 0, 0, 0, 0, 0};  ///< of Gamepad, -1 to 1: left x, y, right x, y, triggers
  std::uint32_t buttons = 0;                       ///< of Gamepad: a bit for each that is held
  friend bool operator==(const Input&, const Input&) = default;
};

enum class ErrorCode : std::uint16_t {
  Internal = 0,
  UnknownTile = 1,
  TileTaken = 2,
  VersionMismatch = 3,
  ProtocolViolation = 4,
  AssetDamaged = 5,
  TooLarge = 6,
  Timeout = 7,
  ShuttingDown = 8,
};

/// Either way: why the sender closes the connection.
struct ErrorMessage {
  ErrorCode code = ErrorCode::Internal;
  std::string text = {};
  friend bool operator==(const ErrorMessage&, const ErrorMessage&) = default;
};

/// What a projector shows of the picture that was drawn for it, as MPCDI says it. All data by rows from the
/// top.
struct Warp {
  std::uint32_t columns = 0, rows = 0;  ///< vertices, 2 to kMaxWarpSide; the outer ones lie on the edges
  /// columns x rows x 2 little-endian floats (u, v): where in the drawn picture the vertex looks, u from the
  /// left, v from the top, 0 to 1. Nothing is shown beyond, nor around a vertex that is NaN.
  std::span<const std::byte> uv = {};
  std::uint32_t maskWidthPx = 0, maskHeightPx = 0;  ///< 0: no masks
  std::span<const std::byte> alpha = {};            ///< u16 little-endian: factor of light, 65535 is 1
  std::span<const std::byte> beta = {};             ///< the same: encoded black level; may be empty
  float maskGamma = 1;                              ///< factor of light = alpha ^ maskGamma; 0.1 to 10
};

/// Master to tile, at most once and before the first frame: where the tile hangs and what its display needs.
struct TileSetup {
  std::string screenName = {};                 ///< may be empty
  double screenWidthM = 1, screenHeightM = 1;  ///< of the flat screen that the tile is a part of
  /// The tile's picture on the screen: lower left, lower right, upper right, upper left of the picture, from
  /// the screen's lower left corner, x right, y up. The picture of a turned panel is turned with it.
  std::array<Vec2, 4> cornersM = {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
  std::array<float, 3> gainRgb = {1, 1, 1};   ///< in linear light, 0 to 4
  std::array<float, 3> blackRgb = {0, 0, 0};  ///< encoded, 0 to 1: the least value outside of the blend ramps
  float gamma = 2.2F;                         ///< 0.5 to 5: light = encoded ^ gamma
  std::array<float, 4> blendPx = {0, 0, 0, 0};  ///< ramps at the left, right, bottom, top edge; 0: none
  std::optional<Warp> warp = {};                ///< absent: the picture as it is
};

/// How a pose tells where its leaf is.
enum class PoseForm : std::uint8_t {
  Kept = 0,    ///< where it was; only its shape changes
  Matrix = 1,  ///< by `localToWorld`
  Steps = 2,   ///< by `steps` from the matrix of the leaf's record
};

/// The largest count of steps, up to which a double holds every whole number.
inline constexpr std::int64_t kMaxPoseSteps = std::int64_t{1} << 53;
inline constexpr std::size_t kMaxPoseJoints = 4096, kMaxPoseWeights = 4096;

/// A matrix as its difference from another one: entry (row, column) differs by counts[3 * column + row] times
/// 2^exponents[column]. The last row is that of an affine map.
struct PoseSteps {
  std::array<std::int8_t, 4> exponents = {0, 0, 0, 0};
  std::array<std::int64_t, 12> counts = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  friend bool operator==(const PoseSteps&, const PoseSteps&) = default;
};

/// Where a leaf is from now on, and in which shape.
struct Pose {
  std::uint32_t id = 0;  ///< of a leaf whose record the tile has
  PoseForm form = PoseForm::Kept;
  Mat4 localToWorld = Mat4::Identity();  ///< of Matrix; affine
  PoseSteps steps = {};                  ///< of Steps
  std::vector<float> joints = {};   ///< 12 for each joint of the leaf's skin, by column: from the mesh to the
                                    ///< leaf's local coordinates; empty: as they were
  std::vector<float> weights = {};  ///< of the leaf's morph targets; empty: as they were
  friend bool operator==(const Pose&, const Pose&) = default;
};

/// Master to tile: what has moved since the last frame, of the leaves whose records the tile has. Holds from
/// the next Frame on. Ids ascend; a pose changes something.
struct Poses {
  std::vector<Pose> poses = {};
  friend bool operator==(const Poses&, const Poses&) = default;
};

}  // namespace tessera::proto
