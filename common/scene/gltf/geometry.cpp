#include "common/scene/gltf/geometry.h"

#include <string>

#include "common/scene/gltf/primitive.h"

namespace tessera::gltf {

Result<const std::vector<Leaf>*> Geometries::leaves(int meshIndex, bool isMirrored) {
  auto found = meshes_.find({meshIndex, isMirrored});
  if (found == meshes_.end()) {
    MeshLeaves made;
    if (isMirrored) {
      Result<const std::vector<Leaf>*> plain = leaves(meshIndex, false);
      if (!plain) return plain;
      made.leaves = mirror(**plain);
    } else {
      Result<std::vector<Leaf>> plain = makeLeaves(meshIndex);
      if (!plain) return plain.error();
      made.leaves = std::move(*plain);
    }
    found = meshes_.emplace(std::pair(meshIndex, isMirrored), std::move(made)).first;
  }
  MeshLeaves& mesh = found->second;
  if (mesh.uses == kMaxParents) {
    renew(mesh.leaves);
    mesh.uses = 0;
  }
  ++mesh.uses;
  return &mesh.leaves;
}

Result<std::vector<Leaf>> Geometries::makeLeaves(int meshIndex) {
  if (meshIndex < 0 || static_cast<std::size_t>(meshIndex) >= document_.model.meshes.size()) {
    return inputError({}, "mesh " + std::to_string(meshIndex) + " does not exist", "export it again");
  }
  const tinygltf::Mesh& mesh = document_.model.meshes[static_cast<std::size_t>(meshIndex)];
  std::vector<Leaf> made;
  for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
    const tinygltf::Primitive& primitive = mesh.primitives[i];
    const std::string name = "mesh " + std::to_string(meshIndex) + " primitive " + std::to_string(i);
    const Result<Look> look = materials_.look(primitive.material);
    if (!look) return inputError({}, name + ": " + look.error().what, look.error().mend);
    PrimitiveReader reader(primitive, *look, deforms_[static_cast<std::size_t>(meshIndex)], accessors_,
                           warnings_, name);
    const Result<osg::ref_ptr<osg::Geometry>> geometry = reader.read();
    if (!geometry) return inputError({}, name + ": " + geometry.error().what, geometry.error().mend);
    if (!*geometry) continue;
    (*geometry)->setStateSet(materials_.stateSet(primitive.material, reader.variant()));
    made.push_back({*geometry, static_cast<int>(i), primitive.material, reader.variant()});
  }
  return made;
}

std::vector<Leaf> Geometries::mirror(const std::vector<Leaf>& plain) {
  std::vector<Leaf> mirrored = plain;
  for (Leaf& leaf : mirrored) {
    if (!isTriangleMode(static_cast<int>(leaf.geometry->getPrimitiveSet(0)->getMode()))) continue;
    leaf.variant.isMirrored = true;
    leaf.geometry = new osg::Geometry(*leaf.geometry, osg::CopyOp::SHALLOW_COPY);
    leaf.geometry->setStateSet(materials_.stateSet(leaf.materialIndex, leaf.variant));
  }
  return mirrored;
}

void Geometries::renew(std::vector<Leaf>& leaves) {
  for (Leaf& leaf : leaves) {
    leaf.geometry = new osg::Geometry(*leaf.geometry, osg::CopyOp::SHALLOW_COPY);
    leaf.geometry->setStateSet(materials_.stateSet(leaf.materialIndex, leaf.variant));
  }
}

}  // namespace tessera::gltf
