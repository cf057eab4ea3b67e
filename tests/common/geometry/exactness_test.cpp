// Boxes against planes, judged exactly: what classify() calls Outside must be outside, what it calls Inside
// inside. TESSERA_EXACT_CASES says how many cases; the test labelled `soak` runs a hundred million.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <boost/multiprecision/cpp_int.hpp>
#include <gtest/gtest.h>

#include "common/geometry/bounded_plane.h"

namespace tessera {
namespace {

using Integer = boost::multiprecision::cpp_int;
using Long3 = Eigen::Matrix<long double, 3, 1>;

enum class Kind { Obb, Aabb, Sphere };

/// A box of one kind, and the plane through `eye`, `a` and `b`: all in world coordinates.
struct Case {
  Vec3 eye, a, b;
  Kind kind = Kind::Obb;
  Obb obb = {};
  Aabb aabb = {.min = Vec3::Zero(), .max = Vec3::Zero()};
  Sphere sphere = {};
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  const auto print = [&out](const char* name, const Vec3& v) {
    out << name << " (" << v.x() << ", " << v.y() << ", " << v.z() << ") ";
  };
  out << std::hexfloat;
  print("eye", c.eye), print("a", c.a), print("b", c.b);
  if (c.kind == Kind::Obb) {
    print("obb", c.obb.center);
    for (const Vec3& h : c.obb.halfAxes)
      print("half", h);
  } else if (c.kind == Kind::Aabb) {
    print("min", c.aabb.min), print("max", c.aabb.max);
  } else {
    print("sphere", c.sphere.center), out << c.sphere.radius;
  }
  return out;
}

/// The largest (end 1) or smallest (end -1) exact value of n.(x - eye) over the box, n = (b - eye) x (a -
/// eye), times a positive number, as an integer: everything is a multiple of one power of two. A sphere's is
/// V + |n|r; its sign is found from the squares.
int exactSign(const Case& c, int end) {
  std::vector<double> numbers;
  for (const Vec3* v : {&c.eye, &c.a, &c.b, &c.obb.center, &c.obb.halfAxes[0], &c.obb.halfAxes[1],
                        &c.obb.halfAxes[2], &c.aabb.min, &c.aabb.max, &c.sphere.center})
    numbers.insert(numbers.end(), v->begin(), v->end());
  numbers.push_back(c.sphere.radius);
  int unit = 2000;
  for (const double x : numbers) {
    int e = 0;
    if (x != 0 && std::isfinite(x)) std::frexp(x, &e), unit = std::min(unit, e - 53);
  }
  const auto integer = [unit](double x) {
    int e = 0;
    const auto m = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &e), 53));
    return m == 0 ? Integer(0) : Integer(m) << static_cast<unsigned>(e - 53 - unit);
  };
  using Integer3 = std::array<Integer, 3>;
  const auto point = [&](const Vec3& v) { return Integer3{integer(v[0]), integer(v[1]), integer(v[2])}; };
  const auto relative = [&](const Vec3& v) {
    const Integer3 p = point(v), e = point(c.eye);
    return Integer3{p[0] - e[0], p[1] - e[1], p[2] - e[2]};
  };
  const auto dot = [](const Integer3& p, const Integer3& q) {
    return Integer(p[0] * q[0] + p[1] * q[1] + p[2] * q[2]);
  };
  const Integer3 a = relative(c.a), b = relative(c.b);
  const Integer3 n = {b[1] * a[2] - b[2] * a[1], b[2] * a[0] - b[0] * a[2], b[0] * a[1] - b[1] * a[0]};
  if (c.kind == Kind::Obb) {
    Integer radius = 0;
    for (const Vec3& h : c.obb.halfAxes)
      radius += abs(dot(n, point(h)));
    return Integer(dot(n, relative(c.obb.center)) + end * radius).sign();
  }
  if (c.kind == Kind::Aabb) {
    Integer3 x = relative(c.aabb.max);
    const Integer3 low = relative(c.aabb.min);
    for (std::size_t i = 0; i < 3; ++i) {
      if (n[i].sign() * end < 0) x[i] = low[i];
    }
    return dot(n, x).sign();
  }
  const Integer value = dot(n, relative(c.sphere.center)), r = integer(c.sphere.radius);
  const Integer reach = dot(n, n) * r * r;
  if (value.sign() * end >= 0) return value.sign() != 0 ? value.sign() : end * reach.sign();
  // V and end |n|r have opposite signs: the larger square wins.
  const int larger = Integer(reach - value * value).sign();
  return larger * end;
}

