#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include <osg/Image>
#include <osg/Object>
#include <osg/ref_ptr>

#include "common/base/result.h"

namespace tessera {

/// Objects of OpenSceneGraph as bytes and back, by osgDB's own binary serializer. Equal objects give equal
/// bytes on every run, so a hash can name them. An image inside a state set is written as its file name
/// alone; reading asks for it by that name. Not thread-safe.
class OsgbCodec {
 public:
  OsgbCodec();
  ~OsgbCodec();
  OsgbCodec(const OsgbCodec&) = delete;
  OsgbCodec& operator=(const OsgbCodec&) = delete;

  [[nodiscard]] Result<std::string> write(const osg::Object& object) const;
  /// An image with its pixels.
  [[nodiscard]] Result<std::string> writeImage(const osg::Image& image) const;

  using ImageByName = std::function<osg::ref_ptr<osg::Image>(const std::string& name)>;
  /// `bytes` must be trusted (checked against their hash): osgDB's reader is not safe on hostile ones.
  [[nodiscard]] Result<osg::ref_ptr<osg::Object>> read(std::string_view bytes,
                                                       const ImageByName& images) const;
  /// What writeImage wrote; the same trust.
  [[nodiscard]] Result<osg::ref_ptr<osg::Image>> readImage(std::string_view bytes) const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tessera
