#include "common/geometry/exact_frustum.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <boost/multiprecision/cpp_int.hpp>

namespace tessera {

namespace {

using Integer = boost::multiprecision::cpp_int;
using Integer3 = std::array<Integer, 3>;

constexpr int kNoExponent = std::numeric_limits<int>::max();

/// A finite double as mantissa * 2^exponent, the mantissa odd (or 0).
struct Dyadic {
  std::int64_t mantissa = 0;
  int exponent = kNoExponent;

  explicit Dyadic(double x) {
    if (x == 0) return;
    int e = 0;
    mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &e), 53));
    const int zeros = std::countr_zero(static_cast<std::uint64_t>(mantissa));
    mantissa >>= zeros;
    exponent = e - 53 + zeros;
  }
  /// As a multiple of 2^unit; unit <= exponent.
  [[nodiscard]] Integer in(int unit) const {
    return mantissa == 0 ? Integer(0) : Integer(mantissa) << static_cast<unsigned>(exponent - unit);
  }
};

int lowestExponent(const Vec3& v) {
  return std::min({Dyadic(v.x()).exponent, Dyadic(v.y()).exponent, Dyadic(v.z()).exponent});
}
Integer3 integers(const Vec3& v, int unit) {
  return {Dyadic(v.x()).in(unit), Dyadic(v.y()).in(unit), Dyadic(v.z()).in(unit)};
}
Integer3 minus(const Integer3& a, const Integer3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Integer3 cross(const Integer3& a, const Integer3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Integer dot(const Integer3& a, const Integer3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The rational point p / w, w > 0. Homogeneous coordinates need no division and no common divisors.
struct Point {
  Integer3 p;
  Integer w;
};

struct Plane {
  Integer3 n;
  Integer offset;

  [[nodiscard]] Integer at(const Point& q) const {
    return offset == 0 ? dot(n, q.p) : Integer(dot(n, q.p) - offset * q.w);
  }
};

Integer sum(const Integer& s, const Integer& a, const Integer& t, const Integer& b) {
  return s * a + t * b;
}

/// The part of a convex polygon (also a point or a segment) where the plane's value is >= 0.
std::vector<Point> clipped(const std::vector<Point>& polygon, const Plane& plane) {
  std::vector<Integer> value;
  for (const Point& p : polygon)
    value.push_back(plane.at(p));
  std::vector<Point> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::size_t j = (i + 1) % polygon.size();
    const Point &p = polygon[i], &q = polygon[j];
    if (value[i] >= 0) kept.push_back(p);
    if (value[i].sign() * value[j].sign() >= 0) continue;
    // The values are those at p/w times w, so these weights, both positive, make the value 0.
    const Integer s = abs(value[j]), t = abs(value[i]);
    kept.push_back({{sum(s, p.p[0], t, q.p[0]), sum(s, p.p[1], t, q.p[1]), sum(s, p.p[2], t, q.p[2])},
                    sum(s, p.w, t, q.w)});
  }
  return kept;
}

/// floor and ceiling of |v| 2^shift.
std::array<Integer, 2> lengthBounds(const Integer3& v, unsigned shift) {
  Integer remainder;
  const Integer low = sqrt(Integer(dot(v, v) << (2 * shift)), remainder);
  return {low, remainder == 0 ? low : Integer(low + 1)};
}

/// The bounds lie within 2^-kShift of each other, relatively: an integer vector that is not 0 is 1 long at
/// least.
constexpr unsigned kShift = 256;

}  // namespace

/// All lengths are multiples of 2^unit.
struct ExactFrustum::Exact {
  bool empty = false;
  int unit = 0;
  Integer3 eye;
  std::vector<Plane> planes;
  int direction = 0;  ///< sign of n.(c0 - eye) of the rectangle's normal; 0: has none

  explicit Exact(const Frustum& frustum) {
    empty = !isFinite(frustum.eye);
    for (const Vec3& c : frustum.corners)
      empty = empty || !isFinite(c);
    for (const std::optional<double>& d : {frustum.near, frustum.far})
      empty = empty || (d && std::isnan(*d));
    if (empty) return;
    unit = lowestExponent(frustum.eye);
    for (const Vec3& c : frustum.corners)
      unit = std::min(unit, lowestExponent(c));
    for (const std::optional<double>& d : {frustum.near, frustum.far}) {
      if (d && std::isfinite(*d)) unit = std::min(unit, Dyadic(*d).exponent);
    }
    if (unit == kNoExponent) unit = 0;
    eye = integers(frustum.eye, unit);
    std::array<Integer3, 4> corners;
    for (std::size_t i = 0; i < 4; ++i)
      corners[i] = minus(integers(frustum.corners[i], unit), eye);
    for (std::size_t i = 0; i < 4; ++i)
      planes.push_back({cross(corners[(i + 1) % 4], corners[i]), 0});
    addNearAndFar(frustum, corners);
  }

  void addNearAndFar(const Frustum& frustum, const std::array<Integer3, 4>& corners) {
    if (!frustum.near && !frustum.far) return;
    Integer3 n = cross(minus(corners[1], corners[0]), minus(corners[3], corners[0]));
    direction = dot(n, corners[0]).sign();
    const std::array<Integer, 2> length = lengthBounds(n, kShift);
    for (Integer& x : n)
      x = Integer(x << kShift) * direction;
    if (direction == 0) empty = true;
    const auto add = [&](double distance, int sign) {
      if (std::isinf(distance)) {
        empty = empty || distance * sign > 0;
        return;
      }
      // sign n.p >= sign distance |n|: the larger right side is the smaller frustum.
      const Integer d = Dyadic(distance).in(unit)*sign;
      planes.push_back({{n[0] * sign, n[1] * sign, n[2] * sign}, d * length[d > 0 ? 1 : 0]});
    };
    if (frustum.near) add(*frustum.near, 1);
    if (frustum.far) add(*frustum.far, -1);
  }

  [[nodiscard]] bool meets(const Triangle& triangle) const {
    if (empty) return false;
    int fine = unit;
    for (const Vec3& v : triangle)
      fine = std::min(fine, lowestExponent(v));
    const Integer one = Integer(1) << static_cast<unsigned>(unit - fine);
    std::vector<Point> polygon;
    for (const Vec3& v : triangle)
      polygon.push_back({minus(integers(v, fine), Integer3{eye[0] * one, eye[1] * one, eye[2] * one}), one});
    for (const Plane& plane : planes) {
      polygon = clipped(polygon, plane);
      if (polygon.empty()) return false;
    }
    return true;
  }
};

// The filter, u = 2^-53, M the largest |vertex - eye|, |a| and |b| the lengths of the scaled vectors whose
// cross product n is.
//
// Planes: as BoundedPlane's derivation has it, n errs by 4u(1 + O(u)) (|a_j b_k| + |a_k b_j|) a component, as
// a vector by less than 8u|a||b|, and the value at a point |p| <= M by 8u|a||b|M; 12u is kept. For near and
// far a and b are differences of corners, rounded once as well, and near |n| errs by (8u|a||b| + 6u|n|) near
// more.
//
// Points: p = fl(v - eye) errs by u|p|. A crossing c = p + t(q - p) is taken with 0 <= t <= 1, so it lies
// within 5uM of a point of the segment pq, however badly t is rounded. Six clippings and the mean of up to 30
// vertices leave every point of the computed polygon within (1 + 6*5 + 31)uM of the exact triangle.
// Evaluation errs by less than 6u|n|M, offsets included, and t's own rounding moves the crossing's value,
// which should be 0, by twice that at most. So every point of the triangle whose value is above all this
// stays within 62uM of the clipped polygon, and the value of any point of the polygon is that of a point of
// the triangle to within (62 + 3*6)u|n|M + 12u|a||b|M; 128u|n|M is kept, which leaves room for terms of order
// u^2, the rounding of the bound, and |n| is taken as the sum of its components' magnitudes.
//
// Underflow is harmless: |a|, |b| >= 1/2 and M >= 2^-450, so the bound is above 2^-510 and a product that
// underflows errs by 2^-1075. Overflow: M <= 2^500 and |n| < 6.
//
// Pushed out by this error the planes keep whatever of the triangle lies in the frustum: an empty polygon
// means no. A point of the polygon whose values are all above the error stands for a point of the triangle
// inside: yes.

namespace {

constexpr double kLeastReach = 0x1p-450, kMostReach = 0x1p500;

/// `v` times the power of two that brings its largest component into [1/2, 1).
Vec3 scaledToUnit(const Vec3& v) {
  const double largest = v.cwiseAbs().maxCoeff();
  if (!(largest > 0) || !std::isfinite(largest)) return v;
  int exponent = 0;
  std::frexp(largest, &exponent);
  return v.unaryExpr([exponent](double x) { return std::ldexp(x, -exponent); });
}

/// A clipping of k vertices by a line leaves 3k/2 at most, even where rounding has bent the polygon; 3
/// vertices and six planes stay below this.
constexpr std::size_t kMostVertices = 32;

struct Polygon {
  std::array<Vec3, kMostVertices> vertices;
  std::size_t size = 0;

  void push(const Vec3& v) {
    if (size < kMostVertices) vertices[size++] = v;
  }
  [[nodiscard]] Vec3 mean() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < size; ++i)
      sum += vertices[i];
    return sum / static_cast<double>(size);
  }
};

