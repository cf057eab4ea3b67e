#pragma once

#include <cmath>

#include "common/geometry/vec.h"

namespace tessera::synthetic {

inline constexpr double kPi = 3.14159265358979323846;

struct SinCos {
  double sin = 0;
  double cos = 1;
};

/// Sine and cosine to about 1e-15 for |angleRad| < 1000. A C library may pick other code on another
/// machine, which would change bytes of the scene; this uses only correctly rounded operations.
[[nodiscard]] inline SinCos sinCos(double angleRad) {
  const double quadrant = std::floor(angleRad * (2 / kPi) + 0.5);
  const double x = (angleRad - quadrant * 0x1.921fb54400000p+0) - quadrant * 0x1.0b4611a626331p-34;
  const double y = x * x;
  double s = 0;
  double c = 0;
  for (int k = 17; k >= 3; k -= 2)
    s = -(1 + s) * y / (k * (k - 1));
  for (int k = 16; k >= 2; k -= 2)
    c = -(1 + c) * y / (k * (k - 1));
  s = x * (1 + s);
  c = 1 + c;
  switch (static_cast<long long>(quadrant) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

/// Point at `angleRad` on a circle about the y axis; 0 is +x, a quarter turn is -z (counter-clockwise
/// from above).
[[nodiscard]] inline Vec3 onCircle(double radiusM, double angleRad, double heightM = 0) {
  const SinCos a = sinCos(angleRad);
  return {radiusM * a.cos, heightM, -radiusM * a.sin};
}

}  // namespace tessera::synthetic
