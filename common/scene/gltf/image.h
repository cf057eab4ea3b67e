#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <osg/Image>
#include <osg/ref_ptr>

#include "common/scene/gltf/load_document.h"
#include "common/scene/gltf/warnings.h"

namespace tessera::gltf {

/// Decodes the images of a document, each at most once and only when asked for.
class Images {
 public:
  Images(const Document& document, Warnings& warnings) : document_(document), warnings_(warnings) {}

  /// RGBA8 with the top row of the picture first, so that glTF's texture coordinates fit as they are: OpenGL
  /// finds the first row at t = 0. Null, with a warning, where the image cannot be had.
  /// Precondition: imageIndex is an index of the model's images.
  [[nodiscard]] osg::ref_ptr<osg::Image> image(std::size_t imageIndex);

 private:
  [[nodiscard]] Result<osg::ref_ptr<osg::Image>> decode(const tinygltf::Image& source) const;

  const Document& document_;
  Warnings& warnings_;
  std::vector<std::optional<osg::ref_ptr<osg::Image>>> images_;
};

}  // namespace tessera::gltf
