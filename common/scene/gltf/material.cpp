#include "common/scene/gltf/material.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <osg/AlphaFunc>
#include <osg/BlendFunc>
#include <osg/Material>

namespace tessera::gltf {

namespace {

constexpr const char* kUnlit = "KHR_materials_unlit";
constexpr const char* kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";
constexpr const char* kTextureTransform = "KHR_texture_transform";

using tinygltf::Value;

/// The IEC 61966-2-1 curve, on [0, 1].
double toSrgb(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
}

template <class Container>
bool isIndexOf(int index, const Container& container) {
  return index >= 0 && static_cast<std::size_t>(index) < container.size();
}

/// The member of an object; null where it is missing (Value::Get asserts on anything but objects).
const Value* member(const Value& object, const char* key) {
  return object.Has(key) ? &object.Get(key) : nullptr;
}

/// Fills `out` from an array of as many numbers; false where `value` is something else.
template <std::size_t N>
bool readNumbers(const Value& value, std::array<double, N>& out) {
  if (!value.IsArray() || value.ArrayLen() != N) return false;
  for (std::size_t i = 0; i < N; ++i) {
    const Value& number = value.Get(static_cast<int>(i));
    if (!number.IsNumber()) return false;
    out[i] = number.GetNumberAsDouble();
  }
  return true;
}

bool readTransform(const Value& extension, Look& look) {
  TextureTransform transform;
  const Value* offset = member(extension, "offset");
  const Value* scale = member(extension, "scale");
  const Value* rotation = member(extension, "rotation");
  const Value* texCoord = member(extension, "texCoord");
  if (offset != nullptr && !readNumbers(*offset, transform.offset)) return false;
  if (scale != nullptr && !readNumbers(*scale, transform.scale)) return false;
  if (rotation != nullptr && !rotation->IsNumber()) return false;
  if (texCoord != nullptr && (!texCoord->IsInt() || texCoord->GetNumberAsInt() < 0)) return false;
  if (rotation != nullptr) transform.rotationRad = rotation->GetNumberAsDouble();
  if (texCoord != nullptr) look.texCoordSet = texCoord->GetNumberAsInt();
  look.transform = transform;
  return true;
}

/// The base colour and its texture as the older specular-glossiness model names them.
bool readSpecularGlossiness(const Value& extension, Look& look, tinygltf::TextureInfo& texture) {
  const Value* factor = member(extension, "diffuseFactor");
  const Value* info = member(extension, "diffuseTexture");
  look.baseColor = {1, 1, 1, 1};
  texture = {};
  if (factor != nullptr && !readNumbers(*factor, look.baseColor)) return false;
  if (info == nullptr) return true;
  const Value* index = member(*info, "index");
  const Value* texCoord = member(*info, "texCoord");
  if (index == nullptr || !index->IsInt()) return false;
  if (texCoord != nullptr && (!texCoord->IsInt() || texCoord->GetNumberAsInt() < 0)) return false;
  texture.index = index->GetNumberAsInt();
  if (texCoord != nullptr) texture.texCoord = texCoord->GetNumberAsInt();
  const Value* extensions = member(*info, "extensions");
  const Value* transform = extensions != nullptr ? member(*extensions, kTextureTransform) : nullptr;
  if (transform != nullptr) texture.extensions[kTextureTransform] = *transform;
  return true;
}

osg::Texture::WrapMode wrapMode(int code) {
  if (code == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return osg::Texture::CLAMP_TO_EDGE;
  if (code == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return osg::Texture::MIRROR;
  return osg::Texture::REPEAT;
}

osg::Texture::FilterMode minFilter(int code) {
  switch (code) {
    case TINYGLTF_TEXTURE_FILTER_NEAREST:
      return osg::Texture::NEAREST;
    case TINYGLTF_TEXTURE_FILTER_LINEAR:
      return osg::Texture::LINEAR;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_NEAREST:
      return osg::Texture::NEAREST_MIPMAP_NEAREST;
    case TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_NEAREST:
      return osg::Texture::LINEAR_MIPMAP_NEAREST;
    case TINYGLTF_TEXTURE_FILTER_NEAREST_MIPMAP_LINEAR:
      return osg::Texture::NEAREST_MIPMAP_LINEAR;
    default:
      return osg::Texture::LINEAR_MIPMAP_LINEAR;
  }
}

/// Fixed-function shading for metallic-roughness: a highlight that is tinted on metal and fades as the
/// surface gets rough. Diffuse light stays on metals too, since nothing is there for them to reflect.
osg::ref_ptr<osg::Material> makeShading(const tinygltf::Material& source, const Look& look) {
  const double metallic = std::clamp(source.pbrMetallicRoughness.metallicFactor, 0.0, 1.0);
  const double roughness = std::clamp(source.pbrMetallicRoughness.roughnessFactor, 0.0, 1.0);
  const double strength = 0.5 * (1 - roughness) * (1 - roughness);
  osg::Vec4f base(0, 0, 0, 1);
  osg::Vec4f specular(0, 0, 0, 1);
  osg::Vec4f emission(0, 0, 0, 1);
  for (unsigned int i = 0; i < 3; ++i) {
    const double shown = toSrgb(look.baseColor[i]);
    base[i] = static_cast<float>(shown);
    specular[i] = static_cast<float>(strength * (1 - metallic + metallic * shown));
    if (source.emissiveTexture.index < 0 && i < source.emissiveFactor.size()) {
      emission[i] = static_cast<float>(toSrgb(source.emissiveFactor[i]));
    }
  }
  const double exponent = 2 / std::max(std::pow(roughness, 4), 1e-3) - 2;
  osg::ref_ptr<osg::Material> shading = new osg::Material;
  shading->setColorMode(osg::Material::AMBIENT_AND_DIFFUSE);
  shading->setAmbient(osg::Material::FRONT_AND_BACK, base);
  shading->setDiffuse(osg::Material::FRONT_AND_BACK, base);
  shading->setSpecular(osg::Material::FRONT_AND_BACK, specular);
  shading->setEmission(osg::Material::FRONT_AND_BACK, emission);
  shading->setShininess(osg::Material::FRONT_AND_BACK, static_cast<float>(std::clamp(exponent, 0.0, 128.0)));
  return shading;
}

void setAlphaMode(osg::StateSet& states, const tinygltf::Material& source) {
  if (source.alphaMode == "MASK") {
    const auto cutoff = static_cast<float>(source.alphaCutoff);
    states.setAttributeAndModes(new osg::AlphaFunc(osg::AlphaFunc::GEQUAL, cutoff));
  } else if (source.alphaMode == "BLEND") {
    states.setAttributeAndModes(
        new osg::BlendFunc(osg::BlendFunc::SRC_ALPHA, osg::BlendFunc::ONE_MINUS_SRC_ALPHA));
    states.setRenderingHint(osg::StateSet::TRANSPARENT_BIN);
  }
}

}  // namespace

std::array<double, 2> TextureTransform::apply(double u, double v) const {
  const double s = std::sin(rotationRad);
  const double c = std::cos(rotationRad);
  const double x = u * scale[0];
  const double y = v * scale[1];
  // Counter-clockwise as seen with v running downward.
  return {c * x + s * y + offset[0], c * y - s * x + offset[1]};
}

unsigned char srgbByte(double linear) {
  return static_cast<unsigned char>(std::lround(255 * toSrgb(linear)));
}

Materials::Materials(const Document& document, Warnings& warnings)
    : document_(document), warnings_(warnings), images_(document, warnings) {
  twoSided_->setTwoSided(true);
}

const tinygltf::Material& Materials::material(int materialIndex) const {
  return materialIndex < 0 ? defaultMaterial_
                           : document_.model.materials[static_cast<std::size_t>(materialIndex)];
}

Result<Look> Materials::look(int materialIndex) {
  if (const auto found = looks_.find(materialIndex); found != looks_.end()) return found->second;
  Result<Look> made = readLook(materialIndex);
  if (!made) {
    return inputError({}, "material " + std::to_string(materialIndex) + " " + made.error().what,
                      made.error().mend);
  }
  looks_.emplace(materialIndex, *made);
  return made;
}

Result<Look> Materials::readLook(int materialIndex) {
  if (materialIndex != -1 && !isIndexOf(materialIndex, document_.model.materials)) {
    return inputError({}, "does not exist", "export it again");
  }
  const tinygltf::Material& source = material(materialIndex);
  Look look;
  look.isOpaque = source.alphaMode != "MASK" && source.alphaMode != "BLEND";
  look.isUnlit = source.extensions.contains(kUnlit);
  tinygltf::TextureInfo info = source.pbrMetallicRoughness.baseColorTexture;
  const std::vector<double>& factor = source.pbrMetallicRoughness.baseColorFactor;
  if (factor.size() != look.baseColor.size())
    return inputError({}, "has a baseColorFactor that is not 4 numbers");
  std::copy(factor.begin(), factor.end(), look.baseColor.begin());
  if (const auto found = source.extensions.find(kSpecularGlossiness); found != source.extensions.end()) {
    if (!readSpecularGlossiness(found->second, look, info)) {
      return inputError({}, std::string("has a malformed ") + kSpecularGlossiness, "export it again");
    }
  }
  if (source.emissiveTexture.index >= 0) {
    warnings_.add("emissive texture", "material " + std::to_string(materialIndex) +
                                          " has an emissive texture, which is not drawn");
  }
  if (info.index == -1) return look;
  const Status status = readTexture(info, look);
  if (!status) return status.error();
  return look;
}

Status Materials::readTexture(const tinygltf::TextureInfo& info, Look& look) {
  const tinygltf::Model& model = document_.model;
  const std::string name = "texture " + std::to_string(info.index);
  if (!isIndexOf(info.index, model.textures))
    return inputError({}, "uses " + name + ", which does not exist");
  look.texCoordSet = info.texCoord;
  if (const auto found = info.extensions.find(kTextureTransform); found != info.extensions.end()) {
    if (!readTransform(found->second, look)) return inputError({}, "has a malformed KHR_texture_transform");
  }
  const tinygltf::Texture& source = model.textures[static_cast<std::size_t>(info.index)];
  if (source.sampler != -1 && !isIndexOf(source.sampler, model.samplers)) {
    return inputError(
        {}, "uses " + name + " with sampler " + std::to_string(source.sampler) + ", which does not exist");
  }
  if (source.source == -1) {
    warnings_.add("image not usable", name + " has no PNG or JPEG image; the base colour is drawn instead");
    return Done{};
  }
  if (!isIndexOf(source.source, model.images)) {
    return inputError(
        {}, "uses " + name + " with image " + std::to_string(source.source) + ", which does not exist");
  }
  if (images_.image(static_cast<std::size_t>(source.source))) look.textureIndex = info.index;
  return Done{};
}

osg::ref_ptr<osg::Texture2D> Materials::texture(int textureIndex) {
  const tinygltf::Texture& source = document_.model.textures[static_cast<std::size_t>(textureIndex)];
  osg::ref_ptr<osg::Texture2D>& texture = textures_[{source.source, source.sampler}];
  if (texture) return texture;
  tinygltf::Sampler sampler;
  if (source.sampler >= 0) sampler = document_.model.samplers[static_cast<std::size_t>(source.sampler)];
  texture = new osg::Texture2D(images_.image(static_cast<std::size_t>(source.source)));
  texture->setWrap(osg::Texture::WRAP_S, wrapMode(sampler.wrapS));
  texture->setWrap(osg::Texture::WRAP_T, wrapMode(sampler.wrapT));
  texture->setFilter(osg::Texture::MIN_FILTER, minFilter(sampler.minFilter));
  texture->setFilter(osg::Texture::MAG_FILTER, sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST
                                                   ? osg::Texture::NEAREST
                                                   : osg::Texture::LINEAR);
  texture->setResizeNonPowerOfTwoHint(false);
  return texture;
}

osg::ref_ptr<osg::StateSet> Materials::stateSet(int materialIndex, StateVariant variant) {
  osg::ref_ptr<osg::StateSet>& states = stateSets_[{materialIndex, variant}];
  if (!states) states = makeStateSet(materialIndex, variant);
  if (states->getNumParents() >= kMaxParents) states = new osg::StateSet(*states, osg::CopyOp::SHALLOW_COPY);
  return states;
}

osg::ref_ptr<osg::StateSet> Materials::makeStateSet(int materialIndex, StateVariant variant) {
  const tinygltf::Material& source = material(materialIndex);
  const Look& seen = looks_.at(materialIndex);
  osg::ref_ptr<osg::StateSet> states = new osg::StateSet;
  states->setAttributeAndModes(makeShading(source, seen));
  states->setMode(GL_LIGHTING, variant.isLit ? osg::StateAttribute::ON : osg::StateAttribute::OFF);
  states->setMode(GL_NORMALIZE, osg::StateAttribute::ON);  // nodes may scale
  if (variant.isTextured) {
    states->setTextureAttributeAndModes(0, texture(seen.textureIndex));
    states->setTextureAttribute(0, modulate_);
  }
  setAlphaMode(*states, source);
  if (source.doubleSided) {
    states->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
    states->setAttributeAndModes(twoSided_);
  } else {
    states->setAttributeAndModes(cullBack_);
  }
  if (variant.isMirrored) states->setAttributeAndModes(clockwise_);
  return states;
}

}  // namespace tessera::gltf
