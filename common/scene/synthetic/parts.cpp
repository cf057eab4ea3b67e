#include "common/scene/synthetic/parts.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tessera::synthetic {
namespace {

/// The frame whose z axis runs along `direction` and whose y axis is as upright as can be.
Placement alongZ(const Vec3& origin, const Vec3& direction) {
  const Vec3 up = std::abs(direction.y()) > 0.99 ? Vec3::UnitZ() : Vec3::UnitY();
  const Vec3 x = up.cross(direction).normalized();
  return at(origin, fromAxes(x, direction.cross(x)));
}

std::uint32_t spacesFor(double lengthM, double spacingM) {
  return static_cast<std::uint32_t>(std::max(1.0, std::floor(lengthM / spacingM + 0.5)));
}

}  // namespace

Part box(const Vec3& min, const Vec3& max) {
  return {.shape = Box{min, max}, .placement = {}, .repeat = {}};
}

Part blockOn(const Vec3& base, const Vec3& size) {
  const Vec3 half(size.x() / 2, 0, size.z() / 2);
  return box(base - half, base + half + Vec3(0, size.y(), 0));
}

std::vector<Curve> polyline(const std::vector<Vec2>& points) {
  std::vector<Curve> curves;
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    curves.push_back(line(points[i], points[i + 1]));
  return curves;
}

std::vector<Curve> polygon(const std::vector<Vec2>& corners) {
  std::vector<Curve> curves = polyline(corners);
  curves.push_back(line(corners.back(), corners.front()));
  return curves;
}

Part turned(const Vec3& base, std::vector<Curve> profile, const Vec3& axis) {
  return {.shape = Lathe{std::move(profile)}, .placement = at(base, yTo(axis)), .repeat = {}};
}

Part tube(const Vec3& from, const Vec3& to, double radiusM) {
  const double lengthM = (to - from).norm();
  return turned(from, {line({radiusM, 0}, {radiusM, lengthM})}, (to - from) / lengthM);
}

Part rod(const Vec3& from, const Vec3& to, double radiusM) {
  const double lengthM = (to - from).norm();
  return turned(from, polyline({{0, 0}, {radiusM, 0}, {radiusM, lengthM}, {0, lengthM}}),
                (to - from) / lengthM);
}

Part vessel(const Vec3& from, const Vec3& to, double radiusM, double endM) {
  const double lengthM = (to - from).norm();
  return turned(from,
                {arc({0, 0}, {radiusM, endM}, -kPi / 2, 0), line({radiusM, 0}, {radiusM, lengthM}),
                 arc({0, lengthM}, {radiusM, endM}, 0, kPi / 2)},
                (to - from) / lengthM);
}

Part ring(const Vec3& center, double ringRadiusM, double barRadiusM, const Vec3& axis) {
  return turned(center, {arc({ringRadiusM, 0}, {barRadiusM, barRadiusM}, -kPi, kPi)}, axis);
}

Part collar(const Vec3& base, double innerM, double outerM, double thickM, const Vec3& axis) {
  return turned(base, polyline({{innerM, 0}, {outerM, 0}, {outerM, thickM}, {innerM, thickM}}), axis);
}

Part beam(const Vec3& from, const Vec3& to, double depthM, double widthM) {
  const double lengthM = (to - from).norm();
  return {.shape = HBeam{.widthM = widthM, .depthM = depthM, .lengthM = lengthM},
          .placement = alongZ(from, (to - from) / lengthM),
          .repeat = {}};
}

Part bar(const Vec3& from, const Vec3& to, double widthM) {
  const double lengthM = (to - from).norm();
  const double w = widthM / 2;
  std::vector<Curve> outline = polygon({{-w, -w}, {w, -w}, {w, w}, {-w, w}});
  return {.shape = Extrusion{.outline = std::move(outline), .depthM = lengthM, .capped = false},
          .placement = alongZ(from, (to - from) / lengthM),
          .repeat = {}};
}

Part prism(const std::vector<Vec2>& corners, double depthM, const Placement& placement) {
  return {.shape = Extrusion{.outline = polygon(corners), .depthM = depthM},
          .placement = placement,
          .repeat = {}};
}

Part repeated(Part part, std::uint32_t count, const Vec3& stepM) {
  part.repeat = {.count = count, .stepM = stepM};
  return part;
}

Part around(Part part, std::uint32_t count, double fullRad) {
  part.repeat = {.count = count, .stepM = Vec3::Zero(), .turnRad = fullRad / count};
  return part;
}

Part exactly(Part part) {
  part.repeat.exact = true;
  return part;
}

Part fromLevel(Part part, double minLevel) {
  part.minLevel = minLevel;
  return part;
}

Part belowLevel(Part part, double maxLevel) {
  part.maxLevel = maxLevel;
  return part;
}

