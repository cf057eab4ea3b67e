#include "common/scene/synthetic/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/scene/synthetic/curve.h"
#include "common/scene/synthetic/masonry.h"

namespace tessera::synthetic {
namespace {

constexpr std::uint64_t kBoxTriangles = 12;

std::uint32_t segmentsOf(const Lathe& lathe, const Detail& detail) {
  double radiusM = 0;
  for (const Curve& curve : lathe.profile)
    radiusM = std::max(radiusM, largestX(curve));
  return segmentsAround(radiusM, detail);
}

std::uint32_t ringsOf(const Curve& curve, std::uint32_t around, const Detail& detail) {
  if (curve.kind == Curve::Kind::Arc) return piecesOfArc(curve.stop - curve.start, around);
  if (curve.kind == Curve::Kind::Hyperbola) return std::max(4U, around / 8);
  // Flat discs gain nothing from rings.
  if (std::abs(curve.to.y() - curve.from.y()) < 1e-9) return 1;
  return ringsAlong(lengthOf(curve), largestX(curve), detail);
}

bool onAxis(const CurvePoint& p) {
  return p.position.x() == 0;
}

bool startsOnAxis(const Curve& curve) {
  return curve.kind == Curve::Kind::Line ? curve.from.x() == 0 : onAxis(evaluate(curve, 0));
}

bool endsOnAxis(const Curve& curve) {
  return curve.kind == Curve::Kind::Line ? curve.to.x() == 0 : onAxis(evaluate(curve, 1));
}

std::uint64_t count(const Box& /*box*/, const Detail& /*detail*/) {
  return kBoxTriangles;
}

std::uint64_t count(const Lathe& lathe, const Detail& detail) {
  const std::uint32_t around = segmentsOf(lathe, detail);
  std::uint64_t perSegment = 0;
  for (const Curve& curve : lathe.profile) {
    perSegment += 2ULL * ringsOf(curve, around, detail);
    if (startsOnAxis(curve)) --perSegment;
    if (endsOnAxis(curve)) --perSegment;
  }
  return perSegment * around;
}

std::uint64_t count(const Elbow& elbow, const Detail& detail) {
  const std::uint32_t around = segmentsAround(elbow.pipeRadiusM, detail);
  return 2ULL * around * piecesOfArc(elbow.angleRad, std::max(8U, around));
}

std::uint32_t piecesOf(const Curve& curve, const Detail& detail) {
  if (curve.kind == Curve::Kind::Line) return 1;
  return piecesOfArc(curve.stop - curve.start, std::max(8U, segmentsAround(curve.to.maxCoeff(), detail)));
}

std::uint64_t count(const Extrusion& extrusion, const Detail& detail) {
  std::uint64_t sides = 0;
  for (const Curve& curve : extrusion.outline)
    sides += piecesOf(curve, detail);
  return 2 * sides + (extrusion.capped ? 2 * (sides - 2) : 0);
}

bool isPlainBox(const Detail& detail) {
  return detail.level < 0.6 * (1 + detail.dither);
}

/// The corners of the section, counter-clockwise from +z.
std::vector<Vec2> sectionOf(const HBeam& beam, const Detail& detail) {
  const double x = beam.widthM / 2;
  const double y = beam.depthM / 2;
  if (isPlainBox(detail)) return {{-x, -y}, {x, -y}, {x, y}, {-x, y}};
  const double web = beam.widthM / 24;
  const double inner = y - beam.depthM / 14;
  return {{-x, -y}, {x, -y}, {x, -inner}, {web, -inner}, {web, inner},   {x, inner},
          {x, y},   {-x, y}, {-x, inner}, {-web, inner}, {-web, -inner}, {-x, -inner}};
}

std::uint64_t count(const HBeam& /*beam*/, const Detail& detail) {
  return isPlainBox(detail) ? 8 : 24;
}

void emit(const Box& box, const Detail& /*detail*/, MeshWriter& out) {
  const Vec3& a = box.min;
  const Vec3& b = box.max;
  out.quad({Vec3(b.x(), a.y(), b.z()), Vec3(b.x(), a.y(), a.z()), Vec3(b.x(), b.y(), a.z()), b},
           Vec3::UnitX());
  out.quad({a, Vec3(a.x(), a.y(), b.z()), Vec3(a.x(), b.y(), b.z()), Vec3(a.x(), b.y(), a.z())},
           -Vec3::UnitX());
  out.quad({Vec3(a.x(), b.y(), b.z()), b, Vec3(b.x(), b.y(), a.z()), Vec3(a.x(), b.y(), a.z())},
           Vec3::UnitY());
  out.quad({a, Vec3(b.x(), a.y(), a.z()), Vec3(b.x(), a.y(), b.z()), Vec3(a.x(), a.y(), b.z())},
           -Vec3::UnitY());
  out.quad({Vec3(a.x(), a.y(), b.z()), Vec3(b.x(), a.y(), b.z()), b, Vec3(a.x(), b.y(), b.z())},
           Vec3::UnitZ());
  out.quad({Vec3(b.x(), a.y(), a.z()), a, Vec3(a.x(), b.y(), a.z()), Vec3(b.x(), b.y(), a.z())},
           -Vec3::UnitZ());
}

/// Joins two rows of `around` + 1 vertices that start at `low` and `high`.
void joinRows(std::uint32_t low, std::uint32_t high, std::uint32_t around, bool lowPole, bool highPole,
              MeshWriter& out) {
  for (std::uint32_t j = 0; j < around; ++j) {
    if (!highPole) out.triangle(low + j, high + j + 1, high + j);
    if (!lowPole) out.triangle(low + j, low + j + 1, high + j + 1);
  }
}

void emitCurve(const Curve& curve, std::uint32_t rings, const std::vector<SinCos>& angles, MeshWriter& out) {
  const auto around = static_cast<std::uint32_t>(angles.size() - 1);
  std::uint32_t previous = 0;
  for (std::uint32_t i = 0; i <= rings; ++i) {
    const CurvePoint p = evaluate(curve, static_cast<double>(i) / rings);
    std::uint32_t row = 0;
    for (std::uint32_t j = 0; j <= around; ++j) {
      const SinCos& a = angles[j];
      const std::uint32_t v = out.vertex({p.position.x() * a.cos, p.position.y(), -p.position.x() * a.sin},
                                         {p.normal.x() * a.cos, p.normal.y(), -p.normal.x() * a.sin});
      if (j == 0) row = v;
    }
    if (i > 0) {
      const bool lowPole = i == 1 && startsOnAxis(curve);
      joinRows(previous, row, around, lowPole, i == rings && onAxis(p), out);
    }
    previous = row;
  }
}

/// The unit circle; the last point is exactly the first, so that seams close.
std::vector<SinCos> circle(std::uint32_t around) {
  std::vector<SinCos> angles;
  angles.reserve(around + 1);
  for (std::uint32_t j = 0; j < around; ++j)
    angles.push_back(sinCos(2 * kPi * j / around));
  angles.push_back(angles.front());
  return angles;
}

void emit(const Lathe& lathe, const Detail& detail, MeshWriter& out) {
  const std::uint32_t around = segmentsOf(lathe, detail);
  const std::vector<SinCos> angles = circle(around);
  for (const Curve& curve : lathe.profile)
    emitCurve(curve, ringsOf(curve, around, detail), angles, out);
}

void emit(const Elbow& elbow, const Detail& detail, MeshWriter& out) {
  const std::uint32_t around = segmentsAround(elbow.pipeRadiusM, detail);
  const std::uint32_t rings = piecesOfArc(elbow.angleRad, std::max(8U, around));
  const std::vector<SinCos> angles = circle(around);
  std::uint32_t previous = 0;
  for (std::uint32_t i = 0; i <= rings; ++i) {
    const SinCos bend = sinCos(elbow.angleRad * i / rings);
    const Vec3 away(-bend.cos, bend.sin, 0);
    const Vec3 center = elbow.bendRadiusM * (Vec3::UnitX() + away);
    std::uint32_t row = 0;
    for (std::uint32_t j = 0; j <= around; ++j) {
      const Vec3 normal = away * angles[j].cos + Vec3::UnitZ() * angles[j].sin;
      const std::uint32_t v = out.vertex(center + elbow.pipeRadiusM * normal, normal);
      if (j == 0) row = v;
    }
    if (i > 0) joinRows(previous, row, around, false, false, out);
    previous = row;
  }
}

void emitSide(const Curve& curve, std::uint32_t pieces, double depthM, std::vector<Vec2>& outline,
              MeshWriter& out) {
  std::uint32_t previous = 0;
  for (std::uint32_t i = 0; i <= pieces; ++i) {
    const CurvePoint p = evaluate(curve, static_cast<double>(i) / pieces);
    if (i < pieces) outline.push_back(p.position);
    const Vec3 normal(p.normal.x(), p.normal.y(), 0);
    const std::uint32_t near = out.vertex({p.position.x(), p.position.y(), 0}, normal);
    out.vertex({p.position.x(), p.position.y(), depthM}, normal);
    if (i > 0) out.quad(previous, near, near + 1, previous + 1);
    previous = near;
  }
}

void emitCap(const std::vector<Vec2>& outline, double z, bool front, MeshWriter& out) {
  std::uint32_t first = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const std::uint32_t v =
        out.vertex({outline[i].x(), outline[i].y(), z}, front ? Vec3::UnitZ() : Vec3(-Vec3::UnitZ()));
    if (i == 0) first = v;
  }
  for (const auto& [a, b, c] : triangulate(outline)) {
    front ? out.triangle(first + a, first + b, first + c) : out.triangle(first + a, first + c, first + b);
  }
}

void emit(const Extrusion& extrusion, const Detail& detail, MeshWriter& out) {
  std::vector<Vec2> outline;
  for (const Curve& curve : extrusion.outline) {
    emitSide(curve, piecesOf(curve, detail), extrusion.depthM, outline, out);
  }
  if (!extrusion.capped) return;
  emitCap(outline, extrusion.depthM, true, out);
  emitCap(outline, 0, false, out);
}

void emit(const HBeam& beam, const Detail& detail, MeshWriter& out) {
  const std::vector<Vec2> corners = sectionOf(beam, detail);
  std::vector<Vec2> unused;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    emitSide(line(corners[i], corners[(i + 1) % corners.size()]), 1, beam.lengthM, unused, out);
  }
}