/// As exactSign, 2 where long double cannot tell. Its range has room for every product of doubles met here.
/// Each value is a sum of products of three numbers (of a, b and the box, relative to the eye); on its way to
/// the result a product passes 3 subtractions of the eye, 2 multiplications and at most 8 additions or roots:
/// it errs by less than 14 U, U = 2^-64, of its magnitude. 24 U of the sum of magnitudes is kept.
int quickSign(const Case& c, int end) {
  const Long3 eye = c.eye.cast<long double>();
  const Long3 a = c.a.cast<long double>() - eye, b = c.b.cast<long double>() - eye;
  const Long3 n = {b[1] * a[2] - b[2] * a[1], b[2] * a[0] - b[0] * a[2], b[0] * a[1] - b[1] * a[0]};
  const Long3 terms = {std::abs(b[1] * a[2]) + std::abs(b[2] * a[1]),
                       std::abs(b[2] * a[0]) + std::abs(b[0] * a[2]),
                       std::abs(b[0] * a[1]) + std::abs(b[1] * a[0])};
  long double value = 0;
  Long3 magnitude;
  if (c.kind == Kind::Obb) {
    const Long3 d = c.obb.center.cast<long double>() - eye;
    value = n.dot(d), magnitude = d.cwiseAbs();
    for (const Vec3& h : c.obb.halfAxes) {
      const Long3 half = h.cast<long double>();
      value += end * std::abs(n.dot(half)), magnitude += half.cwiseAbs();
    }
  } else if (c.kind == Kind::Aabb) {
    const Long3 low = c.aabb.min.cast<long double>() - eye, high = c.aabb.max.cast<long double>() - eye;
    for (int i = 0; i < 3; ++i)
      value += end * std::max(end * n[i] * low[i], end * n[i] * high[i]);
    magnitude = low.cwiseAbs().cwiseMax(high.cwiseAbs());
  } else {
    const Long3 d = c.sphere.center.cast<long double>() - eye;
    value = n.dot(d) + end * std::sqrt(n.dot(n)) * static_cast<long double>(c.sphere.radius);
    magnitude = d.cwiseAbs() + Long3::Constant(static_cast<long double>(c.sphere.radius));
  }
  const long double error = 24 * 0x1p-64L * terms.dot(magnitude);
  if (value > error) return 1;
  return value < -error ? -1 : 2;
}

/// Whoever asks twice computes once.
class Judge {
 public:
  explicit Judge(const Case& c) : case_(c) {}
  bool outside() { return sign(1) < 0; }
  bool inside() { return sign(-1) >= 0; }
  [[nodiscard]] int exact() const { return exact_; }

 private:
  int sign(int end) {
    int& known = known_[end > 0 ? 1 : 0];
    if (known == 3) known = quickSign(case_, end);
    if (known == 2) known = exactSign(case_, end), ++exact_;
    return known;
  }
  const Case& case_;
  std::array<int, 2> known_ = {3, 3};
  int exact_ = 0;
};

Side classify(const Case& c) {
  const BoundedPlane plane = planeThroughEye(c.a - c.eye, c.b - c.eye);
  if (c.kind == Kind::Obb) return tessera::classify(RelativeObb(c.obb, c.eye), plane);
  if (c.kind == Kind::Aabb) return tessera::classify(RelativeAabb(c.aabb, c.eye), plane);
  return tessera::classify(RelativeSphere(c.sphere, c.eye), plane);
}

