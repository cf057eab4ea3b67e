#pragma once

#include <osg/GL>

namespace tessera {

/// A two-dimensional texture of the context that is current, and stays so while it lives: clamped to its
/// edges, without mip maps, empty at first. All members but the destructor bind it to the active unit.
class GlTexture {
 public:
  /// `filter`: GL_NEAREST or GL_LINEAR.
  explicit GlTexture(GLint filter) {
    glGenTextures(1, &id_);
    bind();
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, kClampToEdge);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, kClampToEdge);
  }
  ~GlTexture() { glDeleteTextures(1, &id_); }
  GlTexture(const GlTexture&) = delete;
  GlTexture& operator=(const GlTexture&) = delete;

  void bind() const { glBindTexture(GL_TEXTURE_2D, id_); }

  /// The largest side of a texture.
  [[nodiscard]] static int maxSidePx() {
    GLint side = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
    return side;
  }

 private:
  static constexpr GLint kClampToEdge = 0x812F;  // GL_CLAMP_TO_EDGE
  GLuint id_ = 0;
};

}  // namespace tessera
