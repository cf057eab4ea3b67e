#pragma once

#include <array>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>

#include "common/geometry/frustum.h"

namespace tessera::test {

/// Independent oracle: does a triangle meet the closed cone of a frustum's four sides? Exact rational
/// arithmetic, straight from the defining doubles, by clipping the triangle against one side after the other.
/// Near and far are not looked at: their planes have irrational coefficients.
class ExactFrustum {
 public:
  explicit ExactFrustum(const Frustum& frustum) : eye_(exact(frustum.eye)) {
    for (std::size_t i = 0; i < 4; ++i) {
      const Point a = minus(exact(frustum.corners[i]), eye_),
                  b = minus(exact(frustum.corners[(i + 1) % 4]), eye_);
      sides_[i] = {b[1] * a[2] - b[2] * a[1], b[2] * a[0] - b[0] * a[2], b[0] * a[1] - b[1] * a[0]};
    }
  }

  [[nodiscard]] bool meets(const std::array<Vec3, 3>& triangle) const {
    std::vector<Point> polygon;
    for (const Vec3& v : triangle)
      polygon.push_back(minus(exact(v), eye_));
    for (const Point& side : sides_) {
      polygon = clipped(polygon, side);
      if (polygon.empty()) return false;
    }
    return true;
  }

 private:
  using Rational = boost::multiprecision::cpp_rational;
  using Point = std::array<Rational, 3>;

  static Point exact(const Vec3& v) { return {Rational(v.x()), Rational(v.y()), Rational(v.z())}; }
  static Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
  static Rational dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

  /// The part of a convex polygon (also a point or a segment) where side.p >= 0.
  static std::vector<Point> clipped(const std::vector<Point>& polygon, const Point& side) {
    std::vector<Point> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point& p = polygon[i];
      const Point& q = polygon[(i + 1) % polygon.size()];
      const Rational atP = dot(side, p), atQ = dot(side, q);
      if (atP >= 0) kept.push_back(p);
      if ((atP > 0 && atQ < 0) || (atP < 0 && atQ > 0)) {
        const Rational t = atP / (atP - atQ);
        kept.push_back({p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2])});
      }
    }
    return kept;
  }

  Point eye_;
  std::array<Point, 4> sides_;
};

}  // namespace tessera::test
