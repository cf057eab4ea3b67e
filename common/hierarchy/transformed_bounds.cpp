#include "common/hierarchy/transformed_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace tessera {

namespace {

constexpr double kFarthest = 1e150;
/// Absorbs underflow: far above the smallest double, far below anything in a scene.
constexpr double kTiny = 1e-290;
constexpr double kU = kUnitRoundoff;

struct Affine {
  Mat3 linear;
  Mat3 size;  ///< absolute values of the linear part
  Vec3 shift;
};

/// A rounded vector and how far the exact one may be from it, per axis.
struct Rounded {
  Vec3 value, error;
};

/// A p + t: each of the four terms of a row is rounded at most four times, so the row errs by less than
/// (4u + 16u^2)(|A||p| + |t|), a sum that is itself known to within 5u.
Rounded image(const Affine& map, const Vec3& p) {
  const Vec3 magnitude = map.size * p.cwiseAbs() + map.shift.cwiseAbs();
  return {map.linear * p + map.shift, 6 * kU * magnitude + Vec3::Constant(kTiny)};
}

Rounded imageOfVector(const Affine& map, const Vec3& v) {
  return {map.linear * v, 6 * kU * (map.size * v.cwiseAbs()) + Vec3::Constant(kTiny)};
}

/// The box about its image's centre, half |A| (half-extents) wide.
Aabb imageOf(const Aabb& box, const Affine& map) {
  const Obb centred = Obb::fromAabb(box);
  const Vec3 half(centred.halfAxes[0].x(), centred.halfAxes[1].y(), centred.halfAxes[2].z());
  const Rounded center = image(map, centred.center);
  Aabb out{center.value, center.value};
  out.inflate((map.size * half) * (1 + 8 * kU) + 1.001 * center.error);
  return out;
}

/// Upper bound of the largest singular value s. s^2 <= |B^T B| in the maximum norm for B = A / scale, whose
/// largest entry is 1. Rounding moves each entry of B^T B by less than 8u s^2 and so a row by 24u s^2.
double stretchOf(const Affine& map) {
  const double scale = map.size.maxCoeff();
  if (!(scale > 0)) return 0;
  const Mat3 b = map.linear / scale;
  const Mat3 gram = b.transpose() * b;
  return scale * std::sqrt(gram.cwiseAbs().rowwise().sum().maxCoeff()) * (1 + 32 * kU);
}

/// About the centre's image. The sum of the errors is no less than their norm, and cannot underflow.
Sphere imageOf(const Sphere& sphere, const Affine& map, double stretch) {
  const Rounded center = image(map, sphere.center);
  return {center.value, (stretch * sphere.radius + center.error.sum()) * (1 + 16 * kU)};
}

Obb boxAround(const Vec3& center, const Vec3& half) {
  Aabb box{center, center};
  box.inflate(half);
  return Obb::fromAabb(box);
}

/// Directions of the image's axes; an axis too thin to have a direction takes one across the others.
/// False where that leaves three that are nearly in one plane, or none.
bool directionsOf(const std::array<Rounded, 3>& axes, const std::array<bool, 3>& thin, Mat3& directions) {
  int solid = 0, last = 0;
  for (int k = 0; k < 3; ++k) {
    if (thin[static_cast<std::size_t>(k)]) continue;
    directions.col(k) = axes[static_cast<std::size_t>(k)].value.normalized();
    ++solid, last = k;
  }
  if (solid == 0) return false;
  const int next = (last + 1) % 3, other = (last + 2) % 3;
  if (solid == 1) {
    directions.col(next) = directions.col(last).unitOrthogonal();
    directions.col(other) = directions.col(last).cross(directions.col(next));
  }
  if (solid == 2) {
    const int gap = thin[static_cast<std::size_t>(next)] ? next : other;
    directions.col(gap) = directions.col((gap + 1) % 3).cross(directions.col((gap + 2) % 3)).normalized();
  }
  return std::abs(directions.determinant()) > 1e-6;
}

/// Let h_k be the computed images of the half-axes and c of the centre. A point of the exact image is
/// c + d + sum t_k h_k with |t_k| <= 1 and |d| <= e, e being the sum of all errors. We store axes
/// S_k = fl(m_k n_k) along the rounded directions n_k with lengths m_k >= l_k = |h_k|. Then
///   h_k = l_k n_k + (at most 2u |h_k|),   n_k = (S_k + (at most u m_k |n_k|)) / m_k,
/// so the point is c + d' + sum (t_k l_k / m_k) S_k with |d'| <= e + 8u sum |h_k| =: slack, which does not
/// depend on m. It is in the stored box where l_k / m_k + |S^-1| slack <= 1, that is (rows of S^-1 are those
/// of N^-1 over m_k) where m_k >= l_k + |N^-1| slack. The rows of N^-1 are the cross products of the other
/// two directions over the determinant, which is above 1e-6: its error and theirs (below 16u) are far
/// within the factor 1.001. An axis no longer than the slack has no direction to keep: it goes into the
/// slack with its whole length, and l_k is 0.
Obb imageOf(const Obb& box, const Affine& map) {
  const Rounded center = image(map, box.center);
  std::array<Rounded, 3> axes;
  Vec3 reach = Vec3::Zero(), slack = center.error;
  for (std::size_t k = 0; k < 3; ++k) {
    axes[k] = imageOfVector(map, box.halfAxes[k]);
    reach += axes[k].value.cwiseAbs();
    slack += axes[k].error + 8 * kU * axes[k].value.cwiseAbs();
  }
  slack *= 1.001;
  // Below this a direction is not accurate; squares are, above it.
  const double thinnest = std::max(slack.maxCoeff(), 1e-140);
  std::array<bool, 3> thin{};
  for (std::size_t k = 0; k < 3; ++k) {
    thin[k] = axes[k].value.cwiseAbs().maxCoeff() <= thinnest;
    if (thin[k]) slack += 1.001 * axes[k].value.cwiseAbs();
  }
  Mat3 directions = Mat3::Zero();
  if (!directionsOf(axes, thin, directions))
    return boxAround(center.value, 1.001 * slack + reach * (1 + 8 * kU));

  Obb out;
  out.center = center.value;
  const double determinant = std::abs(directions.determinant());
  for (int k = 0; k < 3; ++k) {
    const Vec3 across = directions.col((k + 1) % 3).cross(directions.col((k + 2) % 3)).cwiseAbs();
    const double padding = 1.001 * (across + Vec3::Constant(16 * kU)).dot(slack) / determinant;
    const double length =
        thin[static_cast<std::size_t>(k)] ? 0 : axes[static_cast<std::size_t>(k)].value.norm();
    out.halfAxes[static_cast<std::size_t>(k)] =
        (length * (1 + 4 * kU) + padding) * (1 + 4 * kU) * directions.col(k);
  }
  return out;
}

bool isNear(const Vec3& v) {
  return (v.array().abs() <= kFarthest).all();  // false for NaN
}

}  // namespace

