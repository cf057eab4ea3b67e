#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/geometry/box.h"
#include "common/geometry/vec.h"
#include "common/hierarchy/enclosing_bounds.h"
#include "common/hierarchy/visible_list.h"

// What moves in a scene, as plain data: a part of its index.
namespace tessera::motion {

inline constexpr std::uint32_t kNone = UINT32_MAX;

/// Scale, then rotation, then translation.
struct Trs {
  Vec3 translation = Vec3::Zero();
  std::array<double, 4> rotation = {0, 0, 0, 1};  ///< quaternion x, y, z, w of length 1
  Vec3 scale = Vec3::Ones();
};

/// A node of glTF. Its parent, if any, stands before it.
struct Node {
  std::uint32_t parent = kNone;
  bool hasMatrix = false;  ///< `matrix` is its place; such a node is not animated itself
  Mat4 matrix = Mat4::Identity();
  Trs trs = {};
  std::vector<float> weights = {};  ///< of its mesh's morph targets, where none are animated
};

enum class Path : std::uint8_t { Translation = 0, Rotation = 1, Scale = 2, Weights = 3 };
enum class Interpolation : std::uint8_t { Step = 0, Linear = 1, CubicSpline = 2 };

/// What drives one property of one node, over and over.
struct Channel {
  std::uint32_t node = 0;
  Path path = Path::Translation;
  Interpolation interpolation = Interpolation::Linear;
  float periodS = 0;               ///< of the animation that it is a part of; 0: it stands at its first key
  std::uint32_t width = 3;         ///< numbers in a value
  std::vector<float> timesS = {};  ///< of the keys, ascending; at least one
  std::vector<float> values = {};  ///< `width` for each key; of a cubic spline in-tangent, value, out-tangent
};

struct Skin {
  std::vector<std::uint32_t> joints = {};  ///< nodes
  std::vector<Mat4> inverseBind = {};      ///< for each: from the mesh to the joint's own coordinates
};

/// How a leaf's shape follows. Boxes hold what the tiles are sent, in the leaf's stored coordinates.
struct Deformation {
  std::uint32_t skin = kNone;
  std::vector<Aabb> jointBoxes =
      {};  ///< for each joint of the skin: the vertices that follow it; may be empty
  std::vector<Aabb> targetBoxes = {};  ///< for each morph target: the displacements of all vertices
};

/// A leaf that may move. It is named by its place in the graph, which no reordering changes.
struct Leaf {
  std::uint32_t graphLeaf = 0, part = 0;  ///< as SceneLeaf has them
  std::uint32_t node = 0;                 ///< of `nodes` or of the skeleton
  Mat4 nodeToLeaf = Mat4::Identity();     ///< its localToWorld is the node's times this
  Bounds bounds = {};                     ///< undeformed, in the leaf's own coordinates
  std::uint32_t deformation = kNone;
};

/// Leaves [first, last) of the graph, which come and go with a node of the skeleton.
struct Unit {
  std::uint32_t node = 0;
  std::uint32_t firstGraphLeaf = 0, lastGraphLeaf = 0;
};

/// Of a glTF scene nodes, channels and skins; of others the skeleton.
struct Motion {
  std::vector<Node> nodes;
  std::vector<Channel> channels;  ///< at most one for each node and path
  std::vector<Skin> skins;
  std::vector<Deformation> deformations;
  std::vector<Leaf> leaves;
  std::string skeleton;     ///< the graph without its drawables, in OpenSceneGraph's osgb format; nodes are
                            ///< numbered in depth-first pre-order
  std::vector<Unit> units;  ///< in the order of nodes
  VisibleList hiddenAsLoaded;  ///< leaves of the graph that a scene does not show that nobody plays
  /// Around what is shown as loaded, where something is hidden; radius below 0: the same as around all.
  Sphere shownAsLoaded = {Vec3::Zero(), -1};

  [[nodiscard]] bool empty() const { return leaves.empty() && units.empty(); }
};

}  // namespace tessera::motion
