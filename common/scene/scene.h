#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/assets/asset_table.h"
#include "common/base/column.h"
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
  std::uint32_t osgDrawable = 0;  ///< other formats: the index among the drawables of Scene::nodePathOf
};

/// One leaf: a drawable of one node, and what is needed to draw it. A row of the scene's index, as are all
/// structs below: plain, so that an index can be mapped.
struct SceneLeaf {
  static constexpr std::uint32_t kNoBillboard = UINT32_MAX;
  Mat4 localToWorld = Mat4::Identity();
  std::uint64_t triangles = 0;
  std::uint32_t drawable = 0, state = 0;   ///< numbers of Scene::assets
  std::uint32_t billboard = kNoBillboard;  ///< index into Scene::billboards
  std::uint32_t pathNode = 0;              ///< index into Scene::pathNodes
  LeafSource source;
  /// The id that the leaf's drawable would have if none were cut: its own id then, otherwise the same for all
  /// parts of one drawable.
  std::uint32_t graphLeaf = 0;
  std::uint32_t part = 0;                                       ///< which part of a cut drawable
  std::array<std::uint8_t, 4> meanRgba = {204, 204, 204, 255};  ///< roughly how it looks from far away
};

/// A name in the scene's tree, for messages and for `scene inspect`.
struct PathNode {
  std::uint32_t parent = 0;                    ///< the root is its own parent
  std::uint32_t childIndex = 0;                ///< among the parent's children in the file's graph
  std::uint32_t nameBegin = 0, nameBytes = 0;  ///< of Scene::names
};

/// A scene as the master needs it: the object hierarchy, whose leaf ids index `leaves`, and the assets by
/// number. World space is y up. It is made by an import (extract.h), or mapped from the index that one left
/// (scene_index.h): then only what is looked at takes memory. All but the bounds of what moves is immutable
/// after loading.
struct Scene {
  std::string source;  ///< the file
  bool isGltf = false;
  ObjectHierarchy hierarchy;
  Column<SceneLeaf> leaves;
  Column<Billboard> billboards;
  std::uint32_t graphLeafCount = 0;  ///< the number of leaves if none were cut
  Column<PathNode> pathNodes;
  Column<char> names;
  AssetTable assets;
  Column<char> motion;                ///< what moves (motion/motion_codec.h); empty: nothing
  std::optional<Sphere> shown;        ///< where some leaves are absent at first: around the others
  std::vector<std::string> warnings;  ///< what could not be taken over as it was

  [[nodiscard]] std::uint64_t triangleCount() const;
  /// Null: the leaf does not turn to the eye.
  [[nodiscard]] const Billboard* billboardOf(const SceneLeaf& leaf) const {
    return leaf.billboard == SceneLeaf::kNoBillboard ? nullptr : &billboards[leaf.billboard];
  }
  std::uint32_t addPathNode(std::uint32_t parent, std::uint32_t childIndex, std::string_view name);
  [[nodiscard]] std::string_view nameOf(const PathNode& node) const {
    return {names.data() + node.nameBegin, node.nameBytes};
  }
  /// "root/.../name"
  [[nodiscard]] std::string pathOf(std::uint32_t leaf) const { return pathOfNode(leaves[leaf].pathNode); }
  [[nodiscard]] std::string pathOfNode(std::uint32_t pathNode) const;
  /// Child indices from the root to the leaf's node, in the file's graph. Empty for glTF.
  [[nodiscard]] std::vector<std::uint32_t> nodePathOf(std::uint32_t leaf) const;
  /// The sphere that camera paths in scene space refer to: around what is shown as the file has it.
  [[nodiscard]] const Sphere& sphere() const { return shown ? *shown : hierarchy.sphere(0); }
};

}  // namespace tessera