/// The plain test without a bound: is the box outside? In Real, relative to `origin`.
template <class Real>
bool plainlyOutside(const Case& c, const Vec3& origin) {
  using Real3 = Eigen::Matrix<Real, 3, 1>;
  const Vec3 a = c.a - c.eye, b = c.b - c.eye;
  const Vec3 normal = b.cross(a).normalized();
  const Real3 n = normal.cast<Real>();
  const Real distance = static_cast<Real>(normal.dot(c.eye - origin));
  const auto relative = [&](const Vec3& v) { return Real3((v - origin).cast<Real>()); };
  if (c.kind == Kind::Obb) {
    Real radius = 0;
    for (const Vec3& h : c.obb.halfAxes)
      radius += std::abs(n.dot(h.cast<Real>()));
    return n.dot(relative(c.obb.center)) - distance + radius < 0;
  }
  if (c.kind == Kind::Aabb) {
    const Real3 low = relative(c.aabb.min), high = relative(c.aabb.max);
    const Real half = static_cast<Real>(0.5);
    return n.dot(half * (low + high)) - distance + n.cwiseAbs().dot(half * (high - low)) < 0;
  }
  return n.dot(relative(c.sphere.center)) - distance + static_cast<Real>(c.sphere.radius) < 0;
}

enum class Place {
  Anywhere,
  AboutTile,
  Touching,
  AtCorner,
  OnGrid,
  HoldsEye,
  SpansEyePlane,
  HoldsFrustum,
  AnyDoubles
};

struct Family {
  const char* name;
  Place place = Place::Anywhere;
  double offset = 0;          ///< of the eye from the origin
  double size = 1;            ///< distance of the image rectangle
  double fovDeg = 0;          ///< 0: 10 to 120
  int flatAxes = 0;           ///< how many half-axes are 0
  double boxScale = 1;        ///< of box and of its distance, over `size`
  double leastExtent = 1e-3;  ///< over boxScale
  bool zeros = false;         ///< many components are 0 or -0
};

const std::array kFamilies = {
    Family{.name = "random"},
    Family{.name = "random, offset 1e6", .offset = 1e6},
    Family{.name = "random, offset 1e8", .offset = 1e8, .size = 10},
    Family{.name = "holds the eye", .place = Place::HoldsEye},
    Family{.name = "spans the eye's plane", .place = Place::SpansEyePlane},
    Family{.name = "holds the frustum", .place = Place::HoldsFrustum},
    Family{.name = "random, 1e-9", .size = 1e-9},
    Family{.name = "random, 1e9", .size = 1e9},
    Family{.name = "random, tile of 0.001 deg", .fovDeg = 0.001},
    Family{.name = "random, tile of 179.9 deg", .fovDeg = 179.9},
    Family{.name = "about a tile, 50 deg", .place = Place::AboutTile, .fovDeg = 50},
    Family{.name = "about a tile, 1 deg", .place = Place::AboutTile, .fovDeg = 1},
    Family{.name = "about a tile, 0.001 deg", .place = Place::AboutTile, .fovDeg = 0.001},
    Family{.name = "about a tile, 179.9 deg", .place = Place::AboutTile, .fovDeg = 179.9},
    Family{.name = "touching, offset 0", .place = Place::Touching},
    Family{.name = "touching, offset 1e4", .place = Place::Touching, .offset = 1e4},
    Family{.name = "touching, offset 1e6", .place = Place::Touching, .offset = 1e6},
    Family{.name = "touching, offset 1e7", .place = Place::Touching, .offset = 1e7},
    Family{.name = "touching, offset 1e8", .place = Place::Touching, .offset = 1e8},
    Family{.name = "touching, offset 1e12", .place = Place::Touching, .offset = 1e12, .size = 100},
    Family{.name = "vertex at a corner", .place = Place::AtCorner},
    Family{.name = "vertex at a corner, 1e6", .place = Place::AtCorner, .offset = 1e6},
    Family{.name = "exactly touching", .place = Place::OnGrid},
    Family{.name = "touching, one axis flat", .place = Place::Touching, .flatAxes = 1},
    Family{.name = "touching, two axes flat", .place = Place::Touching, .flatAxes = 2},
    Family{.name = "touching, points", .place = Place::Touching, .flatAxes = 3},
    Family{.name = "touching, 1e-9", .place = Place::Touching, .size = 1e-9},
    Family{.name = "touching, 1e9", .place = Place::Touching, .size = 1e9},
    Family{.name = "touching, 0.001 deg", .place = Place::Touching, .fovDeg = 0.001},
    Family{.name = "touching, 179.9 deg", .place = Place::Touching, .fovDeg = 179.9},
    Family{.name = "zeros", .place = Place::Touching, .zeros = true},
    Family{.name = "denormal world", .place = Place::Touching, .size = 1e-310, .zeros = true},
    Family{.name = "denormal boxes", .place = Place::Touching, .boxScale = 1e-314, .zeros = true},
    Family{.name = "extents of 1e-300", .place = Place::Touching, .leastExtent = 1e-300},
    Family{.name = "all at 1e-300", .place = Place::Touching, .boxScale = 1e-300},
    Family{.name = "magnitude 1e150", .place = Place::Touching, .size = 1e150},
    Family{.name = "magnitude 1e150, boxes 1", .place = Place::Touching, .size = 1e150, .boxScale = 1e-150},
    Family{.name = "any doubles", .place = Place::AnyDoubles},
};

