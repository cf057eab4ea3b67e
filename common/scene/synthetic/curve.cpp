#include "common/scene/synthetic/curve.h"

#include <algorithm>
#include <cmath>

namespace tessera::synthetic {

Curve arc(const Vec2& center, const Vec2& halfAxes, double startRad, double stopRad) {
  return {.kind = Curve::Kind::Arc, .from = center, .to = halfAxes, .start = startRad, .stop = stopRad};
}

Curve hyperbola(const Vec2& waist, double slopeLengthM, double startY, double stopY) {
  return {
      .kind = Curve::Kind::Hyperbola, .from = waist, .to = {slopeLengthM, 0}, .start = startY, .stop = stopY};
}

namespace {

CurvePoint onArc(const Curve& curve, double t) {
  const SinCos a = sinCos(curve.start + (curve.stop - curve.start) * t);
  Vec2 position = curve.from + Vec2(curve.to.x() * a.cos, curve.to.y() * a.sin);
  // A profile that ends on the axis must end exactly there, or the pole would not be seen as one.
  if (std::abs(position.x()) < 1e-9) position.x() = 0;
  const double sign = curve.stop >= curve.start ? 1 : -1;
  const Vec2 normal(curve.to.y() * a.cos * sign, curve.to.x() * a.sin * sign);
  return {position, normal.normalized()};
}

CurvePoint onHyperbola(const Curve& curve, double t) {
  const double y = curve.start + (curve.stop - curve.start) * t;
  const double u = (y - curve.from.y()) / curve.to.x();
  const double root = std::sqrt(1 + u * u);
  const double slope = curve.from.x() * u / (root * curve.to.x());
  const double sign = curve.stop >= curve.start ? 1 : -1;
  return {Vec2(curve.from.x() * root, y), Vec2(sign, -slope * sign).normalized()};
}

}  // namespace

CurvePoint evaluate(const Curve& curve, double t) {
  if (curve.kind == Curve::Kind::Arc) return onArc(curve, t);
  if (curve.kind == Curve::Kind::Hyperbola) return onHyperbola(curve, t);
  const Vec2 along = curve.to - curve.from;
  const Vec2 position = t >= 1 ? curve.to : Vec2(curve.from + along * t);
  return {position, Vec2(along.y(), -along.x()).normalized()};
}

double largestX(const Curve& curve) {
  if (curve.kind == Curve::Kind::Line) return std::max(std::abs(curve.from.x()), std::abs(curve.to.x()));
  double largest = 0;
  for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    largest = std::max(largest, std::abs(evaluate(curve, t).position.x()));
  }
  return largest;
}

double lengthOf(const Curve& curve) {
  if (curve.kind == Curve::Kind::Line) return (curve.to - curve.from).norm();
  if (curve.kind == Curve::Kind::Hyperbola) return std::abs(curve.stop - curve.start);
  return std::abs(curve.stop - curve.start) * curve.to.maxCoeff();
}

std::uint32_t segmentsAround(double radiusM, const Detail& detail) {
  constexpr double kSegmentsAtOneMetre = 20;
  // Pieces of the same radius must agree, or cracks would open where they meet: the radius decides the
  // dither, to a tenth of a millimetre.
  const double spread = 0.6180339887498949 * std::floor(radiusM * 1e4 + 0.5);
  const double wanted =
      kSegmentsAtOneMetre * detail.level * std::sqrt(radiusM) + (spread - std::floor(spread)) - 0.5;
  // Below level 0.4 only counts matter, not looks.
  const double share = 0.6 + 0.4 * std::min(1.0, detail.level / 0.4);
  const double least = std::max(3.0, share * (radiusM < 0.06 ? 4.5 : radiusM < 1 ? 6.5 : 10));
  return static_cast<std::uint32_t>(std::max(wanted, least));
}

std::uint32_t ringsAlong(double lengthM, double radiusM, const Detail& detail) {
  if (!(radiusM > 0)) return 1;
  const double wanted =
      0.016 * detail.level * detail.level * std::sqrt(std::max(lengthM, 0.0) / radiusM) + detail.dither;
  return static_cast<std::uint32_t>(std::max(wanted, 1.0));
}

std::uint32_t piecesOfArc(double angleRad, std::uint32_t fullCircle) {
  const double share = std::abs(angleRad) / (2 * kPi);
  return static_cast<std::uint32_t>(std::max({share * fullCircle + 0.5, share * 6, 1.0}));
}

}  // namespace tessera::synthetic
