#include "common/scene/motion/deform_bounds.h"

#include <algorithm>
#include <array>
#include <vector>

#include "common/hierarchy/object_hierarchy.h"
#include "common/hierarchy/transformed_bounds.h"

namespace tessera::motion {

namespace {

/// Of the magnitudes in a sum: a result rounded to float errs by 2^-24 of itself, the sum of a vertex's
/// weights by at most 8 times that; the doubles in between do not count beside it.
constexpr double kRounding = 0x1p-20;
/// Below it a float has no relative accuracy.
constexpr double kLeastFloat = 0x1p-126;

std::array<Vec3, 8> cornersOf(const Aabb& box) {
  std::array<Vec3, 8> corners;
  for (unsigned i = 0; i < 8; ++i) {
    corners[i] = Vec3((i & 1 ? box.max : box.min).x(), (i & 2 ? box.max : box.min).y(),
                      (i & 4 ? box.max : box.min).z());
  }
  return corners;
}

}  // namespace

Aabb morphed(const Aabb& box, std::span<const Aabb> targets, std::span<const float> weights) {
  if (box.empty()) return box;
  Aabb sum = box;
  Vec3 magnitude = box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs());
  for (std::size_t i = 0; i < std::min(targets.size(), weights.size()); ++i) {
    if (targets[i].empty() || weights[i] == 0) continue;
    const double weight = static_cast<double>(weights[i]);
    const Vec3 a = weight * targets[i].min, b = weight * targets[i].max;
    sum.min += a.cwiseMin(b);
    sum.max += a.cwiseMax(b);
    magnitude += a.cwiseAbs().cwiseMax(b.cwiseAbs());
  }
  sum.inflate(kRounding * magnitude + Vec3::Constant(kLeastFloat));
  return sum;
}

Bounds morphedBounds(const Aabb& box, std::span<const Aabb> targets, std::span<const float> weights) {
  return boundsOf(cornersOf(morphed(box, targets, weights)), Vec3::Zero());
}

std::optional<Bounds> skinnedBounds(const Deformation& deformation, std::span<const float> joints,
                                    std::span<const float> weights, const Vec3& origin) {
  std::vector<Vec3> points;
  points.reserve(8 * deformation.jointBoxes.size());
  Vec3 magnitude = Vec3::Zero();
  for (std::size_t joint = 0; joint < deformation.jointBoxes.size(); ++joint) {
    if (deformation.jointBoxes[joint].empty()) continue;
    const Aabb box = morphed(deformation.jointBoxes[joint], deformation.targetBoxes, weights);
    const Eigen::Matrix<double, 3, 4> map =
        Eigen::Map<const Eigen::Matrix<float, 3, 4>>(joints.data() + 12 * joint).cast<double>();
    const Vec3 reach = box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs());
    magnitude = magnitude.cwiseMax(map.leftCols<3>().cwiseAbs() * reach + map.col(3).cwiseAbs());
    for (const Vec3& corner : cornersOf(box))
      points.emplace_back(origin + (map.leftCols<3>() * corner + map.col(3)));
  }
  const Vec3 margin = kRounding * magnitude + 8 * kUnitRoundoff * (origin.cwiseAbs() + magnitude) +
                      Vec3::Constant(kLeastFloat);
  if (points.empty() || !margin.allFinite() || !origin.allFinite()) return std::nullopt;
  const Bounds bounds = boundsOf(points, margin);
  if (!isUsable(bounds)) return std::nullopt;
  return bounds;
}

}  // namespace tessera::motion
