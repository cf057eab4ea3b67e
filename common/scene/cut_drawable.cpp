#include "common/scene/cut_drawable.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <span>
#include <typeinfo>
#include <utility>

#include "common/geometry/box.h"
#include "common/scene/drawable_triangles.h"

namespace tessera {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

bool isPlain(const osg::PrimitiveSet& set) {
  switch (set.getType()) {
    case osg::PrimitiveSet::DrawArraysPrimitiveType:
    case osg::PrimitiveSet::DrawArrayLengthsPrimitiveType:
    case osg::PrimitiveSet::DrawElementsUBytePrimitiveType:
    case osg::PrimitiveSet::DrawElementsUShortPrimitiveType:
    case osg::PrimitiveSet::DrawElementsUIntPrimitiveType:
      return set.getNumInstances() == 0;
    default:
      return false;
  }
}

/// True for an array whose elements can be gathered for some of `vertexCount` vertices.
bool canGather(const osg::Array* array, std::size_t vertexCount) {
  if (!array) return true;
  switch (array->getBinding()) {
    case osg::Array::BIND_PER_VERTEX:
      return array->getNumElements() >= vertexCount;
    case osg::Array::BIND_OVERALL:
      return array->getNumElements() > 0;
    default:
      return false;
  }
}

bool canGather(const osg::Geometry& mesh) {
  const osg::Array* vertices = mesh.getVertexArray();
  if (!vertices || vertices->getBinding() != osg::Array::BIND_PER_VERTEX) return false;
  const std::size_t count = vertices->getNumElements();
  const auto fits = [&](const osg::ref_ptr<osg::Array>& array) { return canGather(array.get(), count); };
  return canGather(mesh.getNormalArray(), count) && canGather(mesh.getColorArray(), count) &&
         canGather(mesh.getSecondaryColorArray(), count) && canGather(mesh.getFogCoordArray(), count) &&
         std::all_of(mesh.getTexCoordArrayList().begin(), mesh.getTexCoordArrayList().end(), fits) &&
         std::all_of(mesh.getVertexAttribArrayList().begin(), mesh.getVertexAttribArrayList().end(), fits);
}

/// Orders the triangles so that every part is a range, and notes the tree's shape.
class Subdivision {
 public:
  struct Range {
    std::size_t begin = 0, end = 0;
    [[nodiscard]] std::size_t size() const { return end - begin; }
  };

  Subdivision(const DrawableTriangles& mesh, std::uint64_t maxTriangles) {
    centroids_.reserve(mesh.triangles.size());
    order.resize(mesh.triangles.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      const auto& [a, b, c] = mesh.triangles[i];
      // Divided first: the sum of three finite numbers need not be finite.
      centroids_.emplace_back(mesh.vertices[a] / 3 + mesh.vertices[b] / 3 + mesh.vertices[c] / 3);
      order[i] = static_cast<std::uint32_t>(i);
    }
    std::vector<Range> open = {{0, order.size()}};
    while (!open.empty()) {
      const Range range = open.back();
      open.pop_back();
      if (range.size() <= maxTriangles) {
        parts.push_back(range);
        shape.push_back(1);
        continue;
      }
      shape.push_back(0);
      const std::size_t middle = split(range);
      open.push_back({middle, range.end});
      open.push_back({range.begin, middle});
    }
    countParts();
  }

  std::vector<std::uint32_t> order;  ///< triangles
  std::vector<Range> parts;          ///< of `order`
  std::vector<std::uint32_t> shape;

 private:
  /// Partitions the range, keeping the order on both sides; returns where the second side begins.
  std::size_t split(const Range& range) {
    Aabb box;
    for (std::size_t i = range.begin; i < range.end; ++i)
      box.extend(centroids_[order[i]]);
    int axis = 0;
    (0.5 * box.max - 0.5 * box.min).maxCoeff(&axis);
    const double at = box.center()[axis];
    spill_.clear();
    std::size_t below = range.begin;
    for (std::size_t i = range.begin; i < range.end; ++i) {
      const std::uint32_t triangle = order[i];
      if (centroids_[triangle][axis] < at) {
        order[below++] = triangle;
      } else {
        spill_.push_back(triangle);
      }
    }
    std::copy(spill_.begin(), spill_.end(), order.begin() + static_cast<std::ptrdiff_t>(below));
    if (below == range.begin || below == range.end) return range.begin + range.size() / 2;
    return below;
  }

  /// Backwards, the children of a node are met before it, the first one last.
  void countParts() {
    std::vector<std::uint32_t> counts;
    for (auto node = shape.rbegin(); node != shape.rend(); ++node) {
      if (*node == 0) {
        *node = counts.back();
        counts.pop_back();
        *node += counts.back();
        counts.pop_back();
      }
      counts.push_back(*node);
    }
  }

  std::vector<Vec3> centroids_;
  std::vector<std::uint32_t> spill_;
};

/// Makes the geometry of one part after the other.
class PartWriter {
 public:
  PartWriter(const osg::Geometry& mesh, const DrawableTriangles& triangles)
      : mesh_(mesh), triangles_(triangles), local_(triangles.vertices.size(), kUnused) {}

  osg::ref_ptr<osg::Geometry> part(std::span<const std::uint32_t> order) {
    used_.clear();
    osg::ref_ptr<osg::DrawElementsUInt> indices = new osg::DrawElementsUInt(GL_TRIANGLES);
    indices->reserve(order.size() * 3);
    for (const std::uint32_t triangle : order) {
      for (const std::uint32_t vertex : triangles_.triangles[triangle])
        indices->push_back(localIndex(vertex));
    }
    osg::ref_ptr<osg::Geometry> out = new osg::Geometry;
    copySettings(*out);
    copyArrays(*out);
    // Below 0xFFFF: that index may mean "restart".
    if (used_.size() <= std::numeric_limits<GLushort>::max()) {
      out->addPrimitiveSet(new osg::DrawElementsUShort(GL_TRIANGLES, indices->begin(), indices->end()));
    } else {
      out->addPrimitiveSet(indices);
    }
    for (const std::uint32_t vertex : used_)
      local_[vertex] = kUnused;
    return out;
  }

