#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/assets/asset_store.h"
#include "common/geometry/vec.h"
#include "common/hierarchy/object_hierarchy.h"

namespace tessera {

/// A drawable that turns to the eye about a point, as osg::Billboard does. Its bounds hold every turn.
struct Billboard {
  enum class Mode : std::uint8_t { PointRotEye, PointRotWorld, AxialRot };
  Mode mode = Mode::AxialRot;
  Vec3 axis = Vec3::UnitZ(), normal = -Vec3::UnitY(), position = Vec3::Zero();  ///< local coordinates
};

/// Where a leaf came from in its file.
struct LeafSource {
  std::uint32_t gltfNode = 0, gltfPrimitive = 0;  ///< glTF
  std::vector<std::uint32_t> osgNodePath;  ///< other formats: child indices from the root; empty for glTF
  std::uint32_t osgDrawable = 0;           ///< ... and the index among that node's drawables
};

/// One leaf: a drawable of one node, and what is needed to draw it.
struct SceneLeaf {
  AssetId drawable, state;
  Mat4 localToWorld = Mat4::Identity();
  std::optional<Billboard> billboard;
  std::uint64_t triangles = 0;
  std::uint32_t pathNode = 0;  ///< index into Scene::pathNodes
  LeafSource source;
  /// The id that the leaf's drawable would have if none were cut: its own id then, otherwise the same for all
  /// parts of one drawable.
  std::uint32_t graphLeaf = 0;
  std::uint32_t part = 0;  ///< which part of a cut drawable
};

/// A name in the scene's tree, for messages and for `scene inspect`.
struct PathNode {
  std::uint32_t parent = 0;  ///< the root is its own parent
  std::string name;
};

/// A scene as the master needs it: the object hierarchy, whose leaf ids index `leaves`, and the assets.
/// Immutable after loading; world space is y up.
struct Scene {
  std::string source;  ///< the file
  bool isGltf = false;
  ObjectHierarchy hierarchy;
  std::vector<SceneLeaf> leaves;
  std::uint32_t graphLeafCount = 0;  ///< the number of leaves if none were cut
  std::vector<PathNode> pathNodes;
  AssetStore assets;
  std::vector<std::string> warnings;  ///< what could not be taken over as it was

  [[nodiscard]] std::uint64_t triangleCount() const;
  /// "root/.../name"
  [[nodiscard]] std::string pathOf(std::uint32_t leaf) const;
  /// The sphere that camera paths in scene space refer to.
  [[nodiscard]] const Sphere& sphere() const { return hierarchy.sphere(0); }
};

}  // namespace tessera
