#include "common/scene/asset_writer.h"

#include <cmath>
#include <span>

#include <osg/Geometry>
#include <osg/Material>
#include <osg/Texture>

#include "common/scene/drawable_geometry.h"

namespace tessera {

namespace {

/// A box whose middle is this many times its half size away from the origin is stored relative to its middle.
/// From 4 on the subtraction is exact in float: all vertices and the middle then share an exponent, or
/// nearly.
constexpr double kFarRatio = 4;

Vec3 originFor(std::span<const Vec3> points) {
  Aabb box;
  for (const Vec3& p : points)
    box.extend(p);
  Vec3 origin = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const double middle = 0.5 * box.min[i] + 0.5 * box.max[i];
    const double half = 0.5 * box.max[i] - 0.5 * box.min[i];
    if (std::abs(middle) > kFarRatio * half && middle != 0)
      origin[i] = static_cast<double>(static_cast<float>(middle));
  }
  return origin;
}

/// The vertices of `array` relative to `origin`, as float; null for kinds of arrays that stay as they are.
osg::ref_ptr<osg::Vec3Array> relativeVertices(const osg::Array& array, const Vec3& origin) {
  const auto convert = [&](const auto& vertices) {
    osg::ref_ptr<osg::Vec3Array> out = new osg::Vec3Array;
    out->reserve(vertices.size());
    for (const auto& v : vertices) {
      out->push_back(osg::Vec3(static_cast<float>(double(v[0]) - origin.x()),
                               static_cast<float>(double(v[1]) - origin.y()),
                               static_cast<float>(double(v[2]) - origin.z())));
    }
    return out;
  };
  if (const auto* floats = dynamic_cast<const osg::Vec3Array*>(&array)) return convert(*floats);
  if (const auto* doubles = dynamic_cast<const osg::Vec3dArray*>(&array)) return convert(*doubles);
  return nullptr;
}

/// Per axis, how far float(v - origin) + origin may lie from any of the points v: half an ulp, or half the
/// least denormal; both kept twice, which also covers the rounding of the difference in double.
Vec3 storageErrorOf(std::span<const Vec3> points, const Vec3& origin) {
  Vec3 reach = Vec3::Zero();
  for (const Vec3& p : points)
    reach = reach.cwiseMax((p - origin).cwiseAbs());
  return reach * 0x1p-23 + Vec3::Constant(0x1p-149);
}

/// None where the vertices have no colours of their own.
std::optional<osg::Vec4> meanOfVertices(const osg::Geometry& mesh) {
  const osg::Array* colors = mesh.getColorArray();
  if (!colors || colors->getNumElements() == 0) return {};
  osg::Vec4 sum;
  const auto count = static_cast<float>(colors->getNumElements());
  if (const auto* floats = dynamic_cast<const osg::Vec4Array*>(colors)) {
    for (const osg::Vec4& color : *floats)
      sum += color;
    return sum / count;
  }
  if (const auto* bytes = dynamic_cast<const osg::Vec4ubArray*>(colors)) {
    for (const osg::Vec4ub& color : *bytes)
      sum += osg::Vec4(color.r(), color.g(), color.b(), color.a());
    return sum / (255 * count);
  }
  return {};
}

/// Of a grid of 16 x 16 pixels: enough for a colour from far away.
osg::Vec4 meanOfPixels(const osg::Image& image) {
  constexpr int kSide = 16;
  osg::Vec4 sum;
  if (!image.valid()) return {1, 1, 1, 1};
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      sum += image.getColor(static_cast<unsigned int>(column * image.s() / kSide),
                            static_cast<unsigned int>(row * image.t() / kSide));
    }
  }
  return sum / (kSide * kSide);
}

/// What says nothing about how a thing looks must not be part of its name.
void stripIdentity(osg::Drawable& drawable) {
  drawable.setName({});
  drawable.setStateSet(nullptr);
  drawable.setUserDataContainer(nullptr);
  drawable.setUpdateCallback(nullptr);
  drawable.setEventCallback(nullptr);
  drawable.setCullCallback(nullptr);
  drawable.setDrawCallback(nullptr);
  drawable.setUseDisplayList(false);
  drawable.setUseVertexBufferObjects(true);
}

}  // namespace

Vec3 storageOriginOf(const osg::Drawable& drawable) {
  return originFor(geometryOf(drawable).points);
}

