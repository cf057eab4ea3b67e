#include "common/scene/osgb_codec.h"

#include <sstream>
#include <streambuf>

#include <osgDB/Options>
#include <osgDB/Registry>

namespace tessera {

namespace {

/// Answers requests for images by name during a read, and every other request with "not found": nothing is
/// ever read from the disk on behalf of an asset.
class ImageSource : public osgDB::ReadFileCallback {
 public:
  OsgbCodec::ImageByName images;

  osgDB::ReaderWriter::ReadResult readImage(const std::string& name, const osgDB::Options*) override {
    osg::ref_ptr<osg::Image> image = images ? images(name) : nullptr;
    if (!image) return osgDB::ReaderWriter::ReadResult::FILE_NOT_FOUND;
    return image.get();
  }
  osgDB::ReaderWriter::ReadResult readObject(const std::string&, const osgDB::Options*) override {
    return osgDB::ReaderWriter::ReadResult::FILE_NOT_FOUND;
  }
  osgDB::ReaderWriter::ReadResult readNode(const std::string&, const osgDB::Options*) override {
    return osgDB::ReaderWriter::ReadResult::FILE_NOT_FOUND;
  }
  osgDB::ReaderWriter::ReadResult readShader(const std::string&, const osgDB::Options*) override {
    return osgDB::ReaderWriter::ReadResult::FILE_NOT_FOUND;
  }
};

/// A stream over memory that is not copied.
class ViewBuffer : public std::streambuf {
 public:
  explicit ViewBuffer(std::string_view bytes) {
    char* begin = const_cast<char*>(bytes.data());
    setg(begin, begin, begin + bytes.size());
  }

 protected:
  pos_type seekoff(off_type off, std::ios_base::seekdir dir, std::ios_base::openmode) override {
    char* base = dir == std::ios_base::beg ? eback() : dir == std::ios_base::cur ? gptr() : egptr();
    const off_type target = (base - eback()) + off;
    if (target < 0 || target > egptr() - eback()) return pos_type(off_type(-1));
    setg(eback(), eback() + target, egptr());
    return pos_type(target);
  }
  pos_type seekpos(pos_type pos, std::ios_base::openmode which) override {
    return seekoff(off_type(pos), std::ios_base::beg, which);
  }
};

/// Null where the plugin is missing.
osgDB::ReaderWriter* osgbPlugin() {
  return osgDB::Registry::instance()->getReaderWriterForExtension("osgb");
}

Error missingPlugin() {
  return runtimeError("OpenSceneGraph", "its osgb plugin is missing",
                      "install the openscenegraph package's plugins");
}

/// `write` is given the plugin and the stream.
template <class Write>
Result<std::string> written(const osg::Object& object, Write write) {
  osgDB::ReaderWriter* osgb = osgbPlugin();
  if (!osgb) return missingPlugin();
  std::ostringstream out(std::ios::binary);
  const osgDB::ReaderWriter::WriteResult result = write(*osgb, out);
  if (!result.success()) {
    return runtimeError("", std::string("cannot serialize a ") + object.libraryName() +
                                "::" + object.className() + " " + result.message());
  }
  return std::move(out).str();
}

}  // namespace

struct OsgbCodec::Options {
  osg::ref_ptr<osgDB::Options> externalImages = new osgDB::Options("WriteImageHint=UseExternal");
  osg::ref_ptr<osgDB::Options> inlineImages = new osgDB::Options("WriteImageHint=IncludeData");
  osg::ref_ptr<osgDB::Options> reading = new osgDB::Options;
  osg::ref_ptr<ImageSource> source = new ImageSource;
};

OsgbCodec::OsgbCodec() : options_(std::make_unique<Options>()) {
  options_->reading->setReadFileCallback(options_->source);
  options_->reading->setObjectCacheHint(osgDB::Options::CACHE_NONE);
}

OsgbCodec::~OsgbCodec() = default;

Result<std::string> OsgbCodec::write(const osg::Object& object) const {
  return written(object, [&](osgDB::ReaderWriter& osgb, std::ostream& out) {
    return osgb.writeObject(object, out, options_->externalImages);
  });
}

Result<std::string> OsgbCodec::writeImage(const osg::Image& image) const {
  // As a mere object an image would be written without its pixels.
  return written(image, [&](osgDB::ReaderWriter& osgb, std::ostream& out) {
    return osgb.writeImage(image, out, options_->inlineImages);
  });
}

Result<osg::ref_ptr<osg::Object>> OsgbCodec::read(std::string_view bytes, const ImageByName& images) const {
  osgDB::ReaderWriter* osgb = osgbPlugin();
  if (!osgb) return missingPlugin();
  ViewBuffer buffer(bytes);
  std::istream in(&buffer);
  options_->source->images = images;
  osgDB::ReaderWriter::ReadResult result = osgb->readObject(in, options_->reading);
  options_->source->images = nullptr;
  osg::ref_ptr<osg::Object> object = result.takeObject();
  if (!object) return runtimeError("", "cannot be read: " + result.message());
  return object;
}

Result<osg::ref_ptr<osg::Image>> OsgbCodec::readImage(std::string_view bytes) const {
  osgDB::ReaderWriter* osgb = osgbPlugin();
  if (!osgb) return missingPlugin();
  ViewBuffer buffer(bytes);
  std::istream in(&buffer);
  osgDB::ReaderWriter::ReadResult result = osgb->readImage(in, options_->reading);
  osg::ref_ptr<osg::Image> image = result.takeImage();
  if (!image || image->data() == nullptr)
    return runtimeError("", "is an image without pixels: " + result.message());
  return image;
}

}  // namespace tessera
