#include "common/scene/gltf/image.h"

#include <array>
#include <climits>
#include <cstdint>
#include <cstring>
#include <exception>
#include <span>
#include <string>

#include "common/scene/gltf/accessor.h"

namespace tessera::gltf {

namespace {

using Bytes = std::span<const unsigned char>;

/// Larger than any GL texture, and small enough for the 32-bit sums of stb and tinygltf.
constexpr std::uint64_t kMaxSide = 32768;
constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 27;

struct Size {
  std::uint64_t width = 0;
  std::uint64_t height = 0;
};

std::uint64_t bigEndian(Bytes bytes, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i)
    value = value << 8 | bytes[at + i];
  return value;
}

std::optional<Size> sizeOfPng(Bytes bytes) {
  constexpr std::array<unsigned char, 8> kMagic = {0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A};
  if (bytes.size() < 24 || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0) return std::nullopt;
  return Size{bigEndian(bytes, 16, 4), bigEndian(bytes, 20, 4)};
}

std::optional<Size> sizeOfJpeg(Bytes bytes) {
  if (bytes.size() < 4 || bytes[0] != 0xFF || bytes[1] != 0xD8) return std::nullopt;
  std::size_t at = 2;
  while (at + 9 <= bytes.size() && bytes[at] == 0xFF) {
    const unsigned char marker = bytes[at + 1];
    const bool isFrame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (isFrame) return Size{bigEndian(bytes, at + 7, 2), bigEndian(bytes, at + 5, 2)};
    at += marker == 0xFF ? 1 : 2 + bigEndian(bytes, at + 2, 2);
  }
  return std::nullopt;
}

/// Looks at the header before the decoder allocates what it promises.
Status checkSize(Bytes bytes) {
  std::optional<Size> size = sizeOfPng(bytes);
  if (!size) size = sizeOfJpeg(bytes);
  if (!size) return inputError({}, "is neither PNG nor JPEG");
  if (size->width == 0 || size->height == 0) return inputError({}, "has no pixels");
  if (size->width > kMaxSide || size->height > kMaxSide || size->width * size->height > kMaxPixels) {
    return inputError(
        {}, "is too large (" + std::to_string(size->width) + " x " + std::to_string(size->height) + ")");
  }
  return Done{};
}

osg::ref_ptr<osg::Image> toOsg(const tinygltf::Image& decoded) {
  osg::ref_ptr<osg::Image> image = new osg::Image;
  image->allocateImage(decoded.width, decoded.height, 1, GL_RGBA, GL_UNSIGNED_BYTE, 1);
  image->setInternalTextureFormat(GL_RGBA8);
  image->setOrigin(osg::Image::TOP_LEFT);
  const std::size_t count =
      static_cast<std::size_t>(decoded.width) * static_cast<std::size_t>(decoded.height) * 4;
  if (decoded.bits == 8) {
    std::memcpy(image->data(), decoded.image.data(), count);
    return image;
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::uint16_t wide = 0;
    std::memcpy(&wide, decoded.image.data() + i * sizeof wide, sizeof wide);
    image->data()[i] = static_cast<unsigned char>((wide * 255U + 32767U) / 65535U);
  }
  return image;
}

}  // namespace

osg::ref_ptr<osg::Image> Images::image(std::size_t imageIndex) {
  images_.resize(document_.model.images.size());
  std::optional<osg::ref_ptr<osg::Image>>& slot = images_[imageIndex];
  if (slot) return *slot;
  const tinygltf::Image& source = document_.model.images[imageIndex];
  const Result<osg::ref_ptr<osg::Image>> decoded = decode(source);
  if (decoded) {
    slot = *decoded;
    (*slot)->setName(!source.name.empty()  ? source.name
                     : !source.uri.empty() ? source.uri
                                           : "image " + std::to_string(imageIndex));
  } else {
    slot = osg::ref_ptr<osg::Image>();
    warnings_.add("image not usable", "image " + std::to_string(imageIndex) + " " + decoded.error().what +
                                          "; the base colour is drawn instead");
  }
  return *slot;
}

Result<osg::ref_ptr<osg::Image>> Images::decode(const tinygltf::Image& source) const {
  Bytes bytes(source.image);
  if (source.bufferView >= 0) {
    const Result<Bytes> view = bytesOfView(document_.model, source.bufferView);
    if (!view) return inputError({}, "cannot be read: " + view.error().what);
    bytes = *view;
  } else if (bytes.empty()) {
    const auto found = document_.imageFaults.find(source.uri);
    return inputError(
        {}, "cannot be read: " + (found != document_.imageFaults.end() ? found->second : "no data"));
  }
  const Status sizeStatus = checkSize(bytes);
  if (!sizeStatus) return sizeStatus.error();
  if (bytes.size() > INT_MAX) return inputError({}, "is too large");

  tinygltf::Image decoded;
  std::string fault;
  bool ok = false;
  try {
    ok = tinygltf::LoadImageData(&decoded, 0, &fault, nullptr, 0, 0, bytes.data(),
                                 static_cast<int>(bytes.size()), nullptr);
  } catch (const std::exception&) {
    ok = false;
  }
  const std::size_t pixelBytes = decoded.bits == 16 ? 8 : 4;
  if (!ok || decoded.width <= 0 || decoded.height <= 0 || decoded.component != 4 ||
      decoded.image.size() !=
          static_cast<std::size_t>(decoded.width) * static_cast<std::size_t>(decoded.height) * pixelBytes) {
    return inputError({}, "cannot be decoded");
  }
  return toOsg(decoded);
}

}  // namespace tessera::gltf