class Generator {
 public:
  explicit Generator(std::uint64_t seed) : state_(seed) {}

  std::uint64_t bits() {  // splitmix64
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }
  std::size_t below(std::size_t n) { return bits() % n; }
  double unit01() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double unit() { return 2 * unit01() - 1; }
  Vec3 unit3() { return {unit(), unit(), unit()}; }
  /// Between `least` and 1, evenly in the exponent.
  double spread(double least) { return std::pow(least, unit01()); }
  double anyDouble() {
    // Half of them within 64 binary orders of each other: else nearly everything is 0 beside the largest.
    const int e = below(2) != 0 ? static_cast<int>(below(2098)) - 1074 : order_ + static_cast<int>(below(64));
    return std::ldexp(unit(), std::clamp(e, -1074, 1024));
  }
  Vec3 any3() { return {anyDouble(), anyDouble(), anyDouble()}; }

  void newFrustum(const Family& f) {
    order_ = static_cast<int>(below(2034)) - 1074;
    eye_ = f.offset * Vec3(1, 1.0 / 3, -1.0 / 7);
    if (f.boxScale == 1) eye_ += f.size * unit3();
    if (f.place == Place::OnGrid) {
      eye_ = grid3();
      for (Vec3& c : corners_)
        c = grid3();
      return;
    }
    const double fov = (f.fovDeg > 0 ? f.fovDeg : 10 + 110 * unit01()) * std::numbers::pi / 180;
    const double half = std::tan(0.5 * fov);
    // A tile of 64, anywhere on the wall, or the wall.
    const double low = f.fovDeg > 0 ? half * (2 * static_cast<double>(below(64)) / 64 - 1) : -half;
    const double high = f.fovDeg > 0 ? low + half / 32 : half;
    const Mat3 turn = Eigen::Quaterniond(unit(), unit(), unit(), unit()).normalized().toRotationMatrix();
    depth_ = -turn.col(2);
    corners_ = {Vec3(low, low, -1), Vec3(high, low, -1), Vec3(high, high, -1), Vec3(low, high, -1)};
    for (Vec3& c : corners_)
      c = eye_ + f.size * (turn * c);
    if (f.zeros) {
      for (Vec3& c : corners_)
        putZeros(c);
      putZeros(eye_);
    }
  }

  Case next(const Family& f) {
    Case c;
    const std::size_t side = below(4);
    c.eye = eye_, c.a = corners_[side], c.b = corners_[(side + 1) % 4];
    c.kind = static_cast<Kind>(below(3));
    if (f.place == Place::AnyDoubles) {
      anyDoubles(c);
      return c;
    }
    const double scale = f.size * f.boxScale;
    std::array<Vec3, 3> half = halfAxes(f, c.kind, scale);
    double radius = half[0].x();
    switch (f.place) {
      case Place::Anywhere:
        setCenter(c, (c.eye + scale * 4 * unit3()).eval(), half, radius);
        break;
      case Place::AboutTile: {
        const Vec3 diagonal = corners_[2] - corners_[0];
        const double depth = 10 * spread(1e-3), width = depth * diagonal.norm() / f.size;
        for (Vec3& h : half)
          h *= width;
        const Vec3 middle = corners_[0] + 0.5 * diagonal - c.eye;
        setCenter(c, (c.eye + depth * middle + width * f.size * unit3()).eval(), half, width * radius);
        break;
      }
      case Place::HoldsEye: {
        Vec3 center = c.eye;
        for (const Vec3& h : half)
          center += 0.99 * unit() * h;
        if (c.kind == Kind::Sphere) center = c.eye + 0.5 * radius * unit3();
        setCenter(c, center, half, radius);
        break;
      }
      case Place::SpansEyePlane:
        setCenter(c, (c.eye + scale * (depth_.unitOrthogonal() * 3 * unit() + 0.1 * unit3())).eval(), half,
                  radius);
        break;
      case Place::HoldsFrustum:
        for (Vec3& h : half)
          h *= 50;
        setCenter(c, (c.eye + scale * (5 * depth_ + unit3())).eval(), half, 50 * std::abs(radius));
        break;
      default:
        touch(c, f, half, radius);
    }
    return c;
  }

