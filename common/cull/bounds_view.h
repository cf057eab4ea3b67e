#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "common/cull/result.h"
#include "common/geometry/bounded_plane.h"
#include "common/hierarchy/object_hierarchy.h"

// Each view fetches one kind of bound of a node, relative to the eye, and classifies it against planes.
namespace tessera::cull {

/// Of a ball about the centre of a box with perpendicular half-axes.
[[nodiscard]] inline double radiusOf(const RelativeObb& box) {
  return std::sqrt(box.halfAxes[0].squaredNorm() + box.halfAxes[1].squaredNorm() +
                   box.halfAxes[2].squaredNorm());
}

// center(): about which the bound is symmetric; centerRadius(): of a ball there that holds it; reach(): no
// point is farther from the eye; outsideBy(): by how much it is certainly outside a plane.
class SphereView {
 public:
  SphereView(const ObjectHierarchy& oh, std::uint32_t node, const Vec3& eye)
      : sphere_(oh.sphere(node), eye) {}
  Side side(const BoundedPlane& plane, TestCounts& counts) const {
    ++counts.sphere;
    return classify(sphere_, plane);
  }
  [[nodiscard]] const Vec3& center() const { return sphere_.d; }
  [[nodiscard]] double outsideBy(const BoundedPlane& plane) const {
    return tessera::outsideBy(sphere_, plane);
  }
  [[nodiscard]] double reach() const { return sphere_.magnitude.sum(); }
  [[nodiscard]] double centerRadius() const { return sphere_.sphereRadius; }

 private:
  RelativeSphere sphere_;
};

class AabbView {
 public:
  AabbView(const ObjectHierarchy& oh, std::uint32_t node, const Vec3& eye) : AabbView(oh.aabb(node), eye) {}
  AabbView(const Aabb& box, const Vec3& eye) : box_(box, eye) {}
  Side side(const BoundedPlane& plane, TestCounts& counts) const {
    ++counts.aabb;
    return classify(box_, plane);
  }
  [[nodiscard]] const Vec3& center() const { return box_.d; }
  [[nodiscard]] double outsideBy(const BoundedPlane& plane) const { return tessera::outsideBy(box_, plane); }
  [[nodiscard]] double reach() const { return box_.magnitude.sum(); }
  [[nodiscard]] double centerRadius() const { return box_.half.norm(); }

 private:
  RelativeAabb box_;
};

class ObbView {
 public:
  ObbView(const ObjectHierarchy& oh, std::uint32_t node, const Vec3& eye) : box_(oh.obb(node), eye) {}
  Side side(const BoundedPlane& plane, TestCounts& counts) const {
    ++counts.obb;
    return classify(box_, plane);
  }
  [[nodiscard]] const Vec3& center() const { return box_.d; }
  [[nodiscard]] double outsideBy(const BoundedPlane& plane) const { return tessera::outsideBy(box_, plane); }
  [[nodiscard]] double reach() const { return box_.magnitude.sum(); }
  [[nodiscard]] double centerRadius() const { return radiusOf(box_); }

