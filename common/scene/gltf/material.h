#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include <osg/CullFace>
#include <osg/FrontFace>
#include <osg/LightModel>
#include <osg/StateSet>
#include <osg/TexEnv>
#include <osg/Texture2D>
#include <osg/ref_ptr>

#include "common/scene/gltf/image.h"
#include "common/scene/gltf/load_document.h"
#include "common/scene/gltf/warnings.h"

namespace tessera::gltf {

/// KHR_texture_transform: scale, then rotation, then offset.
struct TextureTransform {
  std::array<double, 2> offset = {0, 0};
  std::array<double, 2> scale = {1, 1};
  double rotationRad = 0;

  [[nodiscard]] std::array<double, 2> apply(double u, double v) const;
};

/// The part of a material that a primitive's vertices depend on.
struct Look {
  std::array<double, 4> baseColor = {1, 1, 1, 1};  ///< linear light
  bool isOpaque = true;                            ///< alpha is drawn as 1
  bool isUnlit = false;
  int textureIndex = -1;  ///< -1: none that can be drawn
  int texCoordSet = 0;
  std::optional<TextureTransform> transform;
};

/// Which state set of a material: those of equal values share one.
struct StateVariant {
  bool isTextured = false;
  bool isLit = true;
  bool isMirrored = false;  ///< triangles wound the other way round

  [[nodiscard]] bool operator<(const StateVariant& other) const {
    return std::tie(isTextured, isLit, isMirrored) <
           std::tie(other.isTextured, other.isLit, other.isMirrored);
  }
};

/// After so many parents a shared OSG object is replaced by a shallow copy. OSG looks a dying parent up in a
/// plain list, so that a million parents of one object would take an hour to go.
inline constexpr std::size_t kMaxParents = 4096;

/// A linear light value as the byte that a display shows.
[[nodiscard]] unsigned char srgbByte(double linear);

/// Turns materials into looks and state sets. -1 names glTF's default material everywhere.
class Materials {
 public:
  Materials(const Document& document, Warnings& warnings);

  [[nodiscard]] Result<Look> look(int materialIndex);
  /// The state set for one more geometry.
  /// Precondition: look(materialIndex) succeeded, and has a texture where the variant asks for one.
  [[nodiscard]] osg::ref_ptr<osg::StateSet> stateSet(int materialIndex, StateVariant variant);

 private:
  [[nodiscard]] const tinygltf::Material& material(int materialIndex) const;
  [[nodiscard]] Result<Look> readLook(int materialIndex);
  [[nodiscard]] Status readTexture(const tinygltf::TextureInfo& info, Look& look);
  [[nodiscard]] osg::ref_ptr<osg::Texture2D> texture(int textureIndex);
  [[nodiscard]] osg::ref_ptr<osg::StateSet> makeStateSet(int materialIndex, StateVariant variant);

  const Document& document_;
  Warnings& warnings_;
  Images images_;
  tinygltf::Material defaultMaterial_;
  std::map<int, Look> looks_;
  std::map<std::pair<int, int>, osg::ref_ptr<osg::Texture2D>> textures_;           ///< by image and sampler
  std::map<std::pair<int, StateVariant>, osg::ref_ptr<osg::StateSet>> stateSets_;  ///< the latest of each
  osg::ref_ptr<osg::TexEnv> modulate_ = new osg::TexEnv(osg::TexEnv::MODULATE);
  osg::ref_ptr<osg::CullFace> cullBack_ = new osg::CullFace(osg::CullFace::BACK);
  osg::ref_ptr<osg::FrontFace> clockwise_ = new osg::FrontFace(osg::FrontFace::CLOCKWISE);
  osg::ref_ptr<osg::LightModel> twoSided_ = new osg::LightModel;
};

}  // namespace tessera::gltf
