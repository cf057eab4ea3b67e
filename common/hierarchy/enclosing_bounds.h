#pragma once

#include <vector>

#include "common/geometry/box.h"

namespace tessera {

/// Bounds of geometry in world space; each of the three holds all of it on its own.
struct Bounds {
  Aabb aabb;
  Obb obb;
  Sphere sphere;
};

/// How the oriented box of an inner node is found.
enum class BoxFit {
  Pca,  ///< from the eigenvectors of the corners of the boxes inside (Nirnimesh, Harish, Narayanan 2006)
  AxisAligned,  ///< the axis-aligned box: 11 to 22 times cheaper, looser
};

/// Computes bounds around bounds. Keeps its buffers, so a warm one does not allocate.
class EnclosingBounds {
 public:
  void clear();
  void add(const Bounds& inside) { add(inside.aabb, inside.obb, inside.sphere); }
  void add(const Aabb& aabb, const Obb& obb, const Sphere& sphere);
  /// At least one must have been added.
  [[nodiscard]] Bounds result(BoxFit fit) const;

 private:
  Aabb box_;
  std::vector<Obb> boxes_;
  std::vector<Sphere> spheres_;
  mutable std::vector<Vec3> corners_;
};

}  // namespace tessera
