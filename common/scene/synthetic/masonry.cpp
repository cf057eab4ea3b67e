#include "common/scene/synthetic/masonry.h"

#include <algorithm>
#include <cmath>

#include "common/scene/synthetic/curve.h"

namespace tessera::synthetic {
namespace {

/// A pointed arch is two circles whose centres lie this share of the half-width beyond the middle.
constexpr double kArchOffset = 0.4;
/// acos(kArchOffset / (1 + kArchOffset)): from the springing to the apex.
constexpr double kArchRad = 1.2810446253588492;

std::uint32_t piecesOf(const ArchBay& bay, const Detail& detail) {
  const double pieces =
      4 * detail.level * std::sqrt(bay.openingWidthM) + detail.dither - 0.5;  // of half an arch
  return static_cast<std::uint32_t>(std::max(pieces, 3.0));
}

/// The arch from its left springing over the apex to the right; normals point into the opening. The apex
/// comes twice, once for each side.
std::vector<CurvePoint> archOf(const ArchBay& bay, std::uint32_t half) {
  const double halfWidthM = bay.openingWidthM / 2;
  const double radiusM = halfWidthM * (1 + kArchOffset);
  const double apexM = halfWidthM * std::sqrt(1 + 2 * kArchOffset);
  const double stretch = bay.riseM / apexM;
  std::vector<CurvePoint> right(half + 1);
  for (std::uint32_t i = 0; i <= half; ++i) {
    const SinCos a = sinCos(kArchRad * i / half);
    const double x = i == half ? 0 : radiusM * a.cos - halfWidthM * kArchOffset;
    const double y = bay.springM + (i == half ? bay.riseM : radiusM * a.sin * stretch);
    right[i] = {{x, y}, Vec2(-a.cos * stretch, -a.sin).normalized()};
  }
  std::vector<CurvePoint> all;
  all.reserve(2 * right.size());
  for (const CurvePoint& p : right) {
    all.push_back({{-p.position.x(), p.position.y()}, {-p.normal.x(), p.normal.y()}});
  }
  all.insert(all.end(), right.rbegin(), right.rend());
  return all;
}

/// A rectangle parallel to x-y that faces +z or -z.
void facade(double x0, double x1, double y0, double y1, double z, MeshWriter& out) {
  if (z > 0) {
    out.quad({Vec3(x0, y0, z), Vec3(x1, y0, z), Vec3(x1, y1, z), Vec3(x0, y1, z)}, Vec3::UnitZ());
  } else {
    out.quad({Vec3(x1, y0, z), Vec3(x0, y0, z), Vec3(x0, y1, z), Vec3(x1, y1, z)}, -Vec3::UnitZ());
  }
}

/// A rectangle parallel to y-z that faces +x or -x.
void cheek(double x, double y0, double y1, double halfDepthM, bool toPlusX, MeshWriter& out) {
  const double z = toPlusX ? halfDepthM : -halfDepthM;
  out.quad({Vec3(x, y0, z), Vec3(x, y0, -z), Vec3(x, y1, -z), Vec3(x, y1, z)},
           toPlusX ? Vec3::UnitX() : Vec3(-Vec3::UnitX()));
}

void emitFace(const ArchBay& bay, const std::vector<CurvePoint>& arch, double z, MeshWriter& out) {
  const double halfWidthM = bay.widthM / 2;
  const double halfOpeningM = bay.openingWidthM / 2;
  // Split at the springing, where the arch has a vertex: no crack can open there.
  for (const auto& [y0, y1] : {std::pair(0.0, bay.springM), std::pair(bay.springM, bay.heightM)}) {
    facade(-halfWidthM, -halfOpeningM, y0, y1, z, out);
    facade(halfOpeningM, halfWidthM, y0, y1, z, out);
  }
  const Vec3 normal = z > 0 ? Vec3::UnitZ() : Vec3(-Vec3::UnitZ());
  for (std::size_t i = 0; i + 1 < arch.size(); ++i) {
    const Vec2& a = arch[i].position;
    const Vec2& b = arch[i + 1].position;
    if (a == b) continue;
    const Vec3 lowA(a.x(), a.y(), z);
    const Vec3 lowB(b.x(), b.y(), z);
    const Vec3 highA(a.x(), bay.heightM, z);
    const Vec3 highB(b.x(), bay.heightM, z);
    z > 0 ? out.quad({lowA, lowB, highB, highA}, normal) : out.quad({lowB, lowA, highA, highB}, normal);
  }
}

void emitSoffit(const std::vector<CurvePoint>& arch, double halfDepthM, MeshWriter& out) {
  for (std::size_t i = 0; i + 1 < arch.size(); ++i) {
    const CurvePoint& a = arch[i];
    const CurvePoint& b = arch[i + 1];
    if (a.position == b.position) continue;
    const auto corner = [&](const CurvePoint& p, double z) {
      return out.vertex({p.position.x(), p.position.y(), z}, {p.normal.x(), p.normal.y(), 0});
    };
    const std::uint32_t first = corner(a, halfDepthM);
    corner(a, -halfDepthM);
    corner(b, -halfDepthM);
    corner(b, halfDepthM);
    out.quad(first, first + 1, first + 2, first + 3);
  }
}

/// Segments of a jali's hole: a multiple of 4, so that the square's corners are among the points.
std::uint32_t segmentsOf(const Jali& jali, const Detail& detail) {
  const double quarters = 7 * detail.level * std::sqrt(jali.cellM) + detail.dither - 0.5;
  return 4 * static_cast<std::uint32_t>(std::max(quarters, 1.0));
}

void emitCell(const Jali& jali, const Vec2& center, std::uint32_t segments, MeshWriter& out) {
  const double halfCellM = jali.cellM / 2;
  const double z = jali.thicknessM / 2;
  for (std::uint32_t i = 0; i < segments; ++i) {
    std::array<Vec2, 2> rim;
    std::array<Vec2, 2> hole;
    std::array<Vec2, 2> direction;
    for (std::uint32_t k = 0; k < 2; ++k) {
      const SinCos a = sinCos(kPi / 4 + 2 * kPi * ((i + k) % segments) / segments);
      direction[k] = {a.cos, a.sin};
      rim[k] = center + direction[k] * (halfCellM / std::max(std::abs(a.cos), std::abs(a.sin)));
      hole[k] = center + direction[k] * (halfCellM * jali.holeRatio);
    }
    const auto lift = [](const Vec2& p, double height) { return Vec3(p.x(), p.y(), height); };
    out.quad({lift(hole[0], z), lift(rim[0], z), lift(rim[1], z), lift(hole[1], z)}, Vec3::UnitZ());
    out.quad({lift(rim[0], -z), lift(hole[0], -z), lift(hole[1], -z), lift(rim[1], -z)}, -Vec3::UnitZ());
    const std::uint32_t first = out.vertex(lift(hole[0], -z), lift(-direction[0], 0));
    out.vertex(lift(hole[0], z), lift(-direction[0], 0));
    out.vertex(lift(hole[1], z), lift(-direction[1], 0));
    out.vertex(lift(hole[1], -z), lift(-direction[1], 0));
    out.quad(first, first + 1, first + 2, first + 3);
  }
}

}  // namespace

std::uint64_t count(const ArchBay& bay, const Detail& detail) {
  return 12ULL * piecesOf(bay, detail) + 26;
}

void emit(const ArchBay& bay, const Detail& detail, MeshWriter& out) {
  const double halfWidthM = bay.widthM / 2;
  const double halfOpeningM = bay.openingWidthM / 2;
  const double z = bay.depthM / 2;
  const std::vector<CurvePoint> arch = archOf(bay, piecesOf(bay, detail));
  emitFace(bay, arch, z, out);
  emitFace(bay, arch, -z, out);
  emitSoffit(arch, z, out);
  cheek(-halfOpeningM, 0, bay.springM, z, true, out);
  cheek(halfOpeningM, 0, bay.springM, z, false, out);
  cheek(-halfWidthM, 0, bay.heightM, z, false, out);
  cheek(halfWidthM, 0, bay.heightM, z, true, out);
  out.quad({Vec3(-halfWidthM, bay.heightM, z), Vec3(halfWidthM, bay.heightM, z),
            Vec3(halfWidthM, bay.heightM, -z), Vec3(-halfWidthM, bay.heightM, -z)},
           Vec3::UnitY());
}

std::uint64_t count(const Jali& jali, const Detail& detail) {
  return 6ULL * segmentsOf(jali, detail) * jali.columns * jali.rows + 8;
}

void emit(const Jali& jali, const Detail& detail, MeshWriter& out) {
  const std::uint32_t segments = segmentsOf(jali, detail);
  for (std::uint32_t row = 0; row < jali.rows; ++row) {
    for (std::uint32_t column = 0; column < jali.columns; ++column) {
      emitCell(jali, jali.cellM * Vec2(column + 0.5, row + 0.5), segments, out);
    }
  }
  const double x = jali.cellM * jali.columns;
  const double y = jali.cellM * jali.rows;
  const double z = jali.thicknessM / 2;
  cheek(0, 0, y, z, false, out);
  cheek(x, 0, y, z, true, out);
  out.quad({Vec3(0, y, z), Vec3(x, y, z), Vec3(x, y, -z), Vec3(0, y, -z)}, Vec3::UnitY());
  out.quad({Vec3(0, 0, -z), Vec3(x, 0, -z), Vec3(x, 0, z), Vec3(0, 0, z)}, -Vec3::UnitY());
}

std::uint64_t count(const Stairs& stairs, const Detail& /*detail*/) {
  return 8ULL * stairs.stepCount + 2;
}

void emit(const Stairs& stairs, const Detail& /*detail*/, MeshWriter& out) {
  const double z = stairs.widthM / 2;
  for (std::uint32_t i = 0; i < stairs.stepCount; ++i) {
    const double x0 = stairs.goingM * i;
    const double x1 = stairs.goingM * (i + 1);
    const double y1 = stairs.riseM * (i + 1);
    cheek(x0, stairs.riseM * i, y1, z, false, out);
    out.quad({Vec3(x0, y1, z), Vec3(x1, y1, z), Vec3(x1, y1, -z), Vec3(x0, y1, -z)}, Vec3::UnitY());
    facade(x0, x1, 0, y1, z, out);
    facade(x0, x1, 0, y1, -z, out);
  }
  cheek(stairs.goingM * stairs.stepCount, 0, stairs.riseM * stairs.stepCount, z, true, out);
}

}  // namespace tessera::synthetic
