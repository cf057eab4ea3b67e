#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <osg/Geometry>
#include <osg/ref_ptr>

#include "common/scene/gltf/accessor.h"
#include "common/scene/gltf/material.h"
#include "common/scene/gltf/motion_reader.h"
#include "common/scene/gltf/warnings.h"

namespace tessera::gltf {

[[nodiscard]] constexpr bool isTriangleMode(int mode) {
  return mode >= 4 && mode <= 6;
}

/// Builds the Geometry of one primitive, without its state set.
class PrimitiveReader {
 public:
  /// `name` is how warnings call the primitive ("mesh 3 primitive 0").
  PrimitiveReader(const tinygltf::Primitive& primitive, const Look& look, MeshDeforms deforms,
                  AccessorReader& accessors, Warnings& warnings, std::string name)
      : primitive_(primitive),
        look_(look),
        deforms_(deforms),
        accessors_(accessors),
        warnings_(warnings),
        name_(std::move(name)) {}

  /// Null, with a warning, where nothing is to be drawn. Called once.
  [[nodiscard]] Result<osg::ref_ptr<osg::Geometry>> read();
  /// What the primitive's state set must be like. Called after read().
  [[nodiscard]] StateVariant variant() const { return variant_; }

 private:
  [[nodiscard]] int accessorOf(const std::string& attribute) const;
  [[nodiscard]] Result<Elements> elementsOf(const std::string& attribute, Attribute use);
  [[nodiscard]] Status checkAttributes() const;
  [[nodiscard]] Result<bool> readDrawOrder();
  [[nodiscard]] bool trim(std::size_t& drawn);
  void dropUnusedVertices();
  [[nodiscard]] Status readPositions();
  [[nodiscard]] Status readNormals();
  void makeFlatNormals();
  [[nodiscard]] Status readTexCoords();
  [[nodiscard]] Status readColors();
  [[nodiscard]] Status readDeformation();
  [[nodiscard]] Status readJoints();
  [[nodiscard]] Status readTargets();
  [[nodiscard]] Result<std::vector<float>> readFloats(const std::string& attribute, Attribute use);
  [[nodiscard]] std::vector<float> gathered(Elements elements) const;
  [[nodiscard]] Status checkFinite(std::span<const float> values, std::size_t perVertex,
                                   const std::string& attribute) const;
  [[nodiscard]] osg::ref_ptr<osg::PrimitiveSet> makePrimitiveSet();
  void skip(const std::string& why);

  const tinygltf::Primitive& primitive_;
  const Look& look_;
  const MeshDeforms deforms_;
  AccessorReader& accessors_;
  Warnings& warnings_;
  std::string name_;

  int mode_ = 4;                   ///< glTF's, which is OpenGL's
  std::size_t accessorCount_ = 0;  ///< vertices that the accessors hold
  std::size_t vertexCount_ = 0;    ///< vertices that the geometry gets
  bool isIndexed_ = false;
  std::vector<std::uint32_t> indices_;  ///< into the kept vertices
  std::vector<std::uint32_t> kept_;  ///< vertices of the accessors, in their new order; empty: the first ones
  Elements positions_;
  osg::ref_ptr<osg::Geometry> geometry_ = new osg::Geometry;
  osg::ref_ptr<osg::Vec3Array> vertices_;
  StateVariant variant_;
};

}  // namespace tessera::gltf
