#include "common/scene/synthetic/glb_writer.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

namespace tessera::synthetic {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF buffers are little-endian");

constexpr std::uint64_t kVertexBytes = 12;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;
constexpr int kFloat = 5126;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
/// 65535 itself is the restart index, which glTF forbids.
constexpr std::size_t kNarrowVertices = 65535;

void append(std::string& out, std::uint64_t value) {
  char text[24];
  out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
}

/// The shortest text that reads back as the same float.
void append(std::string& out, float value) {
  char text[32];
  if (value == 0) value = 0;  // no "-0"
  out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
}

void append(std::string& out, std::string_view text) {
  out += text;
}
void append(std::string& out, const char* text) {
  out += text;
}

template <class... T>
void appendAll(std::string& out, const T&... pieces) {
  (append(out, pieces), ...);
}

void appendVector(std::string& out, std::string_view key, std::initializer_list<double> values) {
  appendAll(out, "\"", key, "\":[");
  for (const double& v : values)
    appendAll(out, &v == values.begin() ? "" : ",", static_cast<float>(v));
  out += ']';
}

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump();
}

/// A component of an sRGB colour as glTF wants it: linear. Rounded, so that no library's pow shows.
float linear(std::uint32_t rgb, unsigned shift) {
  const double s = ((rgb >> shift) & 0xffU) / 255.0;
  const double l = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  return static_cast<float>(std::round(l * 1e4) / 1e4);
}

template <class T>
void appendBytes(std::string& out, const T* data, std::size_t count) {
  out.append(reinterpret_cast<const char*>(data), count * sizeof(T));
}

void appendWord(std::string& out, std::uint64_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  appendBytes(out, &word, 1);
}

void pad(std::string& out, char with) {
  out.append((4 - out.size() % 4) % 4, with);
}

/// The children of every node in order of their ids: children of i are list[first[i]] to list[first[i+1]].
struct Children {
  std::vector<std::uint32_t> first, list;
};

Children childrenOf(const std::vector<GlbWriter::Node>& nodes) {
  Children children{std::vector<std::uint32_t>(nodes.size() + 2, 0), {}};
  for (const auto& node : nodes) {
    if (node.parent != GlbWriter::kNone) ++children.first[node.parent + 2];
  }
  for (std::size_t i = 2; i < children.first.size(); ++i)
    children.first[i] += children.first[i - 1];
  children.list.resize(children.first.back());
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].parent != GlbWriter::kNone) children.list[children.first[nodes[i].parent + 1]++] = i;
  }
  return children;
}

}  // namespace

std::uint32_t GlbWriter::addMaterial(const Material& material) {
  materials_.push_back(material);
  return static_cast<std::uint32_t>(materials_.size() - 1);
}

std::uint32_t GlbWriter::addGeometry(const Mesh& mesh) {
  Geometry g;
  g.firstVertex = positions_.size() / kVertexBytes;
  g.vertexCount = mesh.positions.size();
  g.indexCount = mesh.indices.size();
  g.wide = mesh.positions.size() > kNarrowVertices;
  g.min = Vec3::Constant(std::numeric_limits<double>::infinity());
  g.max = -g.min;
  for (const auto& p : mesh.positions) {
    const Vec3 v(p[0], p[1], p[2]);
    g.min = g.min.cwiseMin(v);
    g.max = g.max.cwiseMax(v);
  }
  appendBytes(positions_, mesh.positions.data(), mesh.positions.size());
  appendBytes(normals_, mesh.normals.data(), mesh.normals.size());
  g.indexOffsetBytes = g.wide ? wideIndices_.size() : narrowIndices_.size();
  if (g.wide) {
    appendBytes(wideIndices_, mesh.indices.data(), mesh.indices.size());
  } else {
    const std::vector<std::uint16_t> narrow(mesh.indices.begin(), mesh.indices.end());
    appendBytes(narrowIndices_, narrow.data(), narrow.size());
  }
  geometries_.push_back(g);
  return static_cast<std::uint32_t>(geometries_.size() - 1);
}

std::uint32_t GlbWriter::addMesh(std::uint32_t geometry, std::uint32_t material) {
  meshes_.push_back({geometry, material});
  return static_cast<std::uint32_t>(meshes_.size() - 1);
}

std::uint32_t GlbWriter::addNode(Node node) {
  nodes_.push_back(std::move(node));
  return static_cast<std::uint32_t>(nodes_.size() - 1);
}

void GlbWriter::writeNodes(std::string& out) const {
  const Children children = childrenOf(nodes_);
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    out += i == 0 ? "{" : ",\n{";
    const std::size_t start = out.size();
    const auto next = [&] { return out.size() == start ? "" : ","; };
    if (!node.name.empty()) appendAll(out, next(), "\"name\":", quoted(node.name));
    if (node.mesh != kNone) appendAll(out, next(), "\"mesh\":", std::uint64_t{node.mesh});
    const Placement& p = node.placement;
    const Vec3& t = p.positionM;
    if (!t.isZero(0)) appendVector(out.append(next()), "translation", {t.x(), t.y(), t.z()});
    if (p.rotation.coeffs() != Quat::Identity().coeffs()) {
      const Quat& q = p.rotation;
      appendVector(out.append(next()), "rotation", {q.x(), q.y(), q.z(), q.w()});
    }
    if (p.scale != Vec3::Ones()) {
      appendVector(out.append(next()), "scale", {p.scale.x(), p.scale.y(), p.scale.z()});
    }
    if (children.first[i] != children.first[i + 1]) {
      appendAll(out, next(), "\"children\":[");
      for (std::uint32_t k = children.first[i]; k < children.first[i + 1]; ++k) {
        appendAll(out, k == children.first[i] ? "" : ",", std::uint64_t{children.list[k]});
      }
      out += ']';
    }
    out += '}';
  }
}