Result<const WrittenDrawable*> AssetWriter::writeDrawable(const osg::Drawable& drawable, const Vec3* origin) {
  const auto [entry, isNew] = drawables_.try_emplace(&drawable);
  WrittenDrawable& written = entry->second;
  if (!isNew) {
    if (!written.isEmpty && written.points.empty()) written.points = geometryOf(drawable).points;
    return &written;
  }
  DrawableGeometry geometry = geometryOf(drawable);
  if (!geometry.problem.empty()) return inputError("", geometry.problem);
  written.points = std::move(geometry.points);
  written.triangles = geometry.triangles;
  written.isEmpty = written.points.empty();
  if (written.isEmpty) return &written;

  osg::ref_ptr<osg::Drawable> copy = static_cast<osg::Drawable*>(drawable.clone(osg::CopyOp::SHALLOW_COPY));
  stripIdentity(*copy);
  if (osg::Geometry* mesh = copy->asGeometry()) {
    if (mesh->containsDeprecatedData()) mesh->fixDeprecatedData();
    written.meanColor = meanOfVertices(*mesh);
    written.origin = origin ? *origin : originFor(written.points);
    const osg::Array* vertices = mesh->getVertexArray();
    const bool isDouble = dynamic_cast<const osg::Vec3dArray*>(vertices) != nullptr;
    if (vertices && (isDouble || !written.origin.isZero())) {
      if (osg::ref_ptr<osg::Vec3Array> relative = relativeVertices(*vertices, written.origin)) {
        mesh->setVertexArray(relative);
        if (isDouble) written.storageError = storageErrorOf(written.points, written.origin);
      } else {
        written.origin.setZero();
      }
    }
  }
  Result<std::string> bytes = codec_.write(*copy);
  if (!bytes) return bytes.error();
  if (bytes->size() > kMaxAssetBytes)
    return inputError("", "is larger than 255 MiB; cut it into several primitives");
  const auto asset = assets_->add(AssetKind::Drawable, std::move(*bytes));
  if (!asset) return asset.error();
  written.asset = *asset;
  return &written;
}

std::vector<Vec3> AssetWriter::takePoints(const osg::Drawable& drawable) {
  return std::exchange(drawables_.at(&drawable).points, {});
}

const osg::StateSet* AssetWriter::merged(const osg::StateSet* inherited, const osg::StateSet* own) {
  if (own == nullptr) return inherited;
  if (inherited == nullptr) return own;
  osg::ref_ptr<const osg::StateSet>& entry = merged_[{inherited, own}];
  if (!entry) {
    osg::ref_ptr<osg::StateSet> sum = new osg::StateSet(*inherited);
    sum->merge(*own);
    if (own->useRenderBinDetails()) {
      sum->setRenderBinDetails(own->getBinNumber(), own->getBinName(), own->getRenderBinMode());
    }
    entry = sum;
  }
  return entry;
}

Result<std::uint32_t> AssetWriter::writeState(const osg::StateSet* state) {
  if (const auto known = states_.find(state); known != states_.end()) return known->second;
  osg::ref_ptr<osg::StateSet> copy = state
                                         ? new osg::StateSet(*state, osg::CopyOp::DEEP_COPY_STATEATTRIBUTES |
                                                                         osg::CopyOp::DEEP_COPY_TEXTURES)
                                         : new osg::StateSet;
  copy->setName({});
  copy->setUserDataContainer(nullptr);
  copy->setUpdateCallback(nullptr);
  copy->setEventCallback(nullptr);
  const StateColor color = colorOf(*copy);
  auto images = nameImages(*copy);
  if (!images) return images.error();
  Result<std::string> bytes = codec_.write(*copy);
  if (!bytes) return bytes.error();
  const auto asset = assets_->add(AssetKind::State, std::move(*bytes), *images);
  if (!asset) return asset;
  states_.emplace(state, *asset);
  colors_.emplace(*asset, color);
  return asset;
}

StateColor AssetWriter::colorOf(const osg::StateSet& state) {
  StateColor color;
  const auto* material =
      dynamic_cast<const osg::Material*>(state.getAttribute(osg::StateAttribute::MATERIAL));
  if (material) color.material = material->getDiffuse(osg::Material::FRONT);
  const auto* texture =
      dynamic_cast<const osg::Texture*>(state.getTextureAttribute(0, osg::StateAttribute::TEXTURE));
  if (const osg::Image* image = texture && texture->getNumImages() > 0 ? texture->getImage(0) : nullptr) {
    const auto [known, isNew] = imageColors_.try_emplace(image);
    if (isNew) known->second = meanOfPixels(*image);
    color.texture = known->second;
  }
  return color;
}

/// Writes the images of the state's textures and renames each to its id, which is what the state's bytes say.
Result<std::vector<std::uint32_t>> AssetWriter::nameImages(osg::StateSet& state) {
  std::vector<std::uint32_t> images;
  for (unsigned int unit = 0; unit < state.getTextureAttributeList().size(); ++unit) {
    auto* texture =
        dynamic_cast<osg::Texture*>(state.getTextureAttribute(unit, osg::StateAttribute::TEXTURE));
    if (!texture) continue;
    for (unsigned int i = 0; i < texture->getNumImages(); ++i) {
      osg::Image* image = texture->getImage(i);
      if (!image) continue;
      const auto asset = writeImage(*image);
      if (!asset) return asset.error();
      images.push_back(*asset);
    }
  }
  return images;
}

Result<std::uint32_t> AssetWriter::writeImage(osg::Image& image) {
  if (const auto known = images_.find(&image); known != images_.end()) return known->second;
  image.setName({});
  image.setFileName({});
  image.setWriteHint(osg::Image::NO_PREFERENCE);
  Result<std::string> bytes = codec_.writeImage(image);
  if (!bytes) return bytes.error();
  if (bytes->size() > kMaxAssetBytes)
    return inputError("", "an image is larger than 255 MiB", "make it smaller");
  const auto asset = assets_->add(AssetKind::Image, std::move(*bytes));
  if (!asset) return asset;
  image.setFileName(assets_->row(*asset).id.hex());
  image.setWriteHint(osg::Image::EXTERNAL_FILE);
  images_.emplace(&image, *asset);
  return asset;
}

}  // namespace tessera
