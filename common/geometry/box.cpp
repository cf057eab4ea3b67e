#include "common/geometry/box.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace tessera {

namespace {

/// One step up: the exact sum of a few doubles lies below nextUp of the rounded one when each step is
/// rounded this way.
Vec3 nextUp(const Vec3& v) {
  return v.unaryExpr([](double x) { return std::nextafter(x, std::numeric_limits<double>::infinity()); });
}
Vec3 nextDown(const Vec3& v) {
  return v.unaryExpr([](double x) { return std::nextafter(x, -std::numeric_limits<double>::infinity()); });
}

/// Columns: the unit eigenvectors of the points' covariance. Falls back to the world axes where the
/// decomposition does not converge (non-finite squares of extreme coordinates).
Mat3 principalAxes(std::span<const Vec3> points, const Vec3& mean, double scale) {
  Mat3 covariance = Mat3::Zero();
  for (const Vec3& p : points) {
    const Vec3 d = (p - mean) / scale;
    covariance.noalias() += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance);
  if (solver.info() != Eigen::Success || !solver.eigenvectors().allFinite()) return Mat3::Identity();
  return solver.eigenvectors();
}

}  // namespace

void Aabb::inflate(const Vec3& margin) {
  min = nextDown(min - margin);
  max = nextUp(max + margin);
}

std::array<Vec3, 8> Obb::corners() const {
  std::array<Vec3, 8> out;
  for (unsigned i = 0; i < 8; ++i) {
    out[i] = center + (i & 1 ? 1 : -1) * halfAxes[0] + (i & 2 ? 1 : -1) * halfAxes[1] +
             (i & 4 ? 1 : -1) * halfAxes[2];
  }
  return out;
}

Obb Obb::fromAabb(const Aabb& box) {
  Obb obb;
  obb.center = box.center();
  // Both differences are rounded up, so that center +- half covers [min, max] although center is rounded.
  const Vec3 half = nextUp((box.max - obb.center).cwiseMax(obb.center - box.min));
  for (int k = 0; k < 3; ++k)
    obb.halfAxes[static_cast<std::size_t>(k)] = half[k] * Vec3::Unit(k);
  return obb;
}

Aabb aabbOf(std::span<const Vec3> points, const Vec3& margin) {
  Aabb box;
  for (const Vec3& p : points)
    box.extend(p);
  box.inflate(margin);
  return box;
}

Sphere sphereOf(std::span<const Vec3> points, const Vec3& center, const Vec3& margin) {
  double reach = 0;
  for (const Vec3& p : points)
    reach = std::max(reach, lengthOf(p - center));
  // The norm of a rounded difference errs by less than 8 u relative; the margin is a vector added to p.
  return {center, (reach + lengthOf(margin)) * (1 + 16 * kUnitRoundoff) + 0x1p-1060};
}

Obb pcaObbOf(std::span<const Vec3> points, const Vec3& margin) {
  const Aabb box = aabbOf(points, margin);
  const Obb axisAligned = Obb::fromAabb(box);
  const Vec3 middle = box.center();
  const double scale = (box.max - middle).maxCoeff();
  if (!(scale > 0) || !std::isfinite(scale)) return axisAligned;

  // Everything below is relative to the box's centre, whose subtraction is one rounding: the magnitude of
  // world coordinates enters only through it.
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points)
    mean += (p - middle) / static_cast<double>(points.size());
  const Mat3 axes = principalAxes(points, middle + mean, scale);

  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  double reach = 0;
  for (const Vec3& p : points) {
    const Vec3 d = p - middle;
    const Vec3 t = axes.transpose() * d;
    low = low.cwiseMin(t), high = high.cwiseMax(t);
    reach = std::max(reach, lengthOf(d));
  }
  const Vec3 centerLocal = 0.5 * (low + high);

  // Bound of the rounding. Let Q be the axes as stored, D = |Q^T Q - I| (Frobenius, measured below), c the
  // stored centre. A point p = c + Q t needs |t_k| <= half_k. The computed t' = Q^T(p - middle) differs from
  // Q^-1(p - middle) by at most (2 D + 4u) reach for D < 1/4; the subtraction from `middle` and the
  // stored centre add u(|middle| + reach) each; the centre's own rounding (Q centerLocal + middle) another
  // 4u(reach + |middle|). Together below pad, which is doubled for second-order terms. `margin` moves a
  // point by at most |Q_k|.margin along axis k.
  const double defect = (axes.transpose() * axes - Mat3::Identity()).norm();
  if (!(defect < 1e-9)) return axisAligned;
  const double pad = 2 * ((2 * defect + 16 * kUnitRoundoff) * reach +
                          8 * kUnitRoundoff * (middle.cwiseAbs().maxCoeff() + reach));
  Obb obb;
  obb.center = middle + axes * centerLocal;
  double volume = 1, boxVolume = 1;
  for (int k = 0; k < 3; ++k) {
    const double spread = axes.col(k).cwiseAbs().dot(margin) * (1 + 8 * kUnitRoundoff);
    const double half = (0.5 * (high[k] - low[k]) + spread + pad) * (1 + 4 * kUnitRoundoff);
    obb.halfAxes[static_cast<std::size_t>(k)] = half * axes.col(k);
    // Flat boxes are compared by their area: a thickness of rounding size says nothing.
    volume *= std::max(half / scale, 1e-6);
    boxVolume *= std::max(axisAligned.halfAxes[static_cast<std::size_t>(k)][k] / scale, 1e-6);
  }
  return volume < boxVolume ? obb : axisAligned;
}

}  // namespace tessera
