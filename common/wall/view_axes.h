#pragma once

#include <optional>

#include "common/geometry/vec.h"

namespace tessera {

/// Below this sine of the angle between view and up (1e-6 rad, a fifth of an arc second) the up vector says
/// nothing reliable about how the picture is turned.
inline constexpr double kMinUpSine = 1e-6;

/// `v` at length 1, whatever its scale; nothing where it is zero or not finite.
[[nodiscard]] std::optional<Vec3> direction(const Vec3& v);

/// The part of `up` that is across the unit vector `forward`, at length 1; nothing where `up` is zero or
/// along `forward`.
[[nodiscard]] std::optional<Vec3> upAcross(const Vec3& forward, const Vec3& up);

/// Some unit vector across the unit vector `forward`: y up where possible, else z.
[[nodiscard]] Vec3 anyUpAcross(const Vec3& forward);

}  // namespace tessera