/// The part of the polygon where n.p >= offset, up to rounding.
Polygon clipped(const Polygon& polygon, const Vec3& n, double offset) {
  std::array<double, kMostVertices> value{};
  for (std::size_t i = 0; i < polygon.size; ++i)
    value[i] = n.dot(polygon.vertices[i]) - offset;
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size; ++i) {
    const std::size_t j = i + 1 < polygon.size ? i + 1 : 0;
    const Vec3 &p = polygon.vertices[i], &q = polygon.vertices[j];
    if (value[i] >= 0) kept.push(p);
    if ((value[i] > 0 && value[j] < 0) || (value[i] < 0 && value[j] > 0)) {
      const double t = std::clamp(value[i] / (value[i] - value[j]), 0.0, 1.0);
      kept.push(p + t * (q - p));
    }
  }
  return kept;
}

}  // namespace

ExactFrustum::ExactFrustum(const Frustum& frustum)
    : eye_(frustum.eye), exact_(std::make_unique<Exact>(frustum)) {
  if (exact_->empty) {
    filterable_ = false;
    return;
  }
  const std::array<Vec3, 4>& c = frustum.corners;
  for (std::size_t i = 0; i < 4; ++i)
    addFilterPlane(c[(i + 1) % 4] - eye_, c[i] - eye_, 1, 0);
  const double towards = exact_->direction;
  const auto add = [&](double distance, double sign) {
    if (!std::isinf(distance)) addFilterPlane(c[1] - c[0], c[3] - c[0], sign * towards, sign * distance);
  };
  if (frustum.near) add(*frustum.near, 1);
  if (frustum.far) add(*frustum.far, -1);
}

