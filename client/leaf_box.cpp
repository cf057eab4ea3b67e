#include "client/leaf_box.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace tessera {

osg::Geometry& boxOf(CachedLeaf& leaf) {
  if (leaf.box) return *leaf.box;
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
  osg::ref_ptr<osg::Vec3Array> normals = new osg::Vec3Array(osg::Array::BIND_PER_VERTEX);
  for (unsigned int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0F, 1.0F}) {
      osg::Vec3 normal;
      normal[axis] = side;
      for (const auto& [a, b] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
        osg::Vec3 corner = normal;
        corner[(axis + 1) % 3] = static_cast<float>(a);
        corner[(axis + 2) % 3] = static_cast<float>(b);
        vertices->push_back(corner);
        normals->push_back(normal);
      }
    }
  }
  osg::ref_ptr<osg::Vec4Array> color = new osg::Vec4Array(osg::Array::BIND_OVERALL);
  color->push_back(osg::Vec4(leaf.meanRgb[0], leaf.meanRgb[1], leaf.meanRgb[2], 1));
  leaf.box = new osg::Geometry;
  leaf.box->setUseDisplayList(false);
  leaf.box->setUseVertexBufferObjects(true);
  leaf.box->setVertexArray(vertices);
  leaf.box->setNormalArray(normals);
  leaf.box->setColorArray(color);
  leaf.box->addPrimitiveSet(new osg::DrawArrays(GL_QUADS, 0, static_cast<int>(vertices->size())));
  return *leaf.box;
}

Mat4 boxToWorld(const CachedLeaf& leaf) {
  Mat4 matrix = Mat4::Identity();
  for (int i = 0; i < 3; ++i)
    matrix.col(i).head<3>() = leaf.halfAxes[static_cast<std::size_t>(i)];
  matrix.col(3).head<3>() = leaf.boxCenter;
  return matrix;
}

std::uint64_t pixelsOf(const CachedLeaf& leaf, const proto::Frame& frame, std::int32_t widthPx,
                       std::int32_t heightPx) {
  const auto all = static_cast<std::uint64_t>(widthPx) * static_cast<std::uint64_t>(heightPx);
  const Vec3 back = frame.right.cross(frame.up);
  // The image rectangle, at its distance from the eye along the axis of the view.
  const Vec3 lowerLeft = frame.corners[0] - frame.eye, upperRight = frame.corners[2] - frame.eye;
  const double distance = -lowerLeft.dot(back);
  const double left = lowerLeft.dot(frame.right), bottom = lowerLeft.dot(frame.up);
  const double width = upperRight.dot(frame.right) - left, height = upperRight.dot(frame.up) - bottom;
  double minX = INFINITY, maxX = -INFINITY, minY = INFINITY, maxY = -INFINITY;
  for (unsigned int corner = 0; corner < 8; ++corner) {
    Vec3 p = leaf.boxCenter - frame.eye;
    for (unsigned int i = 0; i < 3; ++i)
      p += (corner >> i & 1U) != 0 ? leaf.halfAxes[i] : Vec3(-leaf.halfAxes[i]);
    const double depth = -p.dot(back);
    if (!(depth > frame.nearM)) return all;
    const double x = (p.dot(frame.right) * distance / depth - left) / width * widthPx;
    const double y = (p.dot(frame.up) * distance / depth - bottom) / height * heightPx;
    minX = std::min(minX, x), maxX = std::max(maxX, x);
    minY = std::min(minY, y), maxY = std::max(maxY, y);
  }
  const double columns =
      std::clamp(std::ceil(maxX), 0.0, 1.0 * widthPx) - std::clamp(std::floor(minX), 0.0, 1.0 * widthPx);
  const double rows =
      std::clamp(std::ceil(maxY), 0.0, 1.0 * heightPx) - std::clamp(std::floor(minY), 0.0, 1.0 * heightPx);
  return static_cast<std::uint64_t>(std::max(columns, 0.0) * std::max(rows, 0.0));
}

}  // namespace tessera
