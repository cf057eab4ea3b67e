#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include <tiny_gltf.h>

#include "common/base/result.h"

namespace tessera::gltf {

/// The elements of one accessor. Every one of the `count` lies inside memory that may be read; element i
/// begins at data + i * stride, at any alignment. Valid as long as the AccessorReader and its model.
struct Elements {
  const unsigned char* data = nullptr;
  std::size_t count = 0;
  std::size_t stride = 0;
  int componentCount = 0;
  int componentType = 0;
  bool isNormalized = false;
};

/// What an accessor is used for, which decides the types it may have.
enum class Attribute {
  Position,
  Normal,
  TexCoord,
  Color,
  Index,
  Joint,         ///< four numbers of joints
  Weight,        ///< of four joints
  Displacement,  ///< of a morph target; also keys of translation and scale
  Time,          ///< of a key
  Rotation,      ///< keys: quaternions
  MorphWeight,   ///< keys: one number each
  Matrix,        ///< 4 x 4, by column
};

/// Finds and checks accessors. Sparse ones are merged into a dense copy once, which this object keeps.
class AccessorReader {
 public:
  explicit AccessorReader(const tinygltf::Model& model) : model_(model) {}

  /// The count alone, for attributes that are not read.
  [[nodiscard]] Result<std::size_t> count(int accessorIndex) const;
  /// The elements, checked against their buffer and against the types that `attribute` may have.
  [[nodiscard]] Result<Elements> elements(int accessorIndex, Attribute attribute);

 private:
  [[nodiscard]] Result<Elements> dense(const tinygltf::Accessor& accessor) const;
  [[nodiscard]] Result<Elements> merged(const tinygltf::Accessor& accessor, Elements base, int accessorIndex);

  const tinygltf::Model& model_;
  std::map<int, std::vector<unsigned char>> denseCopies_;
};

/// The bytes of a buffer view, checked against its buffer.
[[nodiscard]] Result<std::span<const unsigned char>> bytesOfView(const tinygltf::Model& model, int viewIndex);

/// The elements `picked` (all, in order, where it is empty) as floats, packed. Integers become the nearest
/// float of c or, normalized, of what glTF 2.0 defines. Precondition: picked[i] < elements.count, `out` has
/// the room.
void gatherFloats(const Elements& elements, std::span<const std::uint32_t> picked, std::span<float> out);

/// The elements of an index accessor. Precondition: it was asked for as Attribute::Index.
[[nodiscard]] std::vector<std::uint32_t> readIndices(const Elements& elements);

}  // namespace tessera::gltf
