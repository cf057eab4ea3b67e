#pragma once

#include <array>
#include <limits>
#include <span>

#include "common/geometry/vec.h"

namespace tessera {

/// Axis-aligned box, closed. The empty box is inverted, so that extending needs no branch.
struct Aabb {
  Vec3 min = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 max = Vec3::Constant(-std::numeric_limits<double>::infinity());

  [[nodiscard]] bool empty() const { return !(min.x() <= max.x()); }
  void extend(const Vec3& p) { min = min.cwiseMin(p), max = max.cwiseMax(p); }
  void extend(const Aabb& b) { min = min.cwiseMin(b.min), max = max.cwiseMax(b.max); }
  /// Grows by `margin` >= 0 to each side; the sums are rounded outward.
  void inflate(const Vec3& margin);
  [[nodiscard]] Vec3 center() const { return 0.5 * min + 0.5 * max; }
  [[nodiscard]] bool contains(const Aabb& b) const {
    return (min.array() <= b.min.array()).all() && (max.array() >= b.max.array()).all();
  }
};

/// Sphere, closed.
struct Sphere {
  Vec3 center = Vec3::Zero();
  double radius = 0;
};

/// Oriented box {center + a*axes[0] + b*axes[1] + c*axes[2] : |a|,|b|,|c| <= 1}. The half-axes carry their
/// length and need not be exactly perpendicular; exactly this set is what cullers test.
struct Obb {
  Vec3 center = Vec3::Zero();
  std::array<Vec3, 3> halfAxes = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};

  [[nodiscard]] std::array<Vec3, 8> corners() const;
  /// The same set as an oriented box. Rounded outward.
  [[nodiscard]] static Obb fromAabb(const Aabb& box);
};

/// Axis-aligned box of points, each known to within `margin` (per axis, >= 0). Rounded outward.
[[nodiscard]] Aabb aabbOf(std::span<const Vec3> points, const Vec3& margin);

/// Sphere about the box's centre that holds all points, each known to within `margin`.
[[nodiscard]] Sphere sphereOf(std::span<const Vec3> points, const Vec3& center, const Vec3& margin);

/// Oriented box of points by principal component analysis: the axes are the eigenvectors of the points'
/// covariance (Nirnimesh, Harish, Narayanan 2006, Algorithm 1). Holds every point within `margin` in
/// exact arithmetic: the half-lengths are padded by a bound of all rounding (see box.cpp). Where the
/// axis-aligned box is smaller, that one is returned: the principal axes of a symmetric thing are arbitrary.
/// At least one point; all finite.
[[nodiscard]] Obb pcaObbOf(std::span<const Vec3> points, const Vec3& margin);

}  // namespace tessera
