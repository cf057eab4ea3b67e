#pragma once

#include <array>
#include <optional>

#include "common/geometry/vec.h"

namespace tessera {

/// A view frustum, defined by nothing but these doubles: the eye and the four corners of an image
/// rectangle in world space.
///
///      3 ---------- 2        corners: 0 lower left, 1 lower right, 2 upper right, 3 upper left,
///      |            |        as seen from the eye
///      |            |
///      0 ---------- 1
///
/// The closed set of points on the inner side of the four planes through the eye and two neighbouring
/// corners, in front of the eye and, where given, between `near` and `far`: distances from the eye along
/// the normal of the image rectangle. The distance of the rectangle itself has no meaning.
struct Frustum {
  Vec3 eye = Vec3::Zero();
  std::array<Vec3, 4> corners = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  std::optional<double> near;
  std::optional<double> far;
};

}  // namespace tessera
