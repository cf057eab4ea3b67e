#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/synthetic/mesh.h"
#include "common/scene/synthetic/placement.h"

namespace tessera::synthetic {

/// A glTF metallic-roughness material; metallic is 0 throughout.
struct Material {
  std::string name;
  std::uint32_t rgb = 0x808080;  ///< sRGB, as on the web
  double roughness = 0.8;
  bool doubleSided = false;
};

/// Collects a scene and writes it as binary glTF 2.0. Ids are indices in the order of adding.
class GlbWriter {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  struct Node {
    std::uint32_t parent = kNone;  ///< added before; kNone for the root
    std::uint32_t mesh = kNone;
    std::string name;  ///< may be empty
    Placement placement;
  };

  explicit GlbWriter(std::string sceneName) : sceneName_(std::move(sceneName)) {}

  void reserveNodes(std::size_t nodeCount) { nodes_.reserve(nodeCount); }
  std::uint32_t addMaterial(const Material& material);
  /// `mesh` has at least one triangle.
  std::uint32_t addGeometry(const Mesh& mesh);
  /// A glTF mesh with one primitive; several may share a geometry.
  std::uint32_t addMesh(std::uint32_t geometry, std::uint32_t material);
  std::uint32_t addNode(Node node);

  /// The bytes of the file. Fails where they would not fit the format's 32-bit lengths.
  [[nodiscard]] Result<std::string> finish() &&;

 private:
  struct Geometry {
    std::uint64_t firstVertex = 0, vertexCount = 0;
    std::uint64_t indexOffsetBytes = 0, indexCount = 0;
    bool wide = false;  ///< 32-bit indices
    Vec3 min, max;
  };
  struct PlacedMesh {
    std::uint32_t geometry = 0, material = 0;
  };

  [[nodiscard]] std::string json() const;
  void writeNodes(std::string& out) const;
  void writeMeshes(std::string& out) const;
  void writeMaterials(std::string& out) const;
  void writeAccessors(std::string& out) const;
  void writeBufferViews(std::string& out) const;

  std::string sceneName_;
  std::vector<Node> nodes_;
  std::vector<PlacedMesh> meshes_;
  std::vector<Material> materials_;
  std::vector<Geometry> geometries_;
  // One buffer view each.
  std::string positions_, normals_, narrowIndices_, wideIndices_;
};

}  // namespace tessera::synthetic
