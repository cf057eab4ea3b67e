#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <osg/Geometry>
#include <osg/MatrixTransform>
#include <osg/TriangleIndexFunctor>
#include <unistd.h>

#include "common/scene/gltf/import_gltf.h"

namespace tessera::test {

inline constexpr int kByte = 5120;
inline constexpr int kUByte = 5121;
inline constexpr int kShort = 5122;
inline constexpr int kUShort = 5123;
inline constexpr int kUInt = 5125;
inline constexpr int kFloat = 5126;

/// A folder of its own that goes with its object.
class TempFolder {
 public:
  TempFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "tessera-gltf-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return path_ / name;
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A glTF file in the making: its JSON, which tests bend as they like, and its binary buffer.
struct GltfBuilder {
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
  std::string bin;

  int add(const char* section, nlohmann::json value) {
    json[section].push_back(std::move(value));
    return static_cast<int>(json[section].size()) - 1;
  }

  template <class T>
  int view(const std::vector<T>& values) {
    while (bin.size() % 4 != 0)
      bin.push_back('\0');
    const std::size_t offset = bin.size();
    bin.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    return add("bufferViews",
               {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", values.size() * sizeof(T)}});
  }

  template <class T>
  int accessor(const std::vector<T>& values, const char* type, int componentType, bool isNormalized = false) {
    const std::size_t perElement =
        std::string(type) == "SCALAR" ? 1 : static_cast<std::size_t>(type[3] - '0');
    nlohmann::json made = {{"bufferView", view(values)},
                           {"componentType", componentType},
                           {"count", values.size() / perElement},
                           {"type", type}};
    if (isNormalized) made["normalized"] = true;
    return add("accessors", made);
  }

  /// A node that shows a mesh of one primitive, in the scene.
  int addPrimitive(nlohmann::json primitive) {
    const int mesh = add("meshes", {{"primitives", {std::move(primitive)}}});
    const int node = add("nodes", {{"mesh", mesh}});
    json["scenes"][0]["nodes"].push_back(node);
    return node;
  }

  [[nodiscard]] std::string jsonWithBuffer(const std::string& uri = {}) const {
    nlohmann::json whole = json;
    if (!bin.empty()) {
      whole["buffers"][0]["byteLength"] = bin.size();
      if (!uri.empty()) whole["buffers"][0]["uri"] = uri;
    }
    return whole.dump();
  }

  [[nodiscard]] std::string glb() const {
    std::string text = jsonWithBuffer();
    while (text.size() % 4 != 0)
      text.push_back(' ');
    std::string body = bin;
    while (body.size() % 4 != 0)
      body.push_back('\0');
    std::string out = "glTF";
    const auto word = [&out](std::size_t value) {
      const auto narrow = static_cast<std::uint32_t>(value);
      out.append(reinterpret_cast<const char*>(&narrow), sizeof narrow);
    };
    word(2);
    word(20 + text.size() + (body.empty() ? 0 : 8 + body.size()));
    word(text.size());
    word(0x4E4F534A);
    out += text;
    if (!body.empty()) {
      word(body.size());
      word(0x004E4942);
      out += body;
    }
    return out;
  }

  [[nodiscard]] Result<ImportedGraph> import() const {
    const TempFolder folder;
    return importGltf(folder.write("scene.glb", glb()));
  }
};

/// One triangle in z = 0, counter-clockwise seen from +z: accessors 0 (positions) and, from there on, yours.
inline GltfBuilder triangleFile() {
  GltfBuilder file;
  file.accessor(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", kFloat);
  file.addPrimitive({{"attributes", {{"POSITION", 0}}}});
  return file;
}

// Top row red, green; bottom row blue, white.
inline constexpr const char* kPictureUri =
    "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAIAAAD91JpzAAAAEklEQVR42mP4z8DAAMIM/4EAAB/"
    "uBfvxq7p3AAAAAElFTkSuQmCC";

inline osg::Group* nodeAt(const ImportedGraph& graph, unsigned int index) {
  return graph.root->getChild(index)->asGroup();
}

inline osg::Geometry* leafAt(const ImportedGraph& graph, unsigned int node = 0, unsigned int leaf = 0) {
  return nodeAt(graph, node)->getChild(leaf)->asGeometry();
}

inline const osg::Vec3Array& positionsOf(const osg::Geometry& g) {
  return dynamic_cast<const osg::Vec3Array&>(*g.getVertexArray());
}

inline osg::Vec4ub overallColor(const osg::Geometry& g) {
  EXPECT_EQ(g.getColorArray()->getBinding(), osg::Array::BIND_OVERALL);
  return dynamic_cast<const osg::Vec4ubArray&>(*g.getColorArray())[0];
}

struct Counter {
  unsigned int count = 0;
  void operator()(unsigned int, unsigned int, unsigned int) { ++count; }
};

struct SceneFigures {
  std::size_t nodes = 0;
  std::size_t leaves = 0;
  std::size_t triangles = 0;
  std::map<const osg::Node*, osg::BoundingBoxd> worldBoxes;  // of nodes with leaves
  std::vector<osg::BoundingBoxd> boxes;                      // of leaves, in order
};

/// Walks with a stack of its own: trees of this test are deeper than the program's.
inline SceneFigures figuresOf(const ImportedGraph& graph) {
  SceneFigures figures;
  std::vector<std::pair<osg::Node*, osg::Matrixd>> open = {{graph.root.get(), osg::Matrixd()}};
  while (!open.empty()) {
    const auto [node, matrix] = open.back();
    open.pop_back();
    if (const osg::Geometry* geometry = node->asGeometry()) {
      osg::TriangleIndexFunctor<Counter> counter;
      geometry->accept(counter);
      ++figures.leaves;
      figures.triangles += counter.count;
      osg::BoundingBoxd box;
      for (const osg::Vec3f& v : positionsOf(*geometry))
        box.expandBy(osg::Vec3d(v) * matrix);
      figures.boxes.push_back(box);
      continue;
    }
    ++figures.nodes;
    osg::Matrixd world = matrix;
    if (const auto* transform = dynamic_cast<osg::MatrixTransform*>(node))
      world = transform->getMatrix() * matrix;
    for (unsigned int i = node->asGroup()->getNumChildren(); i-- > 0;) {
      open.emplace_back(node->asGroup()->getChild(i), world);
    }
  }
  --figures.nodes;  // the scene itself
  return figures;
}

inline std::string errorOf(const Result<ImportedGraph>& result) {
  return result ? "no error" : result.error().text();
}

inline bool warns(const ImportedGraph& graph, const std::string& part) {
  for (const std::string& warning : graph.warnings) {
    if (warning.find(part) != std::string::npos) return true;
  }
  return false;
}

inline GltfBuilder texturedFile() {
  GltfBuilder file = triangleFile();
  file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] =
      file.accessor(std::vector<float>{0, 0, 1, 0, 0, 0.5F}, "VEC2", kFloat);
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  file.add("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  file.add("textures", {{"source", 0}});
  file.add("images", {{"uri", kPictureUri}, {"name", "squares"}});
  return file;
}

}  // namespace tessera::test
