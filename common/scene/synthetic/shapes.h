#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "common/scene/synthetic/mesh.h"
#include "common/scene/synthetic/placement.h"

namespace tessera::synthetic {

using Vec2 = Eigen::Vector2d;

/// How finely to tessellate. Level 1 is about the coarsest that looks well; segment counts grow about
/// linearly with it. The dither, in [0, 1), differs from part to part, so that the triangle count of a
/// whole scene follows the level almost continuously.
struct Detail {
  double level = 1;
  double dither = 0;
};

/// One piece of a plane outline. Walking along it, the outside is on the right.
struct Curve {
  enum class Kind : std::uint8_t { Line, Arc, Hyperbola };
  Kind kind = Kind::Line;
  Vec2 from = Vec2::Zero();    ///< Line: first point. Arc: centre. Hyperbola: waist radius, waist height
  Vec2 to = Vec2::Zero();      ///< Line: last point. Arc: half-axes. Hyperbola: slope length, unused
  double start = 0, stop = 1;  ///< Arc: angles. Hyperbola: heights. Line: unused
};

[[nodiscard]] inline Curve line(const Vec2& from, const Vec2& to) {
  return {.from = from, .to = to};
}
[[nodiscard]] Curve arc(const Vec2& center, const Vec2& halfAxes, double startRad, double stopRad);
/// radius(y) = waist * sqrt(1 + ((y - waistHeight) / slopeLength)^2), from one height to another.
[[nodiscard]] Curve hyperbola(const Vec2& waist, double slopeLengthM, double startY, double stopY);

/// Axis-aligned box.
struct Box {
  Vec3 min = Vec3::Zero();
  Vec3 max = Vec3::Zero();
};

/// Surface of revolution about the y axis. A profile point (x, y) is (radius, height); a profile that
/// goes up has its outside away from the axis.
struct Lathe {
  std::vector<Curve> profile;
};

/// Quarter (or so) of a torus. Enters at the origin along +y and bends towards +x.
struct Elbow {
  double pipeRadiusM = 0.1;
  double bendRadiusM = 0.2;
  double angleRad = kPi / 2;
};

/// Closed outline in x-y, counter-clockwise from +z, extruded from z = 0 to z = depth. No three corners
/// on one line.
struct Extrusion {
  std::vector<Curve> outline;
  double depthM = 1;
  bool capped = true;
};

/// H section along z from the origin, open at both ends, web in the y-z plane. Coarse scenes get a box.
struct HBeam {
  double widthM = 0.2, depthM = 0.4, lengthM = 1;
};

/// A wall bay with one pointed-arch opening: x in [-width/2, width/2], z in [-depth/2, depth/2], y from 0.
struct ArchBay {
  double widthM = 3, heightM = 4, depthM = 0.6;
  double openingWidthM = 2;
  double springM = 2;  ///< height at which the arch begins
  double riseM = 1.2;  ///< from there to the apex
};

/// Pierced stone screen (jali) of square cells with round holes; x-y plane, lower left corner at the
/// origin, z in [-thickness/2, thickness/2].
struct Jali {
  double cellM = 0.2;
  std::uint32_t columns = 4, rows = 6;
  double thicknessM = 0.05;
  double holeRatio = 0.75;  ///< hole diameter to cell width
};

/// Solid stairs that climb along +x; z in [-width/2, width/2].
struct Stairs {
  double widthM = 1;
  std::uint32_t stepCount = 10;
  double riseM = 0.18, goingM = 0.28;
};

using Shape = std::variant<Box, Lathe, Elbow, Extrusion, HBeam, ArchBay, Jali, Stairs>;

/// Copies of a part: copy i is shifted by i * step and then turned by i * turn about the leaf's y axis.
/// Coarse scenes make do with fewer copies over the same stretch, unless `exact`.
struct Repeat {
  std::uint32_t count = 1;
  Vec3 stepM = Vec3::Zero();
  double turnRad = 0;
  bool exact = false;
};

/// A shape where it belongs in its leaf.
struct Part {
  Shape shape;
  Placement placement;  ///< without scale
  Repeat repeat;
  double minLevel = 0;    ///< left out of coarser scenes: bolts and the like
  double maxLevel = 1e9;  ///< left out of finer scenes: stand-ins for parts with a minLevel
};

[[nodiscard]] std::uint64_t triangleCount(const Part& part, const Detail& detail);
/// Appends exactly triangleCount(part, detail) triangles.
void build(const Part& part, const Detail& detail, Mesh& mesh);

/// Triangulates a simple counter-clockwise polygon by ear clipping: points.size() - 2 triangles.
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> triangulate(const std::vector<Vec2>& points);

}  // namespace tessera::synthetic
