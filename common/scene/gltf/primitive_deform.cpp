// What deforms a primitive: joints and weights of skins, morph targets.
#include <algorithm>
#include <cmath>

#include "common/scene/deform_arrays.h"
#include "common/scene/gltf/primitive.h"

namespace tessera::gltf {

namespace {

/// As many as a pose may have weights.
constexpr std::size_t kMaxTargets = 4096;

osg::ref_ptr<osg::Vec3Array> vec3Array(const std::vector<float>& values) {
  osg::ref_ptr<osg::Vec3Array> array = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
  array->reserve(values.size() / 3);
  for (std::size_t i = 0; i + 2 < values.size(); i += 3)
    array->push_back({values[i], values[i + 1], values[i + 2]});
  return array;
}

}  // namespace

Status PrimitiveReader::readDeformation() {
  if (deforms_.hasSkin) {
    if (Status status = readJoints(); !status) return status;
  }
  return deforms_.isMorphed ? readTargets() : Status(Done{});
}

Status PrimitiveReader::readJoints() {
  std::vector<osg::ref_ptr<osg::Vec4usArray>> joints;
  std::vector<osg::ref_ptr<osg::Vec4Array>> weights;
  for (unsigned int set = 0;; ++set) {
    const std::string number = std::to_string(set);
    if (accessorOf("JOINTS_" + number) < 0 || accessorOf("WEIGHTS_" + number) < 0) break;
    if (set == kMaxJointSets) {
      warnings_.add("joints", name_ + " has more than " + std::to_string(4 * kMaxJointSets) +
                                  " joints for each vertex; the further ones are left out");
      break;
    }
    const Result<std::vector<float>> numbers = readFloats("JOINTS_" + number, Attribute::Joint);
    if (!numbers) return numbers.error();
    const Result<std::vector<float>> shares = readFloats("WEIGHTS_" + number, Attribute::Weight);
    if (!shares) return shares.error();
    if (Status status = checkFinite(*shares, 4, "WEIGHTS_" + number); !status) return status;
    joints.push_back(new osg::Vec4usArray(osg::Array::BIND_PER_VERTEX));
    weights.push_back(new osg::Vec4Array(osg::Array::BIND_PER_VERTEX));
    for (std::size_t i = 0; i < vertexCount_; ++i) {
      const float* j = numbers->data() + 4 * i;
      const float* w = shares->data() + 4 * i;
      const auto joint = [&](std::size_t k) { return static_cast<GLushort>(j[k]); };
      joints[set]->push_back(osg::Vec4us(joint(0), joint(1), joint(2), joint(3)));
      weights[set]->push_back(
          {std::max(w[0], 0.0F), std::max(w[1], 0.0F), std::max(w[2], 0.0F), std::max(w[3], 0.0F)});
    }
  }
  for (std::size_t i = 0; i < vertexCount_ && !weights.empty(); ++i) {
    float sum = 0;
    for (const auto& set : weights)
      sum += (*set)[i].x() + (*set)[i].y() + (*set)[i].z() + (*set)[i].w();
    // A vertex that follows nothing follows its first joint.
    if (!(sum > 0) || !std::isfinite(sum)) {
      for (const auto& set : weights)
        (*set)[i].set(0, 0, 0, 0);
      (*weights[0])[i].x() = sum = 1;
    }
    for (const auto& set : weights)
      (*set)[i] /= sum;
  }
  for (unsigned int set = 0; set < joints.size(); ++set) {
    geometry_->setVertexAttribArray(jointArray(set), joints[set]);
    geometry_->setVertexAttribArray(weightArray(set), weights[set]);
  }
  return Done{};
}

Status PrimitiveReader::readTargets() {
  if (primitive_.targets.size() > kMaxTargets) {
    warnings_.add("morph targets", name_ + " has more than " + std::to_string(kMaxTargets) +
                                       " morph targets; it keeps its shape");
    return Done{};
  }
  for (unsigned int target = 0; target < primitive_.targets.size(); ++target) {
    const std::string name = "morph target " + std::to_string(target);
    const auto read = [&](const char* attribute, Attribute use) -> Result<osg::ref_ptr<osg::Vec3Array>> {
      const auto found = primitive_.targets[target].find(attribute);
      if (found == primitive_.targets[target].end()) return osg::ref_ptr<osg::Vec3Array>();
      const std::string what = name + " " + attribute;
      const Result<std::size_t> count = accessors_.count(found->second);
      if (!count) return inputError({}, what + ": " + count.error().what, count.error().mend);
      if (*count != accessorCount_)
        return inputError({}, what + " has another number of elements than the mesh", "export it again");
      Result<Elements> elements = accessors_.elements(found->second, use);
      if (!elements) return inputError({}, what + ": " + elements.error().what, elements.error().mend);
      const std::vector<float> values = gathered(*elements);
      if (Status status = checkFinite(values, 3, what); !status) return status.error();
      return vec3Array(values);
    };
    const auto displacements = read("POSITION", Attribute::Displacement);
    if (!displacements) return displacements.error();
    const auto normals = read("NORMAL", Attribute::Displacement);
    if (!normals) return normals.error();
    // A target without any effect keeps its place, so that those after it keep theirs.
    geometry_->setVertexAttribArray(
        displacementArray(target),
        *displacements ? *displacements : vec3Array(std::vector<float>(3 * vertexCount_)));
    if (*normals && geometry_->getNormalArray())
      geometry_->setVertexAttribArray(normalChangeArray(target), *normals);
  }
  return Done{};
}

}  // namespace tessera::gltf
