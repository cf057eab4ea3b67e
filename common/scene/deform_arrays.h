#pragma once

namespace tessera {

// How a drawable carries what deforms it: as vertex attribute arrays of its osg::Geometry, one element for
// each vertex. Tiles take them out before they draw. Skins come in sets of four joints for each vertex.

inline constexpr unsigned int kMaxJointSets = 2;

/// osg::Vec4usArray: numbers of joints of the skin.
[[nodiscard]] constexpr unsigned int jointArray(unsigned int set) {
  return 2 * set;
}
/// osg::Vec4Array: their weights; over all sets they sum to 1.
[[nodiscard]] constexpr unsigned int weightArray(unsigned int set) {
  return 2 * set + 1;
}

inline constexpr unsigned int kFirstTargetArray = 2 * kMaxJointSets;

/// osg::Vec3Array: displacements of a morph target.
[[nodiscard]] constexpr unsigned int displacementArray(unsigned int target) {
  return kFirstTargetArray + 2 * target;
}
/// osg::Vec3Array, or none: what it adds to the normals.
[[nodiscard]] constexpr unsigned int normalChangeArray(unsigned int target) {
  return kFirstTargetArray + 2 * target + 1;
}

}  // namespace tessera
