#pragma once

#include "common/scene/synthetic/shapes.h"

namespace tessera::synthetic {

struct CurvePoint {
  Vec2 position;
  Vec2 normal;  ///< unit, to the outside
};

/// The point at `t` in [0, 1].
[[nodiscard]] CurvePoint evaluate(const Curve& curve, double t);
/// The largest |x|: of a profile, the radius that decides how many segments it needs.
[[nodiscard]] double largestX(const Curve& curve);
[[nodiscard]] double lengthOf(const Curve& curve);

/// Segments around a full circle.
[[nodiscard]] std::uint32_t segmentsAround(double radiusM, const Detail& detail);
/// Pieces of a straight stretch along a round body.
[[nodiscard]] std::uint32_t ringsAlong(double lengthM, double radiusM, const Detail& detail);
/// Pieces of an arc whose full circle would get `fullCircle` segments; at least six to the circle.
[[nodiscard]] std::uint32_t piecesOfArc(double angleRad, std::uint32_t fullCircle);

}  // namespace tessera::synthetic