void append(Parts& parts, Parts more) {
  parts.insert(parts.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

Parts joined(std::initializer_list<Parts> all) {
  Parts parts;
  for (const Parts& some : all)
    parts.insert(parts.end(), some.begin(), some.end());
  return parts;
}

Parts railing(const Vec3& from, const Vec3& to) {
  constexpr double kHeightM = 1.1;
  const Vec3 along = to - from;
  const std::uint32_t spaces = spacesFor(along.norm(), 2.2);
  const Vec3 top(0, kHeightM, 0);
  const Vec3 middle(0, kHeightM / 2, 0);
  const Vec3 toe(0, 0.08, 0);
  return {tube(from + top, to + top, 0.025), fromLevel(tube(from + middle, to + middle, 0.02), 0.2),
          fromLevel(bar(from + toe, to + toe, 0.08), 1.6),
          repeated(tube(from, from + top, 0.024), spaces + 1, along / spaces)};
}

Parts roundRailing(double radiusM, double heightM) {
  constexpr double kHeightM = 1.1;
  const std::uint32_t posts = std::max(9U, spacesFor(2 * kPi * radiusM, 3.2));
  const auto rail = [&](double y, double widthM) {
    return exactly(
        around(bar(onCircle(radiusM, 0, y), onCircle(radiusM, 2 * kPi / posts, y), widthM), posts));
  };
  return {rail(heightM + kHeightM, 0.05), rail(heightM + kHeightM / 2, 0.04),
          around(tube({radiusM, heightM, 0}, {radiusM, heightM + kHeightM, 0}, 0.03), posts)};
}

namespace {

/// Rungs and hoops of a ladder; coarse scenes make do with every third.
Parts ladderPieces(double heightM, double spacingFactor) {
  constexpr double kCageStartM = 2.5;
  const double rungM = 0.3 * spacingFactor;
  Parts parts = {repeated(tube({-0.25, rungM, 0}, {0.25, rungM, 0}, 0.015),
                          static_cast<std::uint32_t>(heightM / rungM), {0, rungM, 0})};
  if (heightM <= kCageStartM + 1) return parts;
  const std::uint32_t hoops = spacesFor(heightM + 1 - kCageStartM, 1.2 * spacingFactor);
  const Vec3 step(0, (heightM + 1 - kCageStartM) / hoops, 0);
  // A hoop of five flat bars around the climber.
  const std::array<Vec2, 6> corners = {Vec2(-0.25, 0), Vec2(-0.38, 0.35), Vec2(-0.2, 0.7),
                                       Vec2(0.2, 0.7), Vec2(0.38, 0.35),  Vec2(0.25, 0)};
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Vec3 from(corners[i].x(), kCageStartM, corners[i].y());
    const Vec3 to(corners[i + 1].x(), kCageStartM, corners[i + 1].y());
    parts.push_back(repeated(bar(from, to, 0.04), hoops + 1, step));
    if (i > 0) parts.push_back(bar(from, {from.x(), heightM + 1, from.z()}, 0.03));
  }
  return parts;
}

}  // namespace

Parts cagedLadder(double heightM) {
  constexpr double kFineLevel = 2.5;
  Parts parts = {bar({-0.25, 0, 0}, {-0.25, heightM + 1, 0}, 0.06),
                 bar({0.25, 0, 0}, {0.25, heightM + 1, 0}, 0.06)};
  for (const Part& part : ladderPieces(heightM, 3))
    parts.push_back(belowLevel(part, kFineLevel));
  for (const Part& part : ladderPieces(heightM, 1))
    parts.push_back(fromLevel(part, kFineLevel));
  return parts;
}

Parts grating(const Vec2& sizeM) {
  constexpr double kBarM = 0.05;
  const double x = sizeM.x();
  const double z = sizeM.y();
  const auto rim = [](const Vec3& min, const Vec3& max) { return fromLevel(box(min, max), 1.5); };
  return {box({0, -0.04, 0}, {x, 0, z}),
          fromLevel(repeated(box({0, 0, 0}, {0.02, 0.012, z}), spacesFor(x, 0.25), {0.25, 0, 0}), 3),
          rim({0, -0.2, 0}, {x, 0.015, kBarM}),
          rim({0, -0.2, z - kBarM}, {x, 0.015, z}),
          rim({0, -0.2, kBarM}, {kBarM, 0.015, z - kBarM}),
          rim({x - kBarM, -0.2, kBarM}, {x, 0.015, z - kBarM})};
}

Parts steelStairs(double runM, double riseM, double widthM) {
  const std::uint32_t steps = spacesFor(riseM, 0.2);
  const double w = widthM / 2;
  const Vec3 step(runM / steps, riseM / steps, 0);
  Parts parts = {repeated(box({0, step.y() - 0.04, -w}, {0.26, step.y(), w}), steps, step)};
  for (const double z : {-w, w}) {
    parts.push_back(
        prism({{0, -0.15}, {runM, riseM - 0.15}, {runM, riseM + 0.1}, {0, 0.1}}, 0.04, at(0, 0, z - 0.02)));
    append(parts, railing({0, 0.1, z}, {runM, riseM + 0.1, z}));
  }
  return parts;
}

}  // namespace tessera::synthetic
