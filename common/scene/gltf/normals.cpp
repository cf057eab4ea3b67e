#include "common/scene/gltf/normals.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include <osg/Vec3d>
#include <tiny_gltf.h>

namespace tessera::gltf {

namespace {

constexpr std::uint32_t kNone = UINT32_MAX;
/// How many copies of a vertex are looked through for a fitting normal: keeps the hub of a huge fan linear.
constexpr int kMaxCopiesCompared = 8;
/// Cosine above which two triangles count as one plane: 0.08 degrees.
constexpr float kSamePlane = 0.999999F;

osg::Vec3f normalOf(const osg::Vec3f& a, const osg::Vec3f& b, const osg::Vec3f& c) {
  const osg::Vec3d origin(a);
  osg::Vec3d n = (osg::Vec3d(b) - origin) ^ (osg::Vec3d(c) - origin);
  const double length = n.length();
  // A triangle without area draws nothing; any direction will do.
  if (!(length > 0) || !std::isfinite(length)) return {0, 0, 1};
  n /= length;
  return osg::Vec3f(n);
}

}  // namespace

std::vector<std::uint32_t> toTriangles(int mode, std::vector<std::uint32_t> vertices) {
  if (mode == TINYGLTF_MODE_TRIANGLES) return vertices;
  std::vector<std::uint32_t> triangles;
  triangles.reserve(vertices.size() * 3);
  for (std::size_t i = 2; i < vertices.size(); ++i) {
    std::uint32_t a = mode == TINYGLTF_MODE_TRIANGLE_FAN ? vertices[0] : vertices[i - 2];
    std::uint32_t b = vertices[i - 1];
    const std::uint32_t c = vertices[i];
    if (a == b || b == c || a == c) continue;
    if (mode == TINYGLTF_MODE_TRIANGLE_STRIP && i % 2 == 1) std::swap(a, b);
    triangles.insert(triangles.end(), {a, b, c});
  }
  return triangles;
}

std::vector<osg::Vec3f> flatNormals(std::span<const osg::Vec3f> positions) {
  std::vector<osg::Vec3f> normals;
  normals.reserve(positions.size());
  for (std::size_t i = 0; i + 2 < positions.size(); i += 3) {
    normals.insert(normals.end(), 3, normalOf(positions[i], positions[i + 1], positions[i + 2]));
  }
  return normals;
}

FlatMesh makeFlat(std::span<const osg::Vec3f> positions, std::span<const std::uint32_t> triangles) {
  FlatMesh mesh;
  mesh.indices.reserve(triangles.size());
  std::vector<std::uint32_t> firstCopy(positions.size(), kNone);  // of a vertex
  std::vector<std::uint32_t> nextCopy;                            // of the same vertex, after a copy
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    const osg::Vec3f normal =
        normalOf(positions[triangles[t]], positions[triangles[t + 1]], positions[triangles[t + 2]]);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = triangles[t + corner];
      std::uint32_t copy = firstCopy[vertex];
      for (int tried = 0; copy != kNone && mesh.normals[copy] * normal < kSamePlane; ++tried) {
        copy = tried < kMaxCopiesCompared ? nextCopy[copy] : kNone;
      }
      if (copy == kNone) {
        copy = static_cast<std::uint32_t>(mesh.source.size());
        mesh.source.push_back(vertex);
        mesh.normals.push_back(normal);
        nextCopy.push_back(firstCopy[vertex]);
        firstCopy[vertex] = copy;
      }
      mesh.indices.push_back(copy);
    }
  }
  return mesh;
}

}  // namespace tessera::gltf
