#include "client/gl_program.h"

#include <array>

namespace tessera {

namespace {

constexpr const char* kVertexSource = R"(#version 120
varying vec2 at;
void main() {
  gl_Position = vec4(gl_Vertex.xy, 0.0, 1.0);
  at = gl_MultiTexCoord0.xy;
}
)";

using Log = std::array<char, 1024>;

Error failure(const char* what, const Log& log) {
  return runtimeError("OpenGL", std::string(what) + ": " + log.data(),
                      "a driver with OpenGL 2.1 or later is needed");
}

Result<GLuint> compiled(const osg::GLExtensions& gl, GLenum kind, const std::string& source) {
  const GLuint shader = gl.glCreateShader(kind);
  const char* text = source.c_str();
  gl.glShaderSource(shader, 1, &text, nullptr);
  gl.glCompileShader(shader);
  GLint isGood = 0;
  gl.glGetShaderiv(shader, GL_COMPILE_STATUS, &isGood);
  if (isGood) return shader;
  Log log = {};
  gl.glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  gl.glDeleteShader(shader);
  return failure("cannot compile a shader", log);
}

}  // namespace

Result<std::unique_ptr<GlProgram>> GlProgram::make(const osg::GLExtensions& gl,
                                                   const std::string& fragmentSource) {
  if (!gl.isGlslSupported) return failure("has no shaders", Log{});
  const auto vertex = compiled(gl, GL_VERTEX_SHADER, kVertexSource);
  if (!vertex) return vertex.error();
  const auto fragment = compiled(gl, GL_FRAGMENT_SHADER, "#version 120\n" + fragmentSource);
  if (!fragment) {
    gl.glDeleteShader(*vertex);
    return fragment.error();
  }
  const GLuint id = gl.glCreateProgram();
  for (const GLuint shader : {*vertex, *fragment}) {
    gl.glAttachShader(id, shader);
    gl.glDeleteShader(shader);  // once the program lets go of it
  }
  gl.glLinkProgram(id);
  std::unique_ptr<GlProgram> program(new GlProgram(gl, id));
  GLint isGood = 0;
  gl.glGetProgramiv(id, GL_LINK_STATUS, &isGood);
  if (isGood) return program;
  Log log = {};
  gl.glGetProgramInfoLog(id, static_cast<GLsizei>(log.size()), nullptr, log.data());
  return failure("cannot link a shader program", log);
}

void GlProgram::set(const char* uniform, std::initializer_list<float> values) const {
  const float* v = values.begin();
  switch (values.size()) {
    case 1:
      return gl_.glUniform1f(at(uniform), v[0]);
    case 2:
      return gl_.glUniform2f(at(uniform), v[0], v[1]);
    case 3:
      return gl_.glUniform3f(at(uniform), v[0], v[1], v[2]);
    case 4:
      return gl_.glUniform4f(at(uniform), v[0], v[1], v[2], v[3]);
    default:
      return;
  }
}

}  // namespace tessera
