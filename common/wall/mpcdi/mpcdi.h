#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/geometry/vec.h"

namespace tessera {

/// What an MPCDI archive is for. VESA's "Multiple Projection Common Data Interchange", versions 1 and 2.
enum class MpcdiProfile : std::uint8_t {
  Media2d,     ///< "2d": a flat picture, the buffer, shared among projectors
  Simulation,  ///< "3d": every projector shows a frustum of one eye
  Advanced3d,  ///< "a3": the surface's shape is known, the eye may move
  ShaderLamps  ///< "sl": objects are painted with light
};

/// Degrees. The projector's, or eye's, view is turned to the right by yaw, then up by pitch, then clockwise
/// by roll. The angles to the picture's edges are signed: left and down are negative where the axis lies
/// inside.
struct MpcdiFrustum {
  double yawDeg = 0, pitchDeg = 0, rollDeg = 0;
  double leftDeg = 0, rightDeg = 0, downDeg = 0, upDeg = 0;
};

/// Where a projector stands and which way the axes of its coordinates point, as the archive says it.
struct MpcdiFrame {
  Vec3 position = Vec3::Zero();
  Vec3 yawAxis = Vec3(0, -1, 0), pitchAxis = Vec3(1, 0, 0), rollAxis = Vec3(0, 0, -1);
};

/// Where each sample of the projector's picture comes from. Samples are in the middle of equal cells of the
/// picture: sample (column, row) of W x H stands at ((column + 0.5) / W, (row + 0.5) / H) of it.
struct MpcdiWarp {
  std::int32_t columns = 0, rows = 0;
  /// Three floats a sample, row by row from the picture's top. Profiles 2d and 3d: u from the left and v from
  /// the bottom of the region, 0..1, and a value that has no meaning. Profiles a3 and sl: a point in space,
  /// metres. NaN: the sample shows nothing.
  std::vector<float> xyz;
  bool isInSpace = false;  ///< the samples are points in space
  /// a3 and sl: the points are relative to the ideal eye, to the middle of the floor or to the centre of
  /// mass.
  enum class Origin : std::uint8_t {
    Unknown,
    IdealEyePoint,
    FloorCenter,
    CenterOfMass
  } origin = Origin::Unknown;
};

/// Grey values, rows from the top; 65535 is full.
struct MpcdiMap {
  std::int32_t widthPx = 0, heightPx = 0;
  std::vector<std::uint16_t> values;
  double gammaEmbedded = 1;  ///< factor of light = (value / 65535) ^ gammaEmbedded
  [[nodiscard]] bool isEmpty() const { return values.empty(); }
};

/// One projector.
struct MpcdiRegion {
  std::string buffer, id;  ///< ids differ over the whole archive
  std::int32_t widthPx = 0, heightPx = 0;
  /// Its rectangle in the buffer: x from the left, y from the bottom (to the rectangle's lower edge), 0..1.
  double x = 0, y = 0, width = 1, height = 1;
  std::optional<MpcdiFrustum> frustum;
  std::optional<MpcdiFrame> frame;
  std::optional<MpcdiWarp> warp;
  MpcdiMap alpha, beta;  ///< may be empty
};

struct MpcdiBuffer {
  std::string id;
  std::int32_t widthPx = 0, heightPx = 0;  ///< 0: not said
};

struct Mpcdi {
  MpcdiProfile profile = MpcdiProfile::Media2d;
  std::string version;  ///< as it stands, "1.0"
  std::vector<MpcdiBuffer> buffers;
  std::vector<MpcdiRegion> regions;
  std::vector<std::string> warnings;  ///< one line for each kind of thing that was not read
};

inline constexpr std::int32_t kMaxMpcdiSidePx = 16384;
inline constexpr std::int64_t kMaxMpcdiMapSamples = std::int64_t{1} << 25;  ///< a map of 8K has fewer
inline constexpr std::int64_t kMaxMpcdiBytes = std::int64_t{1} << 30;  ///< of all maps together, unpacked
inline constexpr std::size_t kMaxMpcdiRegions = 256;
inline constexpr std::size_t kMaxMpcdiEntries = 4096;  ///< files in the archive
inline constexpr std::int64_t kMaxMpcdiXmlBytes = std::int64_t{1} << 20;

/// Reads a .mpcdi archive whole. The error names the archive and the file in it. Nothing is unpacked to disk,
/// and nothing is allocated for sizes that the archive only claims. With `onlyRegion`, the maps of that
/// region alone are read, and it is an error if it is not there.
[[nodiscard]] Result<Mpcdi> readMpcdi(const std::filesystem::path& path,
                                      std::optional<std::string> onlyRegion = std::nullopt);

}  // namespace tessera
