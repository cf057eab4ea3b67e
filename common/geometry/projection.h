#pragma once

#include <array>
#include <cstddef>

#include "common/geometry/vec.h"

namespace tessera {

/// The view-projection matrix, relative to the eye, of an image rectangle whose corners are given relative
/// to the eye (order of Frustum; `axis` is the unit normal away from the eye), as OpenGL defines it: clip
/// coordinates -w <= x, y, z <= w inside. 0 < near < far, along the axis.
[[nodiscard]] Mat4 relativeViewProjection(const std::array<Vec3, 4>& corners, const Vec3& axis, double near,
                                          double far);

/// The order of gribbHartmannPlanes.
enum class ClipPlane : std::size_t { Left, Right, Bottom, Top, Near, Far };

/// The six clip planes (a, b, c, d), a x + b y + c z + d >= 0 inside, not normalized, in the coordinates that
/// the matrix maps to clip coordinates: world space for a view-projection matrix, model space for a
/// model-view-projection matrix. Sums and differences of its rows (Gribb and Hartmann, "Fast extraction of
/// viewing frustum planes from the world-view-projection matrix", 2001).
[[nodiscard]] std::array<Eigen::Vector4d, 6> gribbHartmannPlanes(const Mat4& toClip);

}  // namespace tessera
