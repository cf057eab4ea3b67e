#include "client/leaf_deformer.h"

#include <algorithm>
#include <string>

#include <Eigen/Core>
#include <Eigen/LU>

#include "common/geometry/vec.h"
#include "common/scene/deform_arrays.h"

namespace tessera {

namespace {

using JointMap = Eigen::Matrix<double, 3, 4>;

template <class Array>
osg::ref_ptr<const Array> take(osg::Geometry& mesh, unsigned int index) {
  return index < mesh.getNumVertexAttribArrays() ? dynamic_cast<Array*>(mesh.getVertexAttribArray(index))
                                                 : nullptr;
}

Vec3 toVec3(const osg::Vec3& v) {
  return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}

osg::Vec3 toOsg(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

Error unfit() {
  return runtimeError("", "carries joints or morph targets that do not fit its vertices");
}

}  // namespace

const DeformSource* DeformSource::of(const osg::Drawable& drawable) {
  return dynamic_cast<const DeformSource*>(drawable.getUserData());
}

Status DeformSource::takeFrom(osg::Drawable& drawable) {
  osg::Geometry* mesh = drawable.asGeometry();
  if (!mesh || mesh->getNumVertexAttribArrays() == 0) return Done{};
  osg::ref_ptr<DeformSource> source = new DeformSource;
  source->vertices = dynamic_cast<osg::Vec3Array*>(mesh->getVertexArray());
  source->normals = dynamic_cast<osg::Vec3Array*>(mesh->getNormalArray());
  for (unsigned int set = 0; set < kMaxJointSets; ++set) {
    JointSet one{take<osg::Vec4usArray>(*mesh, jointArray(set)),
                 take<osg::Vec4Array>(*mesh, weightArray(set))};
    if (one.joints && one.weights) source->jointSets.push_back(std::move(one));
  }
  for (unsigned int target = 0;; ++target) {
    Target one{take<osg::Vec3Array>(*mesh, displacementArray(target)),
               take<osg::Vec3Array>(*mesh, normalChangeArray(target))};
    if (!one.displacements) break;
    source->targets.push_back(std::move(one));
  }
  if (source->jointSets.empty() && source->targets.empty()) return Done{};  // some file's own attributes
  mesh->getVertexAttribArrayList().clear();

  if (!source->vertices) return unfit();
  const std::size_t count = source->vertices->size();
  if (source->normals && source->normals->size() != count) source->normals = nullptr;
  bool fits = true;
  for (const JointSet& set : source->jointSets) {
    fits = fits && set.joints->size() == count && set.weights->size() == count;
    for (const osg::Vec4us& joints : *set.joints) {
      for (unsigned int k = 0; k < 4; ++k)
        source->jointCount = std::max(source->jointCount, joints[k] + 1U);
    }
  }
  for (const Target& target : source->targets) {
    fits = fits && target.displacements->size() == count &&
           (!target.normalChanges || target.normalChanges->size() == count);
  }
  if (!fits) return unfit();
  mesh->setUserData(source);
  return Done{};
}

LeafDeformer::LeafDeformer(const osg::Geometry& original)
    : source_(DeformSource::of(original)),
      geometry_(new osg::Geometry(original, osg::CopyOp::SHALLOW_COPY)),
      vertices_(new osg::Vec3Array(*source_->vertices)) {
  geometry_->setDataVariance(osg::Object::DYNAMIC);
  geometry_->setVertexArray(vertices_);
  if (source_->normals) {
    normals_ = new osg::Vec3Array(*source_->normals);
    geometry_->setNormalArray(normals_);
  }
}

Status LeafDeformer::pose(std::span<const float> joints, std::span<const float> weights) {
  if (!joints.empty()) {
    if (joints.size() < 12 * std::size_t{source_->jointCount})
      return runtimeError("", "has " + std::to_string(joints.size() / 12) + " joints where " +
                                  std::to_string(source_->jointCount) + " are needed");
    joints_.assign(joints.begin(), joints.end());
  }
  if (!weights.empty()) {
    if (weights.size() != source_->targets.size())
      return runtimeError("", "has " + std::to_string(weights.size()) + " weights for " +
                                  std::to_string(source_->targets.size()) + " morph targets");
    weights_.assign(weights.begin(), weights.end());
  }
  isStale_ = true;
  return Done{};
}

void LeafDeformer::apply() {
  if (!isStale_) return;
  isStale_ = false;
  std::vector<JointMap> maps;
  for (std::size_t i = 0; i + 11 < joints_.size(); i += 12)
    maps.emplace_back(Eigen::Map<const Eigen::Matrix<float, 3, 4>>(joints_.data() + i).cast<double>());
  for (std::size_t v = 0; v < vertices_->size(); ++v) {
    Vec3 p = toVec3((*source_->vertices)[v]);
    Vec3 n = normals_ ? toVec3((*source_->normals)[v]) : Vec3::UnitZ();
    for (std::size_t t = 0; t < weights_.size(); ++t) {
      const double weight = static_cast<double>(weights_[t]);
      if (weight == 0) continue;
      p += weight * toVec3((*source_->targets[t].displacements)[v]);
      if (source_->targets[t].normalChanges) n += weight * toVec3((*source_->targets[t].normalChanges)[v]);
    }
    if (!maps.empty() && !source_->jointSets.empty()) {
      JointMap map = JointMap::Zero();
      for (const DeformSource::JointSet& set : source_->jointSets) {
        for (unsigned int k = 0; k < 4; ++k) {
          const double weight = static_cast<double>((*set.weights)[v][k]);
          if (weight > 0) map += weight * maps[(*set.joints)[v][k]];
        }
      }
      p = map.leftCols<3>() * p + map.col(3);
      // Normals turn with the inverse transpose: the cofactors, up to a scale that is taken off below.
      const Mat3 linear = map.leftCols<3>();
      Mat3 cofactors;
      for (int i = 0; i < 3; ++i) {
        const Vec3 a = linear.col((i + 1) % 3), b = linear.col((i + 2) % 3);
        cofactors.col(i) =
            Vec3(a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x());
      }
      n = cofactors * n;
    }
    (*vertices_)[v] = toOsg(p);
    if (!normals_) continue;
    const double length = n.norm();
    if (length > 0) n /= length;
    (*normals_)[v] = toOsg(n);
  }
  vertices_->dirty();
  if (normals_) normals_->dirty();
  geometry_->dirtyBound();
}

}  // namespace tessera