 private:
  double grid() { return (static_cast<double>(below(1U << 20)) - 0x1p19) * 0x1p-10; }
  Vec3 grid3() { return {grid(), grid(), grid()}; }
  void putZeros(Vec3& v) {
    for (double& x : v) {
      if (below(3) == 0) x = below(2) != 0 ? 0.0 : -0.0;
    }
  }

  std::array<Vec3, 3> halfAxes(const Family& f, Kind kind, double scale) {
    std::array<Vec3, 3> half;
    for (int k = 0; k < 3; ++k) {
      Vec3& h = half[static_cast<std::size_t>(k)];
      const double length = scale * spread(f.leastExtent);
      if (f.place == Place::OnGrid)
        h = kind == Kind::Obb ? grid3() : std::abs(grid()) * Vec3::Unit(k);
      else
        h = kind == Kind::Obb ? Vec3(length * unit3()) : Vec3(length * Vec3::Unit(k));
      if (f.zeros && kind == Kind::Obb) putZeros(h);
    }
    for (int k = 0; k < f.flatAxes; ++k)
      half[static_cast<std::size_t>(k)] = Vec3::Zero();
    return half;
  }

  void setCenter(Case& c, const Vec3& center, const std::array<Vec3, 3>& half, double radius) {
    if (c.kind == Kind::Obb) {
      c.obb = {center, half};
    } else if (c.kind == Kind::Aabb) {
      const Vec3 h = half[0] + half[1] + half[2];
      c.aabb.min = center - h, c.aabb.max = center + h;
    } else {
      c.sphere = {center, radius};
    }
  }

  /// The vertex that reaches farthest over the plane lies on it: to within a few ulps, or exactly.
  void touch(Case& c, const Family& f, const std::array<Vec3, 3>& half, double radius) {
    const Long3 eye = c.eye.cast<long double>();
    const Long3 a = c.a.cast<long double>() - eye, b = c.b.cast<long double>() - eye;
    const Long3 n = {b[1] * a[2] - b[2] * a[1], b[2] * a[0] - b[0] * a[2], b[0] * a[1] - b[1] * a[0]};
    Long3 vertex;
    if (f.place == Place::AtCorner) {
      vertex = std::array{c.a, c.b, c.eye}[below(3)].cast<long double>();
    } else {
      const auto weight = [&] {
        return static_cast<long double>(f.place == Place::OnGrid ? static_cast<double>(below(9)) - 3
                                                                 : 3 * unit() * f.boxScale);
      };
      const long double s = weight(), t = weight();
      vertex = eye + s * a + t * b;
    }
    Long3 support = Long3::Zero();
    for (const Vec3& h : half) {
      const Long3 l = h.cast<long double>();
      support += n.dot(l) < 0 ? Long3(-l) : l;
    }
    const Vec3 p = nudged(vertex.cast<double>(), f);
    if (c.kind == Kind::Aabb) {
      // The vertex itself is kept exact.
      for (int i = 0; i < 3; ++i) {
        const double across = static_cast<double>(2 * support[i]);
        c.aabb.min[i] = std::min(p[i], p[i] - across), c.aabb.max[i] = std::max(p[i], p[i] - across);
      }
      return;
    }
    if (c.kind == Kind::Sphere) {
      // A radius of 0 where the centre must be on the plane exactly.
      if (f.place == Place::OnGrid || f.place == Place::AtCorner) radius *= static_cast<double>(below(2));
      const long double length = n.stableNorm();
      support = length > 0 ? Long3(n * (static_cast<long double>(radius) / length)) : Long3::Zero();
    }
    setCenter(c, (p.cast<long double>() - support).cast<double>(), half, radius);
  }

