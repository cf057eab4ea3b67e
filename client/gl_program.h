#pragma once

#include <initializer_list>
#include <memory>
#include <string>

#include <osg/GLExtensions>

#include "common/base/result.h"

namespace tessera {

/// A GLSL 1.20 program of the context that is current, and stays so while it lives. Vertices come with
/// gl_Vertex in clip coordinates and gl_MultiTexCoord0, which the fragment shader finds in `varying vec2 at`.
class GlProgram {
 public:
  /// `fragmentSource` without #version. An error holds what the compiler says.
  [[nodiscard]] static Result<std::unique_ptr<GlProgram>> make(const osg::GLExtensions& gl,
                                                               const std::string& fragmentSource);
  ~GlProgram() { gl_.glDeleteProgram(id_); }
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;

  /// From here on OpenGL draws with it, and set() sets its uniforms.
  void use() const { gl_.glUseProgram(id_); }
  void set(const char* uniform, int value) const { gl_.glUniform1i(at(uniform), value); }
  /// 1 to 4 numbers.
  void set(const char* uniform, std::initializer_list<float> values) const;

 private:
  GlProgram(const osg::GLExtensions& gl, GLuint id) : gl_(gl), id_(id) {}
  [[nodiscard]] GLint at(const char* uniform) const { return gl_.glGetUniformLocation(id_, uniform); }

  const osg::GLExtensions& gl_;
  GLuint id_;
};

}  // namespace tessera