bool isUsable(const Bounds& bounds) {
  bool usable = isNear(bounds.aabb.min) && isNear(bounds.aabb.max) && isNear(bounds.obb.center) &&
                isNear(bounds.sphere.center) && bounds.sphere.radius >= 0 &&
                bounds.sphere.radius <= kFarthest &&
                (bounds.aabb.min.array() <= bounds.aabb.max.array()).all();
  for (const Vec3& axis : bounds.obb.halfAxes)
    usable = usable && isNear(axis);
  return usable;
}

std::optional<Bounds> transformed(const Bounds& bounds, const Mat4& map, BoxFit fit) {
  if (!map.allFinite() || map.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) return std::nullopt;
  Bounds out = bounds;
  if (map != Mat4::Identity()) {
    Affine affine;
    affine.linear = map.topLeftCorner<3, 3>();
    affine.size = affine.linear.cwiseAbs();
    affine.shift = map.topRightCorner<3, 1>();
    out.aabb = imageOf(bounds.aabb, affine);
    out.sphere = imageOf(bounds.sphere, affine, stretchOf(affine));
    if (fit == BoxFit::Pca) out.obb = imageOf(bounds.obb, affine);
  }
  if (fit == BoxFit::AxisAligned) out.obb = Obb::fromAabb(out.aabb);
  if (!isUsable(out)) return std::nullopt;
  return out;
}

}  // namespace tessera