  Vec3 nudged(Vec3 p, const Family& f) {
    if (f.place == Place::OnGrid || f.place == Place::AtCorner || below(2) == 0) return p;
    for (double& x : p) {
      for (std::size_t i = below(4); i > 0; --i)
        x = std::nextafter(x, below(2) != 0 ? HUGE_VAL : -HUGE_VAL);
    }
    return p;
  }

  void anyDoubles(Case& c) {
    c.eye = below(2) != 0 ? Vec3::Zero() : any3();
    c.a = any3(), c.b = any3();
    setCenter(c, any3(), {any3(), any3(), any3()}, std::abs(anyDouble()));
    if (c.kind == Kind::Aabb) {
      const Vec3 p = any3(), q = any3();
      c.aabb.min = p.cwiseMin(q), c.aabb.max = p.cwiseMax(q);
    }
  }

  std::uint64_t state_;
  Vec3 eye_ = Vec3::Zero(), depth_ = Vec3::UnitZ();
  std::array<Vec3, 4> corners_;
  int order_ = 0;
};

struct Counts {
  std::uint64_t cases = 0, touching = 0, outside = 0, inside = 0, wronglyOutside = 0, wronglyInside = 0;
  std::uint64_t excess = 0, exact = 0;
  std::uint64_t plainDouble = 0, relativeFloat = 0, worldFloat = 0;  ///< drops of tests without a bound
};

void count(const Case& c, Counts& counts, std::string& example) {
  Judge judge(c);
  const bool outside = judge.outside();
  const Side side = classify(c);
  ++counts.cases;
  counts.touching += outside ? 0 : 1;
  bool wrong = false;
  if (side == Side::Outside) {
    ++counts.outside;
    if (!outside) ++counts.wronglyOutside, wrong = true;
  } else if (side == Side::Inside) {
    ++counts.inside;
    if (!judge.inside()) ++counts.wronglyInside, wrong = true;
  }
  if (outside && side != Side::Outside) ++counts.excess;
  if (!outside) {
    counts.plainDouble += plainlyOutside<double>(c, c.eye) ? 1 : 0;
    counts.relativeFloat += plainlyOutside<float>(c, c.eye) ? 1 : 0;
    counts.worldFloat += plainlyOutside<float>(c, Vec3::Zero()) ? 1 : 0;
  }
  counts.exact += static_cast<std::uint64_t>(judge.exact());
  if (wrong && example.empty()) {
    std::ostringstream out;
    out << (side == Side::Outside ? "wrongly outside: " : "wrongly inside: ") << c;
    example = out.str();
  }
}

void printTable(const std::vector<Counts>& all, std::uint64_t seed) {
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf("seed %llu; drops of tests without a bound are per million boxes not outside\n", number(seed));
  std::printf("%-26s %10s %9s %9s %6s %6s %10s %9s | %9s %9s %9s\n", "family", "cases", "outside", "inside",
              "drops", "wrong", "excess", "by exact", "double", "float rel", "float wrld");
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Counts& c = all[i];
    const auto perMillion = [&c](std::uint64_t n) {
      return 1e6 * static_cast<double>(n) / static_cast<double>(std::max<std::uint64_t>(c.touching, 1));
    };
    std::printf("%-26s %10llu %9llu %9llu %6llu %6llu %10llu %9llu | %9.0f %9.0f %9.0f\n", kFamilies[i].name,
                number(c.cases), number(c.outside), number(c.inside), number(c.wronglyOutside),
                number(c.wronglyInside), number(c.excess), number(c.exact), perMillion(c.plainDouble),
                perMillion(c.relativeFloat), perMillion(c.worldFloat));
  }
}