 private:
  RelativeObb box_;
};

/// An AABB by its corners: the p-vertex lies farthest along a plane's normal, the n-vertex nearest; the signs
/// of the normal choose them (term project, section 2.4). A corner's coordinate is one rounded difference and
/// the dot product three products: 5u|n_i| a component of the corner, within the plane's 12u|n_i|.
class AabbCornersView {
 public:
  AabbCornersView(const ObjectHierarchy& oh, std::uint32_t node, const Vec3& eye)
      : corners_{Vec3(oh.aabb(node).min - eye), Vec3(oh.aabb(node).max - eye)},
        // The second term is 0, or NaN where one corner is not finite: a maximum alone may lose that.
        magnitude_(corners_[0].cwiseAbs().cwiseMax(corners_[1].cwiseAbs()) +
                   0.0 * (corners_[0] + corners_[1])),
        center_(0.5 * corners_[0] + 0.5 * corners_[1]) {}
  Side side(const BoundedPlane& plane, TestCounts& counts) const {
    ++counts.aabb;
    const double error = plane.errorPerUnit.dot(magnitude_) + plane.errorConstant;
    if (valueAt(plane, 1) + error < 0) return Side::Outside;
    if (valueAt(plane, 0) - error >= 0) return Side::Inside;
    return Side::Intersecting;
  }
  [[nodiscard]] const Vec3& center() const { return center_; }
  [[nodiscard]] double outsideBy(const BoundedPlane& plane) const {
    return -(valueAt(plane, 1) + plane.errorPerUnit.dot(magnitude_) + plane.errorConstant);
  }
  [[nodiscard]] double reach() const { return magnitude_.sum(); }
  [[nodiscard]] double centerRadius() const { return 0.5 * (corners_[1] - corners_[0]).norm(); }

 private:
  /// At the p-vertex (1) or the n-vertex (0).
  [[nodiscard]] double valueAt(const BoundedPlane& plane, unsigned vertex) const {
    const Vec3& n = plane.normal;
    const auto at = [&](int i) { return n[i] * corners_[vertex ^ unsigned{std::signbit(n[i])}][i]; };
    return at(0) + at(1) + at(2) - plane.distance;
  }

  std::array<Vec3, 2> corners_;
  Vec3 magnitude_, center_;
};

/// AABB for moving nodes, OBB for the others.
class HybridView {
 public:
  HybridView(const ObjectHierarchy& oh, std::uint32_t node, const Vec3& eye) {
    if (oh.isMoving(node)) {
      aabb_.emplace(oh.aabb(node), eye);
    } else {
      obb_.emplace(oh.obb(node), eye);
    }
  }
  Side side(const BoundedPlane& plane, TestCounts& counts) const {
    if (obb_) return ++counts.obb, classify(*obb_, plane);
    return ++counts.aabb, classify(*aabb_, plane);
  }
  [[nodiscard]] const Vec3& center() const { return obb_ ? obb_->d : aabb_->d; }
  [[nodiscard]] double outsideBy(const BoundedPlane& plane) const {
    return obb_ ? tessera::outsideBy(*obb_, plane) : tessera::outsideBy(*aabb_, plane);
  }
  [[nodiscard]] double centerRadius() const { return obb_ ? radiusOf(*obb_) : aabb_->half.norm(); }
  [[nodiscard]] double reach() const { return obb_ ? obb_->magnitude.sum() : aabb_->magnitude.sum(); }

 private:
  std::optional<RelativeAabb> aabb_;
  std::optional<RelativeObb> obb_;
};

/// A cheap view first, an exacter one only where the first is cut. Both hold the geometry, so either may
/// decide.
template <class First, class Then>
class FirstThen {
 public:
  FirstThen(const ObjectHierarchy& oh, std::uint32_t node, const Vec3& eye)
      : oh_(&oh), eye_(&eye), node_(node), first_(oh, node, eye) {}
  Side side(const BoundedPlane& plane, TestCounts& counts) {
    const Side side = first_.side(plane, counts);
    if (side != Side::Intersecting) return side;
    if (!then_) then_.emplace(*oh_, node_, *eye_);
    return then_->side(plane, counts);
  }
  [[nodiscard]] const Vec3& center() const { return first_.center(); }
  [[nodiscard]] double outsideBy(const BoundedPlane& plane) const {
    return then_ ? std::max(first_.outsideBy(plane), then_->outsideBy(plane)) : first_.outsideBy(plane);
  }
  [[nodiscard]] double reach() const { return first_.reach(); }
  [[nodiscard]] double centerRadius() const { return first_.centerRadius(); }

 private:
  const ObjectHierarchy* oh_;
  const Vec3* eye_;
  std::uint32_t node_;
  First first_;
  std::optional<Then> then_;
};

}  // namespace tessera::cull
