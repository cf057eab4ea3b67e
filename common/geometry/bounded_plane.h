#pragma once

#include <array>
#include <cmath>

#include "common/geometry/box.h"
#include "common/geometry/vec.h"

namespace tessera {

/// A plane in coordinates relative to the eye, with a bound of everything that rounding may have done.
///
/// value(p) = normal.p - distance is >= 0 inside. The exact plane is the one that the frustum's doubles
/// define; for any point p relative to the eye, the exact value differs from the computed one by at most
///
///     errorPerUnit.|p| + errorConstant          (|p| per component)
///
/// where the bound already covers the rounding of the test itself (classify below). A box is called outside
/// only when it is outside by more than that, so rounding can add to a visible list but never take from it.
///
/// Derivation, u = 2^-53, for a plane through the eye and two corners A, B: a = fl(A - eye) and
/// b = fl(B - eye) err by u per component, the products of the cross product by 3u, its difference by one
/// more, so component i of the normal errs by at most 4u(1+O(u)) m_i with m_i = |a_j b_k| + |a_k b_j|; 6u m_i
/// is kept. Testing a box with centre c: d = fl(c - eye) errs by u|d|, a dot product of three by 3u of the
/// sum of its absolute terms, the radius sum|n.h_k| by 5u likewise, the last two sums by 2u: at most 8u|n_i|
/// a component of |d| + sum|h_k|; 12u|n_i| is kept, which also covers rounding in the bound itself.
///
/// Underflow: A, B and the normal are scaled by powers of two, so only components that vanish beside others
/// are rounded by it. Before the normal is scaled that is below 6 * 2^-1075 a component (four products with a
/// rounded factor, two rounded products); 2^-1070 is kept there, and again after scaling. In the test itself
/// each of at most 30 products, halves and bounds may err by 2^-1075, whatever their factors; errorConstant
/// is 2^-1060, which no scene's details notice. Overflow: the normal's components are below 1/8, so no sum of
/// the test overflows unless d or the magnitude has, and then the bound is infinite or NaN, and the answer
/// Intersecting.
struct BoundedPlane {
  Vec3 normal = Vec3::Zero();
  double distance = 0;
  Vec3 errorPerUnit = Vec3::Zero();
  double errorConstant = 0;
};

enum class Side { Outside, Intersecting, Inside };

/// The plane through the eye and the corners A and B, given relative to the eye (rounded once); points that
/// see A to B clockwise about them are inside: the normal is b x a times a positive number that brings its
/// largest component into [1/16, 1/8); 0 where the eye, A and B are collinear as far as doubles can tell.
[[nodiscard]] BoundedPlane planeThroughEye(const Vec3& a, const Vec3& b);

/// Widens the plane's bound by `angle`: the length of the change of the normal as it is scaled here.
void widen(BoundedPlane& plane, double angle);

/// Bounds of one node relative to the eye, in the form in which planes test them.
struct RelativeObb {
  Vec3 d;  ///< centre - eye
  std::array<Vec3, 3> halfAxes;
  Vec3 magnitude;  ///< |d| + sum|h_k|

  RelativeObb(const Obb& box, const Vec3& eye)
      : d(box.center - eye),
        halfAxes(box.halfAxes),
        magnitude(d.cwiseAbs() + halfAxes[0].cwiseAbs() + halfAxes[1].cwiseAbs() + halfAxes[2].cwiseAbs()) {}
  [[nodiscard]] double radius(const Vec3& n) const {
    return std::abs(n.dot(halfAxes[0])) + std::abs(n.dot(halfAxes[1])) + std::abs(n.dot(halfAxes[2]));
  }
};

struct RelativeAabb {
  Vec3 d, half, magnitude;

  RelativeAabb(const Aabb& box, const Vec3& eye) {
    const Vec3 low = box.min - eye, high = box.max - eye;
    d = 0.5 * low + 0.5 * high;  // the sum itself might overflow
    // The roundings of low, high and d are paid for here, relative to the corners: u each for the difference,
    // for d and half together (|low + high| + |high - low| is twice the larger magnitude), and for the sum
    // below.
    magnitude = low.cwiseAbs().cwiseMax(high.cwiseAbs());
    half = 0.5 * (high - low) + 4 * kUnitRoundoff * magnitude;
    magnitude += half;
  }
  [[nodiscard]] double radius(const Vec3& n) const { return n.cwiseAbs().dot(half); }
};

struct RelativeSphere {
  Vec3 d;
  double sphereRadius;
  Vec3 magnitude;

  RelativeSphere(const Sphere& s, const Vec3& eye)
      : d(s.center - eye), sphereRadius(s.radius), magnitude(d.cwiseAbs() + Vec3::Constant(s.radius)) {}
  [[nodiscard]] double radius(const Vec3& n) const {
    return n.norm() * sphereRadius * (1 + 8 * kUnitRoundoff);
  }
};

/// How far outside the plane a bound certainly lies, in the units of the plane's value; not positive where it
/// is not certainly outside.
template <class RelativeBounds>
[[nodiscard]] double outsideBy(const RelativeBounds& bounds, const BoundedPlane& plane) {
  const double value = plane.normal.dot(bounds.d) - plane.distance;
  const double error = plane.errorPerUnit.dot(bounds.magnitude) + plane.errorConstant;
  return -(value + bounds.radius(plane.normal) + error);
}

/// Where a closed bound lies. Outside is certain; so is Inside; what cannot be told is Intersecting. NaN
/// anywhere gives Intersecting.
template <class RelativeBounds>
[[nodiscard]] Side classify(const RelativeBounds& bounds, const BoundedPlane& plane) {
  const double value = plane.normal.dot(bounds.d) - plane.distance;
  const double radius = bounds.radius(plane.normal);
  const double error = plane.errorPerUnit.dot(bounds.magnitude) + plane.errorConstant;
  if (value + radius + error < 0) return Side::Outside;
  if (value - radius - error >= 0) return Side::Inside;
  return Side::Intersecting;
}

}  // namespace tessera