 private:
  static constexpr std::uint32_t kUnused = UINT32_MAX;

  std::uint32_t localIndex(std::uint32_t vertex) {
    if (local_[vertex] == kUnused) {
      local_[vertex] = static_cast<std::uint32_t>(used_.size());
      used_.push_back(vertex);
    }
    return local_[vertex];
  }

  void copySettings(osg::Geometry& out) const {
    out.setName(mesh_.getName());
    out.setStateSet(const_cast<osg::StateSet*>(mesh_.getStateSet()));
    out.setDataVariance(mesh_.getDataVariance());
    out.setNodeMask(mesh_.getNodeMask());
    out.setCullingActive(mesh_.getCullingActive());
    out.setSupportsDisplayList(mesh_.getSupportsDisplayList());
    out.setUseDisplayList(mesh_.getUseDisplayList());
    out.setUseVertexBufferObjects(mesh_.getUseVertexBufferObjects());
    out.setUseVertexArrayObject(mesh_.getUseVertexArrayObject());
  }

  void copyArrays(osg::Geometry& out) const {
    out.setVertexArray(gathered(mesh_.getVertexArray()));
    out.setNormalArray(gathered(mesh_.getNormalArray()));
    out.setColorArray(gathered(mesh_.getColorArray()));
    out.setSecondaryColorArray(gathered(mesh_.getSecondaryColorArray()));
    out.setFogCoordArray(gathered(mesh_.getFogCoordArray()));
    for (unsigned int unit = 0; unit < mesh_.getNumTexCoordArrays(); ++unit) {
      if (const osg::Array* array = mesh_.getTexCoordArray(unit)) out.setTexCoordArray(unit, gathered(array));
    }
    for (unsigned int index = 0; index < mesh_.getNumVertexAttribArrays(); ++index) {
      if (const osg::Array* array = mesh_.getVertexAttribArray(index)) {
        out.setVertexAttribArray(index, gathered(array));
      }
    }
  }

  /// The used elements of an array of any kind; of an overall one the first, which is all that is drawn.
  osg::Array* gathered(const osg::Array* array) const {
    if (!array) return nullptr;
    auto* out = static_cast<osg::Array*>(array->cloneType());
    out->setBinding(array->getBinding());
    out->setNormalize(array->getNormalize());
    out->setPreserveDataType(array->getPreserveDataType());
    const bool isOverall = array->getBinding() == osg::Array::BIND_OVERALL;
    const std::size_t size = array->getElementSize();
    const auto* from = static_cast<const char*>(array->getDataPointer());
    out->resizeArray(isOverall ? 1 : static_cast<unsigned int>(used_.size()));
    auto* to = static_cast<char*>(const_cast<void*>(out->getDataPointer()));
    if (isOverall) {
      std::memcpy(to, from, size);
      return out;
    }
    for (const std::uint32_t vertex : used_) {
      std::memcpy(to, from + vertex * size, size);
      to += size;
    }
    return out;
  }

  const osg::Geometry& mesh_;
  const DrawableTriangles& triangles_;
  std::vector<std::uint32_t> local_;  ///< by vertex: its index in the part at hand
  std::vector<std::uint32_t> used_;   ///< the part's vertices
};

bool canCut(const osg::Geometry& mesh, std::uint64_t maxTriangles) {
  std::uint64_t indices = 0;
  for (const auto& set : mesh.getPrimitiveSetList()) {
    if (!isPlain(*set)) return false;
    indices += set->getNumIndices();
  }
  // Every triangle takes an index at least: most meshes are small and need no closer look.
  return indices > maxTriangles && canGather(mesh);
}

}  // namespace

std::optional<CutTree> cutDrawable(const osg::Drawable& drawable, std::uint64_t maxTriangles) {
  // Only the very class: one derived from it may draw something else.
  if (maxTriangles == 0 || typeid(drawable) != typeid(osg::Geometry)) return {};
  osg::ref_ptr<const osg::Geometry> mesh = drawable.asGeometry();
  if (mesh->containsDeprecatedData()) {
    osg::ref_ptr<osg::Geometry> fixed =
        new osg::Geometry(*mesh, osg::CopyOp::DEEP_COPY_ARRAYS | osg::CopyOp::DEEP_COPY_PRIMITIVES);
    fixed->fixDeprecatedData();
    mesh = fixed;
  }
  if (!canCut(*mesh, maxTriangles)) return {};
  const DrawableTriangles triangles = trianglesOf(*mesh);
  if (triangles.isMalformed || triangles.hasOther || triangles.triangles.size() <= maxTriangles ||
      triangles.triangles.size() > UINT32_MAX ||
      triangles.vertices.size() != mesh->getVertexArray()->getNumElements() ||
      !std::all_of(triangles.vertices.begin(), triangles.vertices.end(), isFinite)) {
    return {};
  }
  Subdivision subdivision(triangles, maxTriangles);
  CutTree tree;
  PartWriter writer(*mesh, triangles);
  for (const Subdivision::Range& range : subdivision.parts)
    tree.parts.push_back(writer.part(std::span(subdivision.order).subspan(range.begin, range.size())));
  tree.shape = std::move(subdivision.shape);
  return tree;
}

}  // namespace tessera
