#include "common/scene/gltf/primitive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "common/scene/gltf/normals.h"

namespace tessera::gltf {

namespace {

constexpr std::array<std::size_t, 7> kLeastVertices = {1, 2, 2, 2, 3, 3, 3};  // by mode
constexpr const char* kExportAgain = "export it again, or check that it was copied whole";

std::span<float> floatsOf(osg::Vec3Array& array) {
  return {array.front().ptr(), array.size() * 3};
}

/// The distinct values of `indices`, ascending; empty where all below `count` occur.
std::vector<std::uint32_t> usedVertices(const std::vector<std::uint32_t>& indices, std::size_t count) {
  std::vector<std::uint32_t> used;
  // Many small primitives may index one huge accessor: the work must not grow with that.
  if (indices.size() < count / 16) {
    used = indices;
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    return used;
  }
  std::vector<bool> isUsed(count, false);
  for (const std::uint32_t index : indices)
    isUsed[index] = true;
  const auto usedCount = static_cast<std::size_t>(std::count(isUsed.begin(), isUsed.end(), true));
  if (usedCount == count) return used;
  used.reserve(usedCount);
  for (std::size_t i = 0; i < count; ++i) {
    if (isUsed[i]) used.push_back(static_cast<std::uint32_t>(i));
  }
  return used;
}

}  // namespace

Result<osg::ref_ptr<osg::Geometry>> PrimitiveReader::read() {
  const osg::ref_ptr<osg::Geometry> nothing;
  if (accessorOf("POSITION") < 0) {
    skip("has no POSITION");
    return nothing;
  }
  Result<Elements> positions = elementsOf("POSITION", Attribute::Position);
  if (!positions) return positions.error();
  positions_ = *positions;
  accessorCount_ = positions_.count;
  if (const Status status = checkAttributes(); !status) return status.error();
  const Result<bool> draws = readDrawOrder();
  if (!draws) return draws.error();
  if (!*draws) return nothing;

  if (const Status status = readPositions(); !status) return status.error();
  if (const Status status = readNormals(); !status) return status.error();
  if (isIndexed_ && indices_.empty()) {
    skip("has triangles without area only");
    return nothing;
  }
  if (const Status status = readTexCoords(); !status) return status.error();
  if (const Status status = readColors(); !status) return status.error();
  if (const Status status = readDeformation(); !status) return status.error();
  geometry_->setVertexArray(vertices_);
  geometry_->addPrimitiveSet(makePrimitiveSet());
  return geometry_;
}

int PrimitiveReader::accessorOf(const std::string& attribute) const {
  const auto found = primitive_.attributes.find(attribute);
  return found == primitive_.attributes.end() ? -1 : found->second;
}

void PrimitiveReader::skip(const std::string& why) {
  warnings_.add("primitive left out", name_ + " " + why + "; it is left out");
}

Result<Elements> PrimitiveReader::elementsOf(const std::string& attribute, Attribute use) {
  Result<Elements> elements = accessors_.elements(accessorOf(attribute), use);
  if (!elements) return inputError({}, attribute + ": " + elements.error().what, elements.error().mend);
  return elements;
}

Status PrimitiveReader::checkAttributes() const {
  for (const auto& [attribute, accessorIndex] : primitive_.attributes) {
    const Result<std::size_t> count = accessors_.count(accessorIndex);
    if (!count)
      return inputError({}, attribute.substr(0, 60) + ": " + count.error().what, count.error().mend);
    if (*count != accessorCount_) {
      return inputError({},
                        attribute.substr(0, 60) + " has " + std::to_string(*count) + " elements for " +
                            std::to_string(accessorCount_) + " vertices",
                        kExportAgain);
    }
  }
  return Done{};
}

/// Reads mode and indices; false where nothing is drawn.
Result<bool> PrimitiveReader::readDrawOrder() {
  mode_ = primitive_.mode;
  if (mode_ < 0 || mode_ > 6) {
    return inputError({}, "mode " + std::to_string(mode_) + " does not exist", kExportAgain);
  }
  std::size_t drawn = accessorCount_;
  isIndexed_ = primitive_.indices >= 0;
  if (isIndexed_) {
    const Result<Elements> elements = accessors_.elements(primitive_.indices, Attribute::Index);
    if (!elements) return inputError({}, "indices: " + elements.error().what, elements.error().mend);
    indices_ = readIndices(*elements);
    drawn = indices_.size();
    const auto largest = std::max_element(indices_.begin(), indices_.end());
    if (largest != indices_.end() && *largest >= accessorCount_) {
      return inputError({},
                        "index " + std::to_string(*largest) + " is out of range, there are " +
                            std::to_string(accessorCount_) + " vertices",
                        kExportAgain);
    }
  }
  if (!trim(drawn)) return false;
  if (isIndexed_) {
    indices_.resize(drawn);
    dropUnusedVertices();
  } else {
    vertexCount_ = drawn;
  }
  return true;
}

/// Takes off what does not make up a whole line or triangle; false where nothing is left.
bool PrimitiveReader::trim(std::size_t& drawn) {
  if (drawn < kLeastVertices[static_cast<std::size_t>(mode_)]) {
    skip("has " + std::to_string(drawn) + " vertices, too few to draw anything");
    return false;
  }
  std::size_t perPart = 1;
  if (mode_ == TINYGLTF_MODE_LINE) perPart = 2;
  if (mode_ == TINYGLTF_MODE_TRIANGLES) perPart = 3;
  if (const std::size_t left = drawn % perPart; left != 0) {
    warnings_.add("vertices left over", name_ + " has " + std::to_string(drawn) +
                                            " vertices, of which the last " + std::to_string(left) +
                                            " make up no whole line or triangle");
    drawn -= left;
  }
  return true;
}

void PrimitiveReader::dropUnusedVertices() {
  kept_ = usedVertices(indices_, accessorCount_);
  vertexCount_ = kept_.empty() ? accessorCount_ : kept_.size();
  if (kept_.empty()) return;
  if (indices_.size() < accessorCount_ / 16) {
    for (std::uint32_t& index : indices_) {
      const auto at = std::lower_bound(kept_.begin(), kept_.end(), index);
      index = static_cast<std::uint32_t>(at - kept_.begin());
    }
    return;
  }
  std::vector<std::uint32_t> place(accessorCount_);
  for (std::size_t i = 0; i < kept_.size(); ++i)
    place[kept_[i]] = static_cast<std::uint32_t>(i);
  for (std::uint32_t& index : indices_)
    index = place[index];
}

Status PrimitiveReader::checkFinite(std::span<const float> values, std::size_t perVertex,
                                    const std::string& attribute) const {
  const auto bad = std::find_if_not(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
  if (bad == values.end()) return Done{};
  const std::size_t at = static_cast<std::size_t>(bad - values.begin()) / perVertex;
  const std::size_t vertex = kept_.empty() ? at : kept_[at];
  return inputError({}, attribute + " of vertex " + std::to_string(vertex) + " is not a finite number",
                    "mend the model and export it again");
}

Result<std::vector<float>> PrimitiveReader::readFloats(const std::string& attribute, Attribute use) {
  Result<Elements> elements = elementsOf(attribute, use);
  if (!elements) return elements.error();
  return gathered(*elements);
}

/// Those of the geometry's vertices. `elements` has one for each vertex of the accessors.
std::vector<float> PrimitiveReader::gathered(Elements elements) const {
  elements.count = std::min(elements.count, vertexCount_);
  std::vector<float> values(vertexCount_ * static_cast<std::size_t>(elements.componentCount));
  if (!kept_.empty()) elements.count = accessorCount_;
  gatherFloats(elements, kept_, values);
  return values;
}

Status PrimitiveReader::readPositions() {
  vertices_ = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
  vertices_->resize(vertexCount_);
  Elements elements = positions_;
  if (kept_.empty()) elements.count = vertexCount_;
  gatherFloats(elements, kept_, floatsOf(*vertices_));
  return checkFinite(floatsOf(*vertices_), 3, "POSITION");
}

Status PrimitiveReader::readNormals() {
  const bool hasNormals = accessorOf("NORMAL") >= 0;
  variant_.isLit = !look_.isUnlit && (hasNormals || isTriangleMode(mode_));
  if (!variant_.isLit) return Done{};
  if (!hasNormals) {
    makeFlatNormals();
    return Done{};
  }
  const Result<std::vector<float>> values = readFloats("NORMAL", Attribute::Normal);
  if (!values) return values.error();
  if (Status status = checkFinite(*values, 3, "NORMAL"); !status) return status;
  osg::ref_ptr<osg::Vec3Array> normals = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
  normals->resize(vertexCount_);
  std::copy(values->begin(), values->end(), floatsOf(*normals).begin());
  geometry_->setNormalArray(normals);
  return Done{};
}

void PrimitiveReader::makeFlatNormals() {
  osg::ref_ptr<osg::Vec3Array> normals = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
  if (!isIndexed_ && mode_ == TINYGLTF_MODE_TRIANGLES) {
    normals->asVector() = flatNormals(vertices_->asVector());
    geometry_->setNormalArray(normals);
    return;
  }
  if (!isIndexed_) {
    indices_.resize(vertexCount_);
    std::iota(indices_.begin(), indices_.end(), 0U);
    isIndexed_ = true;
  }
  FlatMesh flat = makeFlat(vertices_->asVector(), toTriangles(mode_, std::move(indices_)));
  mode_ = TINYGLTF_MODE_TRIANGLES;
  indices_ = std::move(flat.indices);
  normals->asVector() = std::move(flat.normals);
  osg::ref_ptr<osg::Vec3Array> split = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
  split->reserve(flat.source.size());
  for (std::uint32_t& vertex : flat.source) {
    split->push_back((*vertices_)[vertex]);
    if (!kept_.empty()) vertex = kept_[vertex];
  }
  kept_ = std::move(flat.source);
  vertexCount_ = kept_.size();
  vertices_ = split;
  geometry_->setNormalArray(normals);
}

Status PrimitiveReader::readTexCoords() {
  if (look_.textureIndex < 0) return Done{};
  const std::string attribute = "TEXCOORD_" + std::to_string(look_.texCoordSet);
  if (accessorOf(attribute) < 0) {
    warnings_.add("no texture coordinates", name_ + " has no " + attribute + "; its texture is not drawn");
    return Done{};
  }
  const Result<std::vector<float>> values = readFloats(attribute, Attribute::TexCoord);
  if (!values) return values.error();
  osg::ref_ptr<osg::Vec2Array> coords = new osg::Vec2Array(osg::Array::BIND_PER_VERTEX);
  coords->reserve(vertexCount_);
  for (std::size_t i = 0; i < vertexCount_; ++i) {
    osg::Vec2f uv((*values)[2 * i], (*values)[2 * i + 1]);
    if (look_.transform) {
      const std::array<double, 2> moved = look_.transform->apply(uv.x(), uv.y());
      uv.set(static_cast<float>(moved[0]), static_cast<float>(moved[1]));
    }
    coords->push_back(uv);
  }
  const std::span<const float> seen(coords->front().ptr(), vertexCount_ * 2);
  if (Status status = checkFinite(seen, 2, attribute); !status) return status;
  variant_.isTextured = true;
  geometry_->setTexCoordArray(0, coords);
  return Done{};
}

Status PrimitiveReader::readColors() {
  const auto alphaByte = [&](double alpha) {
    if (look_.isOpaque) return static_cast<unsigned char>(255);
    return static_cast<unsigned char>(std::lround(255 * std::clamp(alpha, 0.0, 1.0)));
  };
  const std::array<double, 4>& base = look_.baseColor;
  if (accessorOf("COLOR_0") < 0) {
    osg::ref_ptr<osg::Vec4ubArray> overall = new osg::Vec4ubArray(osg::Array::BIND_OVERALL);
    overall->setNormalize(true);
    overall->push_back({srgbByte(base[0]), srgbByte(base[1]), srgbByte(base[2]), alphaByte(base[3])});
    geometry_->setColorArray(overall);
    return Done{};
  }
  const Result<std::vector<float>> values = readFloats("COLOR_0", Attribute::Color);
  if (!values) return values.error();
  const std::size_t components = values->size() / vertexCount_;
  if (Status status = checkFinite(*values, components, "COLOR_0"); !status) return status;
  osg::ref_ptr<osg::Vec4ubArray> colors = new osg::Vec4ubArray(osg::Array::BIND_PER_VERTEX);
  colors->setNormalize(true);
  colors->reserve(vertexCount_);
  for (std::size_t i = 0; i < vertexCount_; ++i) {
    const float* c = values->data() + i * components;
    const double alpha = components == 4 ? c[3] * base[3] : base[3];
    colors->push_back(
        {srgbByte(c[0] * base[0]), srgbByte(c[1] * base[1]), srgbByte(c[2] * base[2]), alphaByte(alpha)});
  }
  geometry_->setColorArray(colors);
  return Done{};
}

osg::ref_ptr<osg::PrimitiveSet> PrimitiveReader::makePrimitiveSet() {
  const auto mode = static_cast<GLenum>(mode_);
  if (!isIndexed_) return new osg::DrawArrays(mode, 0, static_cast<GLsizei>(vertexCount_));
  if (vertexCount_ <= 65536) {
    osg::ref_ptr<osg::DrawElementsUShort> narrow = new osg::DrawElementsUShort(mode);
    narrow->reserve(indices_.size());
    for (const std::uint32_t index : indices_)
      narrow->push_back(static_cast<GLushort>(index));
    return narrow;
  }
  osg::ref_ptr<osg::DrawElementsUInt> wide = new osg::DrawElementsUInt(mode);
  wide->asVector() = std::move(indices_);
  return wide;
}

}  // namespace tessera::gltf
