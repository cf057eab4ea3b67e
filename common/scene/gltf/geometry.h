#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include <osg/Geometry>
#include <osg/ref_ptr>

#include "common/scene/gltf/accessor.h"
#include "common/scene/gltf/load_document.h"
#include "common/scene/gltf/material.h"
#include "common/scene/gltf/motion_reader.h"
#include "common/scene/gltf/warnings.h"

namespace tessera::gltf {

/// One primitive of a mesh, ready to hang below a node.
struct Leaf {
  osg::ref_ptr<osg::Geometry> geometry;
  int primitiveIndex = 0;
  int materialIndex = -1;
  StateVariant variant;
};

/// Turns meshes into drawables, each mesh once however many nodes show it.
class Geometries {
 public:
  Geometries(const Document& document, Warnings& warnings)
      : document_(document),
        warnings_(warnings),
        accessors_(document.model),
        materials_(document, warnings),
        deforms_(meshDeforms(document)) {}

  [[nodiscard]] AccessorReader& accessors() { return accessors_; }

  /// The mesh's primitives that draw something, in their order. Mirrored leaves share all arrays with the
  /// plain ones and differ in their state set. Valid as long as this object.
  [[nodiscard]] Result<const std::vector<Leaf>*> leaves(int meshIndex, bool isMirrored);

 private:
  struct MeshLeaves {
    std::vector<Leaf> leaves;
    std::size_t uses = 0;
  };
  [[nodiscard]] Result<std::vector<Leaf>> makeLeaves(int meshIndex);
  [[nodiscard]] std::vector<Leaf> mirror(const std::vector<Leaf>& plain);
  void renew(std::vector<Leaf>& leaves);

  const Document& document_;
  Warnings& warnings_;
  AccessorReader accessors_;
  Materials materials_;
  std::vector<MeshDeforms> deforms_;  ///< by mesh
  std::map<std::pair<int, bool>, MeshLeaves> meshes_;
};

}  // namespace tessera::gltf
