#pragma once

#include <memory>

#include <osg/GLExtensions>

#include "client/gl_program.h"
#include "client/gl_scope.h"
#include "client/gl_texture.h"
#include "common/base/result.h"
#include "common/image/picture.h"

namespace tessera {

/// Puts pictures made by the processor on the framebuffer. Lives in the context that is current, which must
/// stay so. Leaves the state of OpenGL as it was.
class GlPicture {
 public:
  /// Keeps `gl`.
  [[nodiscard]] static Result<std::unique_ptr<GlPicture>> make(const osg::GLExtensions& gl);

  /// What draw() shows from now on. Fails where it is larger than a texture may be.
  [[nodiscard]] Status upload(const Picture& picture);

  /// Fills `area` with the picture: pixel by pixel where it has the same size, else smoothed. `opacity` is
  /// that of black; what is brighter covers more, white all.
  void draw(const PixelArea& area, float opacity = 1) const;

 private:
  GlPicture(const osg::GLExtensions& gl, std::unique_ptr<GlProgram> program)
      : gl_(gl), program_(std::move(program)) {}

  const osg::GLExtensions& gl_;
  std::unique_ptr<GlProgram> program_;
  GlTexture texture_{GL_LINEAR};
  int widthPx_ = 0, heightPx_ = 0;
};

}  // namespace tessera