TEST(Exactness, BoxesAgainstPlanes) {
  const char* wanted = std::getenv("TESSERA_EXACT_CASES");
  const std::uint64_t total = wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 1'000'000;
  constexpr std::uint64_t kSeed = 2006;
  constexpr std::uint64_t kPerFrustum = 16;
  std::vector<Counts> all(kFamilies.size());
  Counts sum;
  for (std::size_t i = 0; i < kFamilies.size(); ++i) {
    const Family& family = kFamilies[i];
    Generator generator(kSeed + i);
    std::string example;
    const bool plain = family.place != Place::Touching && family.place != Place::AtCorner &&
                       family.place != Place::OnGrid && family.place != Place::AnyDoubles;
    for (std::uint64_t k = 0; k < total / kFamilies.size() + 1; ++k) {
      if (k % kPerFrustum == 0) generator.newFrustum(family);
      count(generator.next(family), all[i], example);
    }
    EXPECT_EQ(all[i].wronglyOutside, 0U) << family.name << ": " << example;
    EXPECT_EQ(all[i].wronglyInside, 0U) << family.name << ": " << example;
    // Where a tile is 3e-7 wide, the rounding of its corners alone is 1e-9 of it.
    if (plain && family.fovDeg != 0.001)
      sum.outside += all[i].outside + all[i].excess, sum.excess += all[i].excess;
  }
  printTable(all, kSeed);
  std::printf("of %llu boxes outside, in families not made to touch, the bound keeps %llu\n",
              static_cast<unsigned long long>(sum.outside), static_cast<unsigned long long>(sum.excess));
  // What the bound costs where boxes are not placed on planes.
  EXPECT_LE(static_cast<double>(sum.excess), 1e-6 * static_cast<double>(sum.outside) + 2);
}

Case sphereCase(const Vec3& a, const Vec3& b, const Sphere& sphere) {
  return {.eye = Vec3::Zero(), .a = a, .b = b, .kind = Kind::Sphere, .sphere = sphere};
}

void expectNotDropped(const Case& c) {
  ASSERT_GE(exactSign(c, 1), 0);
  EXPECT_NE(classify(c), Side::Outside);
}

TEST(BoundedPlane, SphereAtAPlaneOfNearlyEqualCorners) {
  // The square of the normal's length underflows.
  for (const double z : {0.5, -0.5})
    expectNotDropped(sphereCase(Vec3(1, 0, 0), Vec3(1, 1e-200, 0), {Vec3(0, 0, z), 1}));
}

TEST(BoundedPlane, DenormalSpheres) {
  // Products with the normal round to multiples of the smallest double.
  const double tiny = 0x1p-1074;
  for (int x = -9; x < 10; ++x) {
    for (int y = -9; y < 10; ++y) {
      const Case c = sphereCase(Vec3(0.3, 0.7, 0), Vec3(0.2, 0.1, 0.9), {Vec3(x * tiny, y * tiny, tiny), 0});
      if (exactSign(c, 1) >= 0) expectNotDropped(c);
      EXPECT_FALSE(classify(c) == Side::Inside && exactSign(c, -1) < 0);
    }
  }
}

TEST(BoundedPlane, SumsThatOverflow) {
  // n = (1, 1, -1) up to scale and order: two terms of the sum together are beyond the largest double,
  // whichever way it is added up; so is the sum of the other box's corners.
  for (int turn = 0; turn < 3; ++turn) {
    const auto v = [turn](double x, double y, double z) {
      const std::array p = {x, y, z};
      const auto at = [&](int i) { return 1e308 * p[static_cast<std::size_t>((i + turn) % 3)]; };
      return Vec3(at(0), at(1), at(2));
    };
    Case c{.eye = Vec3::Zero(), .a = v(0, -1, -1), .b = v(1, 0, 1), .kind = Kind::Obb};
    c.obb = {v(-1, -1, -1.4), {v(0.3, 0, 0), v(0, 0.3, 0), v(0, 0, 0.1)}};
    expectNotDropped(c);
    c.kind = Kind::Aabb;
    c.aabb.min = v(-1, -0.1, -1), c.aabb.max = v(-0.9, 0.5, -0.5);
    expectNotDropped(c);
  }
}

}  // namespace
}  // namespace tessera
