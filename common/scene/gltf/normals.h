#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <osg/Vec3f>

namespace tessera::gltf {

/// Vertices split so that every triangle has its own normal. A vertex stays shared by triangles that lie in
/// one plane, as the two of a quad do.
struct FlatMesh {
  std::vector<std::uint32_t> source;   ///< per new vertex: the vertex it copies
  std::vector<osg::Vec3f> normals;     ///< per new vertex, unit length
  std::vector<std::uint32_t> indices;  ///< three new vertices per triangle
};

/// The triangles, three vertices each, of a triangle strip or fan, wound alike; those with two equal corners
/// are left out. `mode` is glTF's (4: `vertices` already are triangles).
[[nodiscard]] std::vector<std::uint32_t> toTriangles(int mode, std::vector<std::uint32_t> vertices);

/// The normal of each corner of triangles that share no vertex: positions 0 1 2, 3 4 5 and so on.
[[nodiscard]] std::vector<osg::Vec3f> flatNormals(std::span<const osg::Vec3f> positions);

/// Precondition: every entry of `triangles` is an index of `positions`.
[[nodiscard]] FlatMesh makeFlat(std::span<const osg::Vec3f> positions,
                                std::span<const std::uint32_t> triangles);

}  // namespace tessera::gltf
