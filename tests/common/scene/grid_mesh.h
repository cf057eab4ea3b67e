#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include <osg/Geometry>

namespace tessera {

/// A wavy sheet of `side` x `side` squares over [0, side]^2, two indexed triangles each.
inline osg::ref_ptr<osg::Geometry> gridMesh(std::uint32_t side, double x0 = 0) {
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
  osg::ref_ptr<osg::DrawElementsUInt> indices = new osg::DrawElementsUInt(GL_TRIANGLES);
  for (std::uint32_t y = 0; y <= side; ++y) {
    for (std::uint32_t x = 0; x <= side; ++x) {
      vertices->push_back(osg::Vec3(static_cast<float>(x0 + x), static_cast<float>(y),
                                    static_cast<float>(std::sin(0.3 * x) * std::cos(0.2 * y))));
      if (x == side || y == side) continue;
      const std::uint32_t a = y * (side + 1) + x, b = a + side + 1;
      for (const std::uint32_t i : {a, a + 1, b, b, a + 1, b + 1})
        indices->push_back(i);
    }
  }
  osg::ref_ptr<osg::Geometry> mesh = new osg::Geometry;
  mesh->setVertexArray(vertices);
  mesh->addPrimitiveSet(indices);
  return mesh;
}

}  // namespace tessera
