#include "common/scene/drawable_geometry.h"

#include <algorithm>

#include <osg/PrimitiveSet>

namespace tessera {

namespace {

class PointCollector : public osg::PrimitiveFunctor {
 public:
  void setVertexArray(unsigned int count, const osg::Vec2* v) override { copy(count, v, 2); }
  void setVertexArray(unsigned int count, const osg::Vec3* v) override { copy(count, v, 3); }
  void setVertexArray(unsigned int count, const osg::Vec4* v) override { copy(count, v, 3); }
  void setVertexArray(unsigned int count, const osg::Vec2d* v) override { copy(count, v, 2); }
  void setVertexArray(unsigned int count, const osg::Vec3d* v) override { copy(count, v, 3); }
  void setVertexArray(unsigned int count, const osg::Vec4d* v) override { copy(count, v, 3); }

  void drawArrays(GLenum mode, GLint first, GLsizei count) override {
    if (count <= 0) return;
    if (first < 0 || static_cast<std::size_t>(first) + static_cast<std::size_t>(count) > vertices_.size()) {
      out.problem = "draws vertices that it does not have";
      return;
    }
    countPrimitives(mode, static_cast<std::uint64_t>(count));
    for (GLsizei i = 0; i < count; ++i)
      used_[static_cast<std::size_t>(first) + static_cast<std::size_t>(i)] = true;
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

  /// Moves the used vertices out.
  void finish() {
    flush();
    for (const Vec3& p : out.points) {
      if (!p.allFinite()) {
        out.problem = "has a vertex that is not a finite number";
        return;
      }
    }
  }

  DrawableGeometry out;

 private:
  template <class V>
  void copy(unsigned int count, const V* v, int components) {
    flush();
    vertices_.resize(v ? count : 0);
    used_.assign(vertices_.size(), false);
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      vertices_[i] = Vec3(double(v[i][0]), double(v[i][1]), components > 2 ? double(v[i][2]) : 0.0);
    }
  }

  void flush() {
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (used_[i]) out.points.push_back(vertices_[i]);
    }
    vertices_.clear();
    used_.clear();
  }

  template <class Index>
  void elements(GLenum mode, GLsizei count, const Index* indices) {
    if (count <= 0 || indices == nullptr) return;
    for (GLsizei i = 0; i < count; ++i) {
      const std::size_t index = indices[i];
      if (index >= vertices_.size()) {
        out.problem = "has index " + std::to_string(index) + " where there are " +
                      std::to_string(vertices_.size()) + " vertices";
        return;
      }
      used_[index] = true;
    }
    countPrimitives(mode, static_cast<std::uint64_t>(count));
  }

  void countPrimitives(GLenum mode, std::uint64_t count) {
    ++out.primitives;
    switch (mode) {
      case GL_TRIANGLES:
        out.triangles += count / 3;
        break;
      case GL_TRIANGLE_STRIP:
      case GL_TRIANGLE_FAN:
      case GL_POLYGON:
        out.triangles += count > 2 ? count - 2 : 0;
        break;
      case GL_QUADS:
        out.triangles += count / 4 * 2;
        break;
      case GL_QUAD_STRIP:
        out.triangles += count > 2 ? (count - 2) / 2 * 2 : 0;
        break;
      default:
        break;
    }
  }

  std::vector<Vec3> vertices_;
  std::vector<bool> used_;
};

}  // namespace

DrawableGeometry geometryOf(const osg::Drawable& drawable) {
  PointCollector collector;
  if (!drawable.supports(collector)) return {};
  drawable.accept(collector);
  collector.finish();
  return std::move(collector.out);
}

}  // namespace tessera
