#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/geometry/vec.h"
#include "common/scene/synthetic/placement.h"

namespace tessera::synthetic {

/// Indexed triangles, counter-clockwise from outside, one unit normal per vertex.
struct Mesh {
  std::vector<std::array<float, 3>> positions;  ///< metres
  std::vector<std::array<float, 3>> normals;
  std::vector<std::uint32_t> indices;

  [[nodiscard]] std::uint64_t triangleCount() const { return indices.size() / 3; }
};

/// Appends to a mesh through a placement without scale.
class MeshWriter {
 public:
  MeshWriter(Mesh& mesh, const Placement& placement)
      : mesh_(mesh), rotation_(placement.rotation.toRotationMatrix()), positionM_(placement.positionM) {}

  std::uint32_t vertex(const Vec3& positionM, const Vec3& normal) {
    const Vec3 p = rotation_ * positionM + positionM_;
    const Vec3 n = (rotation_ * normal).normalized();
    const auto narrow = [](const Vec3& v) {
      return std::array{static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
    };
    mesh_.positions.push_back(narrow(p));
    mesh_.normals.push_back(narrow(n));
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
  }

  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh_.indices.insert(mesh_.indices.end(), {a, b, c});
  }

  /// Two flat triangles a-b-c and a-c-d with vertices of their own.
  void quad(const std::array<Vec3, 4>& corners, const Vec3& normal) {
    const std::uint32_t first = vertex(corners[0], normal);
    for (std::size_t i = 1; i < 4; ++i)
      vertex(corners[i], normal);
    triangle(first, first + 1, first + 2);
    triangle(first, first + 2, first + 3);
  }

  /// Two triangles between existing vertices, counter-clockwise.
  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }

 private:
  Mesh& mesh_;
  Mat3 rotation_;
  Vec3 positionM_;
};

}  // namespace tessera::synthetic
