#include "common/scene/drawable_triangles.h"

#include <osg/PrimitiveSet>

namespace tessera {

namespace {

class TriangleCollector : public osg::PrimitiveFunctor {
 public:
  void setVertexArray(unsigned int count, const osg::Vec2* v) override { append(count, v, 2); }
  void setVertexArray(unsigned int count, const osg::Vec3* v) override { append(count, v, 3); }
  void setVertexArray(unsigned int count, const osg::Vec4* v) override { append(count, v, 3); }
  void setVertexArray(unsigned int count, const osg::Vec2d* v) override { append(count, v, 2); }
  void setVertexArray(unsigned int count, const osg::Vec3d* v) override { append(count, v, 3); }
  void setVertexArray(unsigned int count, const osg::Vec4d* v) override { append(count, v, 3); }

  void drawArrays(GLenum mode, GLint first, GLsizei count) override {
    if (count <= 0) return;
    const auto begin = static_cast<std::size_t>(first), n = static_cast<std::size_t>(count);
    if (first < 0 || begin + n > out.vertices.size() - base_) {
      out.isMalformed = true;
      return;
    }
    add(mode, n, [&](std::size_t i) { return static_cast<std::uint32_t>(base_ + begin + i); });
  }
  void drawElements(GLenum mode, GLsizei count, const GLubyte* indices) override {
    elements(mode, count, indices);
  }
  void drawElements(GLenum mode, GLsizei count, const GLushort* indices) override {
    elements(mode, count, indices);
  }
  void drawElements(GLenum mode, GLsizei count, const GLuint* indices) override {
    elements(mode, count, indices);
  }

  DrawableTriangles out;

 private:
  template <class V>
  void append(unsigned int count, const V* v, int components) {
    base_ = out.vertices.size();
    if (v == nullptr) return;
    if (base_ + count > UINT32_MAX) {
      out.isMalformed = true;
      return;
    }
    out.vertices.reserve(base_ + count);
    for (std::size_t i = 0; i < count; ++i) {
      out.vertices.emplace_back(double(v[i][0]), double(v[i][1]), components > 2 ? double(v[i][2]) : 0.0);
    }
  }

  template <class Index>
  void elements(GLenum mode, GLsizei count, const Index* indices) {
    if (count <= 0 || indices == nullptr) return;
    const auto n = static_cast<std::size_t>(count);
    for (std::size_t i = 0; i < n; ++i) {
      if (indices[i] >= out.vertices.size() - base_) {
        out.isMalformed = true;
        return;
      }
    }
    add(mode, n, [&](std::size_t i) { return static_cast<std::uint32_t>(base_ + indices[i]); });
  }

  void emit(std::uint32_t a, std::uint32_t b, std::uint32_t c) { out.triangles.push_back({a, b, c}); }

  /// `at(i)`: index of the primitive's i-th vertex. osg::TriangleIndexFunctor would turn every other triangle
  /// of a strip, and quads, so that another vertex is the provoking one.
  template <class At>
  void add(GLenum mode, std::size_t count, At at) {
    switch (mode) {
      case GL_TRIANGLES:
        for (std::size_t i = 2; i < count; i += 3)
          emit(at(i - 2), at(i - 1), at(i));
        break;
      case GL_TRIANGLE_STRIP:
        for (std::size_t i = 2; i < count; ++i)
          i % 2 == 0 ? emit(at(i - 2), at(i - 1), at(i)) : emit(at(i - 1), at(i - 2), at(i));
        break;
      case GL_TRIANGLE_FAN:
        for (std::size_t i = 2; i < count; ++i)
          emit(at(0), at(i - 1), at(i));
        break;
      case GL_POLYGON:  // a polygon's provoking vertex is its first
        for (std::size_t i = 2; i < count; ++i)
          emit(at(i - 1), at(i), at(0));
        break;
      case GL_QUADS:
        for (std::size_t i = 3; i < count; i += 4) {
          emit(at(i - 3), at(i - 2), at(i));
          emit(at(i - 2), at(i - 1), at(i));
        }
        break;
      case GL_QUAD_STRIP:
        for (std::size_t i = 3; i < count; i += 2) {
          emit(at(i - 1), at(i - 3), at(i));
          emit(at(i - 3), at(i - 2), at(i));
        }
        break;
      default:
        out.hasOther = true;
        addOther(mode, count, at);
        break;
    }
  }

  template <class At>
  void addOther(GLenum mode, std::size_t count, At at) {
    const auto line = [&](std::size_t p, std::size_t q) { emit(at(p), at(q), at(q)); };
    switch (mode) {
      case GL_LINES:
        for (std::size_t i = 1; i < count; i += 2)
          line(i - 1, i);
        break;
      case GL_LINE_STRIP:
      case GL_LINE_LOOP:
        for (std::size_t i = 1; i < count; ++i)
          line(i - 1, i);
        if (mode == GL_LINE_LOOP && count > 2) line(count - 1, 0);
        break;
      default:
        for (std::size_t i = 0; i < count; ++i)
          emit(at(i), at(i), at(i));
        break;
    }
  }

  std::size_t base_ = 0;  ///< where the current vertex array begins
};

}  // namespace

DrawableTriangles trianglesOf(const osg::Drawable& drawable) {
  TriangleCollector collector;
  if (!drawable.supports(collector)) return {};
  drawable.accept(collector);
  return std::move(collector.out);
}

}  // namespace tessera
