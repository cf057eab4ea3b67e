#pragma once

#include "common/geometry/vec.h"
#include "common/hierarchy/frustum_hierarchy.h"

namespace tessera {

/// A frustum hierarchy in the coordinates of a model that is placed in the world, so that one object
/// hierarchy serves a model that moves as a whole, or many instances of it, without being rebuilt (the
/// model-space test of Koblizek's term project, section 2.3). The eye is the model's origin: the planes
/// carry their distance.
class PlacedFrusta : public FrustumHierarchy {
 public:
  /// World coordinates are A x + t for a point x of the model, exactly, with the matrix's doubles. The last
  /// row must be 0 0 0 1. A may be singular or mirror. Does not allocate while the topology stays the same.
  void update(const FrustumHierarchy& world, const Mat4& modelToWorld);

 private:
  void place(FrustumPlanes& planes, const Mat3& linear, const Vec3& offset) const;
};

/// The plane in model coordinates: world points relative to the eye are linear * x + offset, where `offset`
/// is fl(translation - eye).
///
/// Derivation: with p = A x + tau the exact value differs from n.p - D by at most E.|p| + E0, and
/// n.p - D = (A^T n).x - (D - n.tau). The computed normal errs by 3u |A|^T|n|, tau by u|tau|, its dot product
/// by 3u|n|.|tau|, the difference by u|D'|; |p| <= |A||x| + |tau|. Testing in model space rounds by
/// 12u|n'|.|x| as everywhere (BoundedPlane), and by at most 5u|D'|. So E' = |A|^T (E + 4u|n|) + 12u|n'| and
/// E0' = E0 + (E + 6u|n|).|tau| + 8u|D'|, with a little for their own rounding.
[[nodiscard]] BoundedPlane inModelSpace(const BoundedPlane& plane, const Mat3& linear, const Vec3& offset);

}  // namespace tessera
