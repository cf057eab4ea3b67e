#include "common/scene/gltf/accessor.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

namespace tessera::gltf {

namespace {

/// An accessor without a buffer view is all zeros, so its count costs the file nothing; more than this is no
/// scene.
constexpr std::size_t kMaxUnbackedElements = std::size_t{1} << 24;
/// Vertices are numbered in 32 bits.
constexpr std::size_t kMaxElements = UINT32_MAX;

constexpr std::array<unsigned char, 128> kZeros{};

constexpr const char* kExportAgain = "export it again, or check that it was copied whole";

Error fault(int accessorIndex, const std::string& what) {
  return inputError({}, "accessor " + std::to_string(accessorIndex) + " " + what, kExportAgain);
}

std::size_t componentBytes(int componentType) {
  switch (componentType) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

int componentCountOf(int type) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return 1;
    case TINYGLTF_TYPE_VEC2:
      return 2;
    case TINYGLTF_TYPE_VEC3:
      return 3;
    case TINYGLTF_TYPE_VEC4:
      return 4;
    case TINYGLTF_TYPE_MAT4:
      return 16;  // of floats, whose columns need no padding
    default:
      return 0;
  }
}

/// Whether glTF 2.0 with KHR_mesh_quantization allows this type. Quantized types are taken without the
/// extension being named too: their meaning is the same.
bool isAllowed(Attribute attribute, const Elements& e) {
  const bool isFloat = e.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT;
  const bool isSigned =
      e.componentType == TINYGLTF_COMPONENT_TYPE_BYTE || e.componentType == TINYGLTF_COMPONENT_TYPE_SHORT;
  const bool isUnsigned = e.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                          e.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
  switch (attribute) {
    case Attribute::Position:
      return e.componentCount == 3 && (isFloat || isSigned || isUnsigned);
    case Attribute::Normal:
      return e.componentCount == 3 && (isFloat || (isSigned && e.isNormalized));
    case Attribute::TexCoord:
      return e.componentCount == 2 && (isFloat || isSigned || isUnsigned);
    case Attribute::Color:
      return (e.componentCount == 3 || e.componentCount == 4) && (isFloat || (isUnsigned && e.isNormalized));
    case Attribute::Index:
      return e.componentCount == 1 && !e.isNormalized &&
             (isUnsigned || e.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
    case Attribute::Joint:
      return e.componentCount == 4 && isUnsigned && !e.isNormalized;
    case Attribute::Weight:
      return e.componentCount == 4 && (isFloat || (isUnsigned && e.isNormalized));
    case Attribute::Displacement:
      return e.componentCount == 3 && (isFloat || isSigned);
    case Attribute::Time:
      return e.componentCount == 1 && isFloat;
    case Attribute::Rotation:
      return e.componentCount == 4 && (isFloat || ((isSigned || isUnsigned) && e.isNormalized));
    case Attribute::MorphWeight:
      return e.componentCount == 1 && (isFloat || ((isSigned || isUnsigned) && e.isNormalized));
    case Attribute::Matrix:
      return e.componentCount == 16 && isFloat;
  }
  return false;
}

/// Whether `count` elements of `elementBytes`, `stride` apart from `offset` on, end within `available` bytes.
bool fits(std::size_t offset, std::size_t count, std::size_t stride, std::size_t elementBytes,
          std::size_t available) {
  if (count == 0) return offset <= available;
  if (offset > available || elementBytes > available - offset) return false;
  return (count - 1) <= (available - offset - elementBytes) / stride;
}

template <class T>
T load(const unsigned char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

template <class T>
float toFloat(T value, bool isNormalized) {
  if constexpr (std::is_same_v<T, float>) {
    return value;
  } else {
    const auto whole = static_cast<float>(value);
    if (!isNormalized) return whole;
    return std::max(whole / static_cast<float>(std::numeric_limits<T>::max()), -1.0F);
  }
}

template <class T>
void gather(const Elements& e, std::span<const std::uint32_t> picked, std::span<float> out) {
  const auto components = static_cast<std::size_t>(e.componentCount);
  const std::size_t count = picked.empty() ? e.count : picked.size();
  float* to = out.data();
  for (std::size_t i = 0; i < count; ++i) {
    const unsigned char* from = e.data + (picked.empty() ? i : picked[i]) * e.stride;
    for (std::size_t c = 0; c < components; ++c)
      *to++ = toFloat(load<T>(from + c * sizeof(T)), e.isNormalized);
  }
}

std::uint32_t loadIndex(const unsigned char* at, int componentType) {
  if (componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return *at;
  if (componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return load<std::uint16_t>(at);
  return load<std::uint32_t>(at);
}

}  // namespace

Result<std::span<const unsigned char>> bytesOfView(const tinygltf::Model& model, int viewIndex) {
  const std::string name = "buffer view " + std::to_string(viewIndex);
  if (viewIndex < 0 || static_cast<std::size_t>(viewIndex) >= model.bufferViews.size()) {
    return inputError({}, name + " does not exist", kExportAgain);
  }
  const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(viewIndex)];
  if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model.buffers.size()) {
    return inputError({}, name + " lies in buffer " + std::to_string(view.buffer) + ", which does not exist",
                      kExportAgain);
  }
  const std::vector<unsigned char>& buffer = model.buffers[static_cast<std::size_t>(view.buffer)].data;
  if (view.byteOffset > buffer.size() || view.byteLength > buffer.size() - view.byteOffset) {
    return inputError({}, name + " reaches past the end of buffer " + std::to_string(view.buffer),
                      kExportAgain);
  }
  return std::span(buffer).subspan(view.byteOffset, view.byteLength);
}

Result<std::size_t> AccessorReader::count(int accessorIndex) const {
  if (accessorIndex < 0 || static_cast<std::size_t>(accessorIndex) >= model_.accessors.size()) {
    return fault(accessorIndex, "does not exist");
  }
  return model_.accessors[static_cast<std::size_t>(accessorIndex)].count;
}

Result<Elements> AccessorReader::elements(int accessorIndex, Attribute attribute) {
  const Result<std::size_t> elementCount = count(accessorIndex);
  if (!elementCount) return elementCount.error();
  const tinygltf::Accessor& accessor = model_.accessors[static_cast<std::size_t>(accessorIndex)];
  Result<Elements> found = dense(accessor);
  if (!found) return fault(accessorIndex, found.error().what);
  if (!isAllowed(attribute, *found)) {
    return fault(accessorIndex, "has a type that its use does not allow (component type " +
                                    std::to_string(accessor.componentType) + ", " +
                                    std::to_string(found->componentCount) + " components" +
                                    (accessor.normalized ? ", normalized)" : ")"));
  }
  if (!accessor.sparse.isSparse) return found;
  Result<Elements> copy = merged(accessor, *found, accessorIndex);
  if (!copy) return fault(accessorIndex, copy.error().what);
  return copy;
}

Result<Elements> AccessorReader::dense(const tinygltf::Accessor& accessor) const {
  const std::size_t bytes = componentBytes(accessor.componentType);
  const int components = componentCountOf(accessor.type);
  if (bytes == 0 || components == 0) {
    return inputError({}, "has a type that no attribute may have (component type " +
                              std::to_string(accessor.componentType) + ")");
  }
  if (accessor.count > kMaxElements) return inputError({}, "has more elements than can be numbered");
  const std::size_t elementBytes = bytes * static_cast<std::size_t>(components);
  Elements e{kZeros.data(), accessor.count, 0, components, accessor.componentType, accessor.normalized};
  if (accessor.bufferView == -1) {
    if (accessor.count > kMaxUnbackedElements)
      return inputError({}, "has too many elements for having no data");
    return e;
  }
  const Result<std::span<const unsigned char>> view = bytesOfView(model_, accessor.bufferView);
  if (!view) return inputError({}, "cannot be read: " + view.error().what);
  const std::size_t stride = model_.bufferViews[static_cast<std::size_t>(accessor.bufferView)].byteStride;
  if (stride != 0 && stride < elementBytes) return inputError({}, "has elements longer than its byteStride");
  e.stride = stride != 0 ? stride : elementBytes;
  if (!fits(accessor.byteOffset, e.count, e.stride, elementBytes, view->size())) {
    return inputError({}, "reaches past the end of buffer view " + std::to_string(accessor.bufferView));
  }
  e.data = view->data() + accessor.byteOffset;
  return e;
}

Result<Elements> AccessorReader::merged(const tinygltf::Accessor& accessor, Elements base,
                                        int accessorIndex) {
  const std::size_t elementBytes =
      componentBytes(base.componentType) * static_cast<std::size_t>(base.componentCount);
  std::vector<unsigned char>& copy = denseCopies_[accessorIndex];
  const Elements result{copy.data(),         base.count,         elementBytes,
                        base.componentCount, base.componentType, base.isNormalized};
  if (!copy.empty()) return result;

  const auto& sparse = accessor.sparse;
  if (sparse.count < 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0) {
    return inputError({}, "has a negative number in its sparse part");
  }
  const auto sparseCount = static_cast<std::size_t>(sparse.count);
  if (sparseCount > base.count) return inputError({}, "replaces more elements than it has");
  const int indexType = sparse.indices.componentType;
  const std::size_t indexBytes = componentBytes(indexType);
  if (indexType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
      indexType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      indexType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) {
    return inputError({}, "has sparse indices of a type that is not allowed");
  }
  const auto indexView = bytesOfView(model_, sparse.indices.bufferView);
  const auto valueView = bytesOfView(model_, sparse.values.bufferView);
  if (!indexView) return inputError({}, "cannot be read: sparse indices: " + indexView.error().what);
  if (!valueView) return inputError({}, "cannot be read: sparse values: " + valueView.error().what);
  const auto indexOffset = static_cast<std::size_t>(sparse.indices.byteOffset);
  const auto valueOffset = static_cast<std::size_t>(sparse.values.byteOffset);
  if (!fits(indexOffset, sparseCount, indexBytes, indexBytes, indexView->size()) ||
      !fits(valueOffset, sparseCount, elementBytes, elementBytes, valueView->size())) {
    return inputError({}, "has a sparse part that reaches past the end of its buffer view");
  }

  std::vector<unsigned char> bytes(base.count * elementBytes);
  for (std::size_t i = 0; i < base.count; ++i) {
    std::memcpy(bytes.data() + i * elementBytes, base.data + i * base.stride, elementBytes);
  }
  for (std::size_t i = 0; i < sparseCount; ++i) {
    const std::uint32_t at = loadIndex(indexView->data() + indexOffset + i * indexBytes, indexType);
    if (at >= base.count) return inputError({}, "has a sparse index " + std::to_string(at) + " out of range");
    std::memcpy(bytes.data() + at * elementBytes, valueView->data() + valueOffset + i * elementBytes,
                elementBytes);
  }
  copy = std::move(bytes);
  Elements whole = result;
  whole.data = copy.data();
  return whole;
}

void gatherFloats(const Elements& e, std::span<const std::uint32_t> picked, std::span<float> out) {
  switch (e.componentType) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return gather<std::int8_t>(e, picked, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return gather<std::uint8_t>(e, picked, out);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return gather<std::int16_t>(e, picked, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return gather<std::uint16_t>(e, picked, out);
    default:
      return gather<float>(e, picked, out);
  }
}

std::vector<std::uint32_t> readIndices(const Elements& e) {
  std::vector<std::uint32_t> indices(e.count);
  if (e.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT && e.stride == sizeof(std::uint32_t)) {
    if (e.count > 0) std::memcpy(indices.data(), e.data, e.count * sizeof(std::uint32_t));
    return indices;
  }
  for (std::size_t i = 0; i < e.count; ++i)
    indices[i] = loadIndex(e.data + i * e.stride, e.componentType);
  return indices;
}

}  // namespace tessera::gltf
