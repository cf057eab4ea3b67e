#pragma once

#include <osg/GLExtensions>

namespace tessera {

/// A rectangle of the framebuffer, in pixels from its lower left corner.
struct PixelArea {
  int xPx = 0, yPx = 0, widthPx = 0, heightPx = 0;
  friend bool operator==(const PixelArea&, const PixelArea&) = default;
};

/// For drawing beside OpenSceneGraph: while it lives, the state of OpenGL is one that just paints (no depth
/// test, no blending, texture unit 0, no program, no buffers). After it the state is what it was, so that
/// what OpenSceneGraph remembers of it stays true.
class GlScope {
 public:
  explicit GlScope(const osg::GLExtensions& gl);
  ~GlScope();
  GlScope(const GlScope&) = delete;
  GlScope& operator=(const GlScope&) = delete;

  /// Draws to this area alone.
  void restrictTo(const PixelArea& area) const;

 private:
  const osg::GLExtensions& gl_;
  GLint program_ = 0, vertexArray_ = 0, unpackBuffer_ = 0;
};

}  // namespace tessera