ExactFrustum::ExactFrustum(ExactFrustum&&) noexcept = default;
ExactFrustum& ExactFrustum::operator=(ExactFrustum&&) noexcept = default;
ExactFrustum::~ExactFrustum() = default;

void ExactFrustum::addFilterPlane(const Vec3& a, const Vec3& b, double sign, double distance) {
  // A vector that overflows cannot be used. One that is 0 is exactly 0, and so is its plane: nothing is
  // certain of it.
  if (!isFinite(a) || !isFinite(b) || std::abs(distance) > kMostReach) {
    filterable_ = false;
    return;
  }
  const Vec3 p = scaledToUnit(a), q = scaledToUnit(b);
  FilterPlane plane;
  plane.n = sign * p.cross(q);
  const double length = plane.n.cwiseAbs().sum(), sides = p.norm() * q.norm();
  plane.errorPerUnit = 12 * kUnitRoundoff * sides + 128 * kUnitRoundoff * length;
  if (distance != 0) {
    plane.offset = distance * plane.n.stableNorm();
    plane.errorConstant = std::abs(distance) * plane.errorPerUnit;
  }
  filterPlanes_.push_back(plane);
}

std::optional<bool> ExactFrustum::filter(const Triangle& triangle) const {
  if (!filterable_) return std::nullopt;
  Polygon polygon;
  double reach = 0;
  for (const Vec3& v : triangle) {
    const Vec3 p = v - eye_;
    const double square = p.squaredNorm();
    if (!std::isfinite(square)) return std::nullopt;
    reach = std::max(reach, square);
    polygon.push(p);
  }
  reach = std::sqrt(reach);
  if (!(reach >= kLeastReach && reach <= kMostReach)) return std::nullopt;

  std::array<double, 6> error{};
  std::array<bool, 3> inside = {true, true, true};
  for (std::size_t i = 0; i < filterPlanes_.size(); ++i) {
    const FilterPlane& plane = filterPlanes_[i];
    error[i] = plane.errorPerUnit * reach + plane.errorConstant;
    int outside = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double value = plane.n.dot(polygon.vertices[k]) - plane.offset;
      inside[k] = inside[k] && value > error[i];
      outside += value < -error[i] ? 1 : 0;
    }
    if (outside == 3) return false;
  }
  if (inside[0] || inside[1] || inside[2]) return true;

  Polygon wide = polygon, narrow = polygon;
  for (std::size_t i = 0; i < filterPlanes_.size(); ++i) {
    wide = clipped(wide, filterPlanes_[i].n, filterPlanes_[i].offset - error[i]);
    if (wide.size == 0) return false;
    narrow = clipped(narrow, filterPlanes_[i].n, filterPlanes_[i].offset + 2 * error[i]);
  }
  if (narrow.size == 0) return std::nullopt;
  const Vec3 witness = narrow.mean();
  for (std::size_t i = 0; i < filterPlanes_.size(); ++i) {
    if (!(filterPlanes_[i].n.dot(witness) - filterPlanes_[i].offset > error[i])) return std::nullopt;
  }
  return true;
}

bool ExactFrustum::meets(const Triangle& triangle) const {
  if (const std::optional<bool> certain = filter(triangle)) return *certain;
  ++exactDecisions_;
  return meetsExactly(triangle);
}

bool ExactFrustum::meetsExactly(const Triangle& triangle) const {
  for (const Vec3& v : triangle) {
    if (!isFinite(v)) return false;
  }
  return exact_->meets(triangle);
}

}  // namespace tessera