void GlbWriter::writeMeshes(std::string& out) const {
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const std::uint64_t geometry = meshes_[i].geometry;
    appendAll(out, i == 0 ? "" : ",\n", R"({"primitives":[{"attributes":{"POSITION":)", 3 * geometry,
              R"(,"NORMAL":)", 3 * geometry + 1, R"(},"indices":)", 3 * geometry + 2, R"(,"material":)",
              std::uint64_t{meshes_[i].material}, "}]}");
  }
}

void GlbWriter::writeMaterials(std::string& out) const {
  for (std::size_t i = 0; i < materials_.size(); ++i) {
    const Material& m = materials_[i];
    appendAll(out, i == 0 ? "" : ",\n", R"({"name":)", quoted(m.name),
              R"(,"pbrMetallicRoughness":{"baseColorFactor":[)", linear(m.rgb, 16), ",", linear(m.rgb, 8),
              ",", linear(m.rgb, 0), R"(,1],"metallicFactor":0,"roughnessFactor":)",
              static_cast<float>(m.roughness), "}", m.doubleSided ? R"(,"doubleSided":true})" : "}");
  }
}

void GlbWriter::writeAccessors(std::string& out) const {
  const auto begin = [&](int view, std::uint64_t offsetBytes, int component, std::uint64_t count) {
    appendAll(out, R"({"bufferView":)", static_cast<std::uint64_t>(view), R"(,"byteOffset":)", offsetBytes,
              R"(,"componentType":)", static_cast<std::uint64_t>(component), R"(,"count":)", count);
  };
  // Empty views are left out, so the wide one moves up.
  const int wideView = narrowIndices_.empty() ? 2 : 3;
  for (std::size_t i = 0; i < geometries_.size(); ++i) {
    const Geometry& g = geometries_[i];
    out += i == 0 ? "" : ",\n";
    begin(0, g.firstVertex * kVertexBytes, kFloat, g.vertexCount);
    appendVector(out.append(R"(,"type":"VEC3",)"), "min", {g.min.x(), g.min.y(), g.min.z()});
    appendVector(out.append(","), "max", {g.max.x(), g.max.y(), g.max.z()});
    out += "},\n";
    begin(1, g.firstVertex * kVertexBytes, kFloat, g.vertexCount);
    out += ",\"type\":\"VEC3\"},\n";
    begin(g.wide ? wideView : 2, g.indexOffsetBytes, g.wide ? kUnsignedInt : kUnsignedShort, g.indexCount);
    out += R"(,"type":"SCALAR"})";
  }
}

void GlbWriter::writeBufferViews(std::string& out) const {
  std::uint64_t offset = 0;
  for (const std::string* part : {&positions_, &normals_, &narrowIndices_, &wideIndices_}) {
    if (part->empty()) continue;
    const bool vertices = part == &positions_ || part == &normals_;
    appendAll(out, offset == 0 ? "" : ",\n", R"({"buffer":0,"byteOffset":)", offset, R"(,"byteLength":)",
              std::uint64_t{part->size()}, vertices ? R"(,"byteStride":12)" : "", R"(,"target":)",
              static_cast<std::uint64_t>(vertices ? kArrayBuffer : kElementArrayBuffer), "}");
    offset += (part->size() + 3) / 4 * 4;
  }
}

std::string GlbWriter::json() const {
  std::string out = R"({"asset":{"version":"2.0","generator":"tessera"},"scene":0,"scenes":[{"name":)";
  appendAll(out, quoted(sceneName_), R"(,"nodes":[)");
  std::string_view comma;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].parent != kNone) continue;
    appendAll(out, comma, std::uint64_t{i});
    comma = ",";
  }
  out += "]}],\n\"nodes\":[";
  writeNodes(out);
  out += "],\n\"meshes\":[";
  writeMeshes(out);
  out += "],\n\"materials\":[";
  writeMaterials(out);
  out += "],\n\"accessors\":[";
  writeAccessors(out);
  out += "],\n\"bufferViews\":[";
  writeBufferViews(out);
  const auto padded = [](const std::string& s) { return std::uint64_t{(s.size() + 3) / 4 * 4}; };
  appendAll(out, "],\n\"buffers\":[{\"byteLength\":",
            padded(positions_) + padded(normals_) + padded(narrowIndices_) + padded(wideIndices_), "}]}");
  return out;
}

Result<std::string> GlbWriter::finish() && {
  constexpr std::uint64_t kHeaderBytes = 12;
  constexpr std::uint64_t kChunkHeaderBytes = 8;
  std::string text = json();
  pad(text, ' ');
  std::uint64_t binaryBytes = 0;
  for (std::string* part : {&positions_, &normals_, &narrowIndices_, &wideIndices_}) {
    pad(*part, '\0');
    binaryBytes += part->size();
  }
  const std::uint64_t total = kHeaderBytes + 2 * kChunkHeaderBytes + text.size() + binaryBytes;
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    return inputError(sceneName_,
                      "the scene would take " + std::to_string(total) + " bytes; a .glb ends at 4 GiB",
                      "ask for fewer triangles");
  }
  std::string out;
  out.reserve(total);
  appendWord(out.append("glTF"), 2);
  appendWord(out, total);
  appendWord(out, text.size());
  out.append("JSON").append(text);
  appendWord(out, binaryBytes);
  out.append("BIN\0", 4);
  for (std::string* part : {&positions_, &normals_, &narrowIndices_, &wideIndices_}) {
    out += *part;
    *part = {};
  }
  return out;
}

}  // namespace tessera::synthetic
