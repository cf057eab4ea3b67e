#include "tests/support/cull_scene.h"

#include <cmath>
#include <numbers>

namespace tessera::test {

Wall gridWall(int columns, int rows, double fovYDeg) {
  return tessera::gridWall(columns, rows, 64, 48, fovYDeg * std::numbers::pi / 180);
}

Triangle Geometry::any(const Vec3& center, double size) {
  const Vec3 middle = center + vector(size);
  const double small = size * std::pow(10.0, -3 * unit01());
  return {middle + vector(small), middle + vector(small), middle + vector(small)};
}

Triangle Geometry::hard(std::span<const Frustum> tiles) {
  const Frustum& tile = tiles[below(tiles.size())];
  const std::size_t i = below(4);
  const Vec3& a = tile.corners[i];
  const Vec3& b = tile.corners[(i + 1) % 4];
  const double depth = std::pow(10.0, -3 * unit01());
  const double along = below(3) == 0 ? static_cast<double>(below(2)) : unit01();  // often on a ray
  const Vec3 onPlane = tile.eye + depth * (a + along * (b - a) - tile.eye);
  Triangle triangle = {onPlane, onPlane, onPlane};
  const double spread = std::pow(10.0, -12 * unit01()) * (onPlane - tile.eye).norm();
  const std::size_t distinct = below(8) == 0 ? 1 + below(2) : 3;
  for (std::size_t k = 1; k < distinct; ++k)
    triangle[k] += vector(spread);
  for (Vec3& v : triangle) {
    for (double& x : v) {
      if (below(4) == 0) x = std::nextafter(x, below(2) ? 1e300 : -1e300);
    }
  }
  return triangle;
}

Triangle Geometry::aboutTheEye(const Vec3& eye, double size) {
  const double scale = size * std::pow(10.0, 6 * unit01() - 4);
  const Vec3 a = vector(scale), b = vector(scale);
  switch (below(3)) {
    case 0:
      return {eye, eye + a, eye + b};
    case 1:  // the eye lies within
      return {eye + a, eye + b, eye - (a + b)};
    default:
      return {eye + a, eye - a, eye + b};
  }
}

void TriangleScene::build(std::mt19937_64& random) {
  ObjectHierarchyBuilder builder;
  int open = 0;
  for (const Triangle& t : leaves) {
    while (open > 0 && random() % 3 == 0)
      builder.closeNode(), --open;
    while (random() % 3 == 0)
      builder.openNode(), ++open;
    builder.addLeaf(boundsOf(t, Vec3::Zero()));
  }
  while (open-- > 0)
    builder.closeNode();
  hierarchy = builder.finish();
}

std::vector<Bounds> TriangleScene::bounds() const {
  std::vector<Bounds> all;
  for (const Triangle& t : leaves)
    all.push_back(boundsOf(t, Vec3::Zero()));
  return all;
}

std::vector<std::vector<bool>> exactVisibility(std::span<const Frustum> tiles,
                                               std::span<const Triangle> leaves) {
  std::vector<std::vector<bool>> meets(tiles.size(), std::vector<bool>(leaves.size()));
  for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
    const ExactFrustum exact(tiles[tile]);
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf)
      meets[tile][leaf] = exact.meets(leaves[leaf]);
  }
  return meets;
}

std::vector<Candidate> allCandidates() {
  using cull::Algorithm, cull::BoundsKind, cull::Switches;
  std::vector<Candidate> all;
  const auto add = [&all](Algorithm algorithm, BoundsKind bounds, const Switches& switches,
                          const std::string& name) {
    const cull::Options options{.algorithm = algorithm, .bounds = bounds, .switches = switches};
    if (cull::check(options)) {
      all.push_back({std::string(cull::nameOf(algorithm)) + " " + std::string(cull::nameOf(bounds)) +
                         (name.empty() ? "" : " " + name),
                     options});
    }
  };
  struct Named {
    const char* name;
    Switches switches;
  };
  const std::array variants = {
      Named{"no-first-level", {.firstLevel = false}},
      Named{"no-plane-masking", {.planeMasking = false}},
      Named{"plane-coherency", {.planeCoherency = true}},
      Named{"octant-test", {.octantTest = true}},
      Named{"sign-table", {.signTable = true}},
      Named{"sphere-first", {.sphereFirst = true}},
      Named{"motion-coherence", {.motionCoherence = true}},
      Named{"regroup", {.regroup = true, .regroupFrom = 2}},
      Named{"no-refine", {.refine = false}},
      Named{"coherent", {.coherent = cull::Reuse::Always}},
      Named{"all",
            {.planeCoherency = true, .octantTest = true, .sphereFirst = true, .motionCoherence = true}},
      Named{"all with sign-table",
            {.planeCoherency = true, .octantTest = true, .signTable = true, .motionCoherence = true}},
  };
  for (const Algorithm algorithm :
       {Algorithm::None, Algorithm::Naive, Algorithm::Oh, Algorithm::Fh, Algorithm::Adaptive,
        Algorithm::AdaptiveListing, Algorithm::Footprint, Algorithm::Table, Algorithm::Auto}) {
    for (const BoundsKind bounds : {BoundsKind::Sphere, BoundsKind::Aabb, BoundsKind::Obb, BoundsKind::Hybrid,
                                    BoundsKind::AabbThenObb}) {
      if (algorithm == Algorithm::None && bounds != BoundsKind::Obb) continue;
      add(algorithm, bounds, {}, "");
      if (algorithm == Algorithm::None) continue;
      if (bounds != BoundsKind::Aabb && bounds != BoundsKind::Obb) continue;
      for (const Named& variant : variants)
        add(algorithm, bounds, variant.switches, variant.name);
    }
  }
  return all;
}

std::string firstDrop(const cull::Result& result, const std::vector<std::vector<bool>>& meets,
                      std::span<const std::uint32_t> order) {
  for (std::size_t tile = 0; tile < meets.size(); ++tile) {
    const VisibleList& list = result.lists[tile];
    const auto leafCount = static_cast<std::uint32_t>(meets[tile].size());
    if (!isCanonical(list, leafCount))
      return "the list of tile " + std::to_string(tile) + " is not canonical";
    for (std::uint32_t leaf = 0; leaf < leafCount; ++leaf) {
      const std::uint32_t index = order.empty() ? leaf : order[leaf];
      if (meets[tile][index] && !containsLeaf(list, leaf))
        return "leaf " + std::to_string(index) + " of tile " + std::to_string(tile);
    }
  }
  return {};
}

}  // namespace tessera::test
