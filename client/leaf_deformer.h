#pragma once

#include <span>
#include <vector>

#include <osg/Array>
#include <osg/Drawable>
#include <osg/Geometry>
#include <osg/Referenced>

#include "common/base/result.h"

namespace tessera {

/// What deforms a drawable: taken out of its vertex attributes, so that OpenGL never sees it, and hung at the
/// drawable as its user data. Shared by all leaves that show the drawable.
class DeformSource : public osg::Referenced {
 public:
  /// Takes the arrays of deform_arrays.h out of the drawable, if it has any. Refuses arrays that do not fit
  /// its vertices.
  [[nodiscard]] static Status takeFrom(osg::Drawable& drawable);
  /// Null: nothing deforms it.
  [[nodiscard]] static const DeformSource* of(const osg::Drawable& drawable);

  struct JointSet {
    osg::ref_ptr<const osg::Vec4usArray> joints;
    osg::ref_ptr<const osg::Vec4Array> weights;
  };
  struct Target {
    osg::ref_ptr<const osg::Vec3Array> displacements, normalChanges;  ///< the latter may be null
  };
  osg::ref_ptr<const osg::Vec3Array> vertices, normals;  ///< undeformed; normals may be null
  std::vector<JointSet> jointSets;
  std::vector<Target> targets;
  unsigned int jointCount = 0;  ///< one more than the largest number of a joint
};

/// One leaf's own copy of a drawable's vertices, deformed by the processor when it is about to be drawn.
/// Sums are made in double from what the master sent, and rounded once.
class LeafDeformer : public osg::Referenced {
 public:
  /// Precondition: DeformSource::of(original).
  explicit LeafDeformer(const osg::Geometry& original);

  /// What to draw instead of the original.
  [[nodiscard]] const osg::ref_ptr<osg::Geometry>& geometry() const { return geometry_; }
  /// Empty spans: as they were. Refuses fewer joints or other weights than the drawable asks for.
  [[nodiscard]] Status pose(std::span<const float> joints, std::span<const float> weights);
  /// Brings the vertices up to date; quick where they are.
  void apply();

 private:
  osg::ref_ptr<const DeformSource> source_;
  osg::ref_ptr<osg::Geometry> geometry_;
  osg::ref_ptr<osg::Vec3Array> vertices_, normals_;
  std::vector<float> joints_, weights_;
  bool isStale_ = false;
};

}  // namespace tessera
