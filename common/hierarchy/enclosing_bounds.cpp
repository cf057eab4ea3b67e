#include "common/hierarchy/enclosing_bounds.h"

#include <algorithm>

namespace tessera {

void EnclosingBounds::clear() {
  box_ = {};
  boxes_.clear();
  spheres_.clear();
}

void EnclosingBounds::add(const Aabb& aabb, const Obb& obb, const Sphere& sphere) {
  box_.extend(aabb);
  boxes_.push_back(obb);
  spheres_.push_back(sphere);
}

Bounds EnclosingBounds::result(BoxFit fit) const {
  Bounds bounds;
  bounds.aabb = box_;
  if (fit == BoxFit::Pca) {
    corners_.clear();
    double reach = 0;
    for (const Obb& box : boxes_) {
      for (const Vec3& corner : box.corners()) {
        corners_.push_back(corner);
        reach = std::max(reach, corner.cwiseAbs().maxCoeff());
      }
    }
    // A corner is three rounded sums of numbers no larger than the corner and the box together.
    bounds.obb = pcaObbOf(corners_, Vec3::Constant(16 * kUnitRoundoff * reach));
  } else {
    bounds.obb = Obb::fromAabb(box_);
  }
  // The sphere is about the box's centre: it holds the spheres inside, or the box where that is smaller.
  const Vec3 center = box_.center();
  double reach = 0;
  for (const Sphere& s : spheres_)
    reach = std::max(reach, lengthOf(s.center - center) + s.radius);
  const double diagonal = lengthOf((box_.max - center).cwiseMax(center - box_.min));
  bounds.sphere = {center, std::min(reach, diagonal) * (1 + 16 * kUnitRoundoff) + 0x1p-1060};
  return bounds;
}

}  // namespace tessera
