// Every vertex that a tile makes lies in the bounds, and the bounds are not much larger.
#include "common/scene/motion/deform_bounds.h"

#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace tessera::motion {
namespace {

using Map = Eigen::Matrix<float, 3, 4>;

/// How far outside of the bounds a point lies, as far as doubles tell; not positive inside.
double outside(const Bounds& bounds, const Vec3& p) {
  double most = (bounds.aabb.min - p).cwiseMax(p - bounds.aabb.max).maxCoeff();
  most = std::max(most, (p - bounds.sphere.center).norm() - bounds.sphere.radius);
  Mat3 axes;
  for (int k = 0; k < 3; ++k)
    axes.col(k) = bounds.obb.halfAxes[static_cast<std::size_t>(k)];
  const Vec3 t = axes.inverse() * (p - bounds.obb.center);
  return std::max(most, (t.cwiseAbs().maxCoeff() - 1) * axes.norm());
}

struct Case {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::vector<Eigen::Vector3f>> targets;
  std::vector<std::array<std::uint32_t, 4>> joints;
  std::vector<std::array<float, 4>> weights;
  Deformation deformation;
  Aabb box;
};

Case anyCase(std::mt19937_64& random, std::size_t jointCount, std::size_t targetCount) {
  std::uniform_real_distribution<float> unit(-1, 1), unit01(0, 1);
  Case made;
  const auto vector = [&](float size) {
    return Eigen::Vector3f(size * Eigen::Vector3f(unit(random), unit(random), unit(random)));
  };
  made.targets.resize(targetCount);
  made.deformation.jointBoxes.resize(jointCount);
  made.deformation.targetBoxes.resize(targetCount);
  for (int i = 0; i < 60; ++i) {
    made.vertices.push_back(vector(2) + Eigen::Vector3f(5, 0, 0));
    made.box.extend(made.vertices.back().cast<double>());
    for (std::size_t t = 0; t < targetCount; ++t) {
      made.targets[t].push_back(vector(0.5F));
      made.deformation.targetBoxes[t].extend(made.targets[t].back().cast<double>());
    }
    std::array<std::uint32_t, 4> joints{};
    std::array<float, 4> weights{};
    float sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      joints[k] = static_cast<std::uint32_t>(random() % std::max<std::size_t>(jointCount, 1));
      weights[k] = random() % 3 == 0 ? 0 : unit01(random);
      sum += weights[k];
    }
    if (sum == 0) weights[0] = sum = 1;
    for (std::size_t k = 0; k < 4; ++k) {
      weights[k] /= sum;
      if (weights[k] > 0 && jointCount > 0)
        made.deformation.jointBoxes[joints[k]].extend(made.vertices.back().cast<double>());
    }
    made.joints.push_back(joints);
    made.weights.push_back(weights);
  }
  return made;
}

Vec3 morphedVertex(const Case& c, std::size_t vertex, std::span<const float> weights) {
  Vec3 p = c.vertices[vertex].cast<double>();
  for (std::size_t t = 0; t < c.targets.size(); ++t)
    p += static_cast<double>(weights[t]) * c.targets[t][vertex].cast<double>();
  return p;
}

TEST(DeformBounds, HoldEveryMorphedVertex) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<float> weight(-1, 2);
  for (int round = 0; round < 500; ++round) {
    const Case c = anyCase(random, 0, 3);
    const std::vector<float> weights = {weight(random), round % 2 == 0 ? 0 : weight(random), weight(random)};
    const Bounds bounds = morphedBounds(c.box, c.deformation.targetBoxes, weights);
    Aabb tight;
    for (std::size_t v = 0; v < c.vertices.size(); ++v) {
      const Vec3 p = morphedVertex(c, v, weights).cast<float>().cast<double>();
      ASSERT_LE(outside(bounds, p), 0);
      tight.extend(p);
    }
    // The Minkowski sum is no larger than the base's box grown by all displacements.
    const double grown = 0.5 * (std::abs(weights[0]) + std::abs(weights[1]) + std::abs(weights[2])) + 1e-4;
    EXPECT_LE((c.box.min - bounds.aabb.min).maxCoeff(), grown);
    EXPECT_LE((bounds.aabb.max - c.box.max).maxCoeff(), grown);
  }
}

TEST(DeformBounds, HoldEverySkinnedVertexNearAndFar) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::normal_distribution<float> normal;
  double grown = 0;
  for (int round = 0; round < 600; ++round) {
    const std::size_t jointCount = 1 + random() % 6, targetCount = random() % 3;
    const Case c = anyCase(random, jointCount, targetCount);
    std::vector<float> joints(12 * jointCount), weights(targetCount);
    for (std::size_t j = 0; j < jointCount; ++j) {
      Map map;
      map.leftCols<3>() =
          Eigen::Quaternionf(normal(random), normal(random), normal(random), normal(random)).normalized() *
          Eigen::Scaling(1 + 0.3F * unit(random));
      map.col(3) = 3 * Eigen::Vector3f(unit(random), unit(random), unit(random));
      std::copy_n(map.data(), 12, joints.data() + 12 * j);
    }
    for (float& w : weights)
      w = unit(random);
    const double far = round % 3 == 0 ? 0 : std::pow(10.0, round % 8);
    const Vec3 origin(far, -far / 3, far / 7);
    const auto bounds = skinnedBounds(c.deformation, joints, weights, origin);
    ASSERT_TRUE(bounds);
    Aabb tight;
    for (std::size_t v = 0; v < c.vertices.size(); ++v) {
      const Vec3 p = morphedVertex(c, v, weights);
      Vec3 sum = Vec3::Zero();
      for (std::size_t k = 0; k < 4; ++k) {
        const Map map = Eigen::Map<const Map>(joints.data() + std::size_t{12} * c.joints[v][k]);
        sum += static_cast<double>(c.weights[v][k]) *
               (map.leftCols<3>().cast<double>() * p + map.col(3).cast<double>());
      }
      const Vec3 drawn = sum.cast<float>().cast<double>() + origin;
      ASSERT_LE(outside(*bounds, drawn), 0) << "round " << round << ", far " << far;
      tight.extend(drawn);
    }
    grown = std::max(grown, (bounds->aabb.max - bounds->aabb.min).norm() / (tight.max - tight.min).norm());
  }
  EXPECT_LT(grown, 6) << "boxes of joints, not of everything";
}

TEST(DeformBounds, TellWhatIsNotFinite) {
  Deformation deformation;
  deformation.jointBoxes.resize(2);
  std::vector<float> joints(24, 0);
  EXPECT_FALSE(skinnedBounds(deformation, joints, {}, Vec3::Zero())) << "no joint moves anything";
  deformation.jointBoxes[1].extend(Vec3(1, 2, 3));
  EXPECT_TRUE(skinnedBounds(deformation, joints, {}, Vec3::Zero()));
  joints[15] = INFINITY;
  EXPECT_FALSE(skinnedBounds(deformation, joints, {}, Vec3::Zero()));
}

}  // namespace
}  // namespace tessera::motion