double cross(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

bool isEar(const std::vector<Vec2>& points, const std::vector<std::uint32_t>& ring, std::size_t i) {
  const std::size_t n = ring.size();
  const Vec2& a = points[ring[(i + n - 1) % n]];
  const Vec2& b = points[ring[i]];
  const Vec2& c = points[ring[(i + 1) % n]];
  if (cross(a, b, c) <= 1e-12) return false;
  for (std::size_t k = 2; k + 1 < n; ++k) {
    const Vec2& p = points[ring[(i + k) % n]];
    if (cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0) return false;
  }
  return true;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> triangulate(const std::vector<Vec2>& points) {
  std::vector<std::uint32_t> ring(points.size());
  for (std::uint32_t i = 0; i < ring.size(); ++i)
    ring[i] = i;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::size_t start = 0;
  while (ring.size() > 2) {
    const std::size_t n = ring.size();
    std::size_t ear = start % n;
    for (std::size_t k = 0; k < n; ++k) {
      if (!isEar(points, ring, (start + k) % n)) continue;
      ear = (start + k) % n;
      break;
    }
    triangles.push_back({ring[(ear + n - 1) % n], ring[ear], ring[(ear + 1) % n]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
    // Going on behind the ear instead of at it keeps fans from forming.
    start = ear + 1;
  }
  return triangles;
}

namespace {

/// The dither spreads the change; a stand-in goes only when what it stands for has surely come.
bool isLeftOut(const Part& part, const Detail& detail) {
  return detail.level < part.minLevel * (1 + 0.3 * detail.dither) || detail.level >= part.maxLevel * 1.3;
}

/// The copies that a scene of this detail gets.
Repeat thinned(const Repeat& repeat, const Detail& detail) {
  const double share = 0.15 + 0.3 * detail.level;
  if (repeat.exact || repeat.count < 4 || share >= 1) return repeat;
  // A full circle has as many gaps as copies, a row one less.
  const bool closes = std::abs(repeat.turnRad * repeat.count - 2 * kPi) < 1e-6;
  const std::uint32_t gaps = closes ? repeat.count : repeat.count - 1;
  const auto wanted = static_cast<std::uint32_t>(gaps * share + detail.dither);
  const std::uint32_t kept = std::clamp(wanted, closes ? 3U : 1U, gaps);
  const double stretch = static_cast<double>(gaps) / kept;
  return {.count = closes ? kept : kept + 1,
          .stepM = repeat.stepM * stretch,
          .turnRad = repeat.turnRad * stretch};
}

}  // namespace

std::uint64_t triangleCount(const Part& part, const Detail& detail) {
  if (isLeftOut(part, detail)) return 0;
  const auto one = std::visit([&](const auto& shape) { return count(shape, detail); }, part.shape);
  return one * thinned(part.repeat, detail).count;
}

void build(const Part& part, const Detail& detail, Mesh& mesh) {
  if (isLeftOut(part, detail)) return;
  const Repeat repeat = thinned(part.repeat, detail);
  for (std::uint32_t i = 0; i < repeat.count; ++i) {
    const Quat turn = turnY(repeat.turnRad * i);
    const Placement copy =
        at(turn * (part.placement.positionM + repeat.stepM * i), turn * part.placement.rotation);
    MeshWriter out(mesh, copy);
    std::visit([&](const auto& shape) { emit(shape, detail, out); }, part.shape);
  }
}

}  // namespace tessera::synthetic
