// The contract on real scenes: no leaf of any scene in ../shared/scenes with a triangle that meets a tile's
// closed frustum is missing from that tile's list, whatever the algorithm, the bounds and the hierarchy.
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <map>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "common/hierarchy/grid_frusta.h"
#include "common/scene/leaf_triangles.h"
#include "common/scene/load_scene.h"
#include "tests/support/cull_scene.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

/// The triangles of a scene's leaves, which say what must be drawn where; they know nothing of its bounds.
struct Geometries {
  std::vector<std::vector<Triangle>> leaves;  ///< none of a billboard: it turns to the eye
  std::vector<Aabb> boxes;                    ///< exactly of the triangles

  static Geometries of(const Scene& scene) {
    Geometries all;
    LeafTriangles source(scene);
    for (std::uint32_t leaf = 0; leaf < scene.leaves.size(); ++leaf) {
      const auto triangles = source.of(leaf);
      if (!triangles) {
        ADD_FAILURE() << triangles.error().text();
        return {};
      }
      all.leaves.emplace_back(triangles->begin(), triangles->end());
      Aabb& box = all.boxes.emplace_back();
      for (const Triangle& triangle : *triangles) {
        for (const Vec3& v : triangle)
          box.extend(v);
      }
    }
    return all;
  }
};

/// True only where a box is outside a tile's side by a million times what doubles can err by. Spares the
/// judge most of its questions.
bool isClearlyOutside(const Frustum& tile, const Aabb& box) {
  const Vec3 center = box.center(), half = box.max - center;
  const double reach = (center - tile.eye).norm() + half.norm() + tile.eye.norm();
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 a = tile.corners[i] - tile.eye, b = tile.corners[(i + 1) % 4] - tile.eye;
    const Vec3 n = b.cross(a);
    if (n.dot(center - tile.eye) + n.cwiseAbs().dot(half) < -1e-9 * a.norm() * b.norm() * reach) return true;
  }
  return false;
}

/// One camera pose before one wall.
struct View {
  std::string name;
  std::vector<std::vector<bool>> meets;  ///< by tile, then leaf of the graph
  std::uint64_t exactPairs = 0;
  GridFrusta grid, untiled;
};

struct NamedPose {
  const char* name;
  CameraPose pose;
};

/// Poses around a scene; easy to be wrong about are those with the eye, or the border of a tile, on vertices.
std::vector<NamedPose> posesFor(const Scene& scene, const Geometries& geometries) {
  Geometry random(7);
  std::vector<Vec3> vertices;
  for (int tries = 0; tries < 1000 && vertices.size() < 4; ++tries) {
    const std::vector<Triangle>& leaf = geometries.leaves[random.below(geometries.leaves.size())];
    if (!leaf.empty()) vertices.push_back(leaf[random.below(leaf.size())][random.below(3)]);
  }
  const auto [center, radius] = scene.sphere();
  vertices.resize(4, center);
  const auto poseOf = [](const Vec3& eye, const Vec3& towards) {
    return CameraPose{.eye = eye, .target = eye + towards, .up = Vec3(0, 1, 0), .fovYRad = {}};
  };
  const Vec3 onGrid(center.x() + 0.9 * radius, vertices[1].y(), vertices[2].z());
  const Vec3 aside = Vec3(random.unit01() - 0.5, 0.3 * random.unit01(), 1).normalized();
  return {
      {"all in view", poseOf(center + 2.2 * radius * aside, -radius * aside)},
      {"inside",
       poseOf(center + random.vector(0.4 * radius), random.vector(radius).cwiseProduct(Vec3(1, 0.3, 1)))},
      {"on a vertex", poseOf(vertices[0], random.vector(radius).cwiseProduct(Vec3(1, 0.3, 1)))},
      // The planes through the middle of the wall go along floors and house fronts.
      {"grazing", poseOf(onGrid, Vec3(-radius, 0, 0))},
  };
}

View viewFor(const Wall& wall, const NamedPose& named, const Scene& scene, const Geometries& geometries) {
  const auto [center, radius] = scene.sphere();
  WallView frusta = viewOf(wall, named.pose, center, radius), whole;
  const Wall untiled = wall.untiled();
  whole = viewOf(untiled, named.pose, center, radius);
  for (WallView* of : {&frusta, &whole}) {
    of->screens[0].near = of->screens[0].far = std::nullopt;
    for (Frustum& tile : of->tiles)
      tile.near = tile.far = std::nullopt;
  }
  View view{.name = std::string(named.name) + " on " + std::to_string(wall.screens[0].columns) + "x" +
                    std::to_string(wall.screens[0].rows),
            .meets = {},
            .exactPairs = 0,
            .grid = {static_cast<std::uint16_t>(wall.screens[0].columns),
                     static_cast<std::uint16_t>(wall.screens[0].rows)},
            .untiled = {1, 1}};
  view.grid.update(frusta.screens[0], frusta.tiles);
  view.untiled.update(whole.screens[0], whole.tiles);
  for (const Frustum& tile : frusta.tiles) {
    const ExactFrustum exact(tile);
    std::vector<bool>& meets = view.meets.emplace_back(geometries.leaves.size());
    for (std::size_t leaf = 0; leaf < geometries.leaves.size(); ++leaf) {
      if (geometries.leaves[leaf].empty() || isClearlyOutside(tile, geometries.boxes[leaf])) continue;
      if (containsLeaf(scene.hierarchy.absentLeaves(), static_cast<std::uint32_t>(leaf))) continue;
      meets[leaf] = std::ranges::any_of(geometries.leaves[leaf],
                                        [&](const Triangle& triangle) { return exact.meets(triangle); });
      view.exactPairs += meets[leaf] ? 1 : 0;
    }
  }
  return view;
}

struct Case {
  const char* file;
  /// Big scenes try the switches by turns: each hierarchy and wall every so many-th, together all of them.
  std::size_t every = 1;
  /// Likewise the algorithms and bounds without switches; 2: one wall each, but still all hierarchies.
  std::size_t everyPlain = 1;

  friend void PrintTo(const Case& test, std::ostream* out) { *out << test.file; }
};

class SceneContract : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    const fs::path folder = fs::path(TESSERA_SOURCE_DIR) / "../shared/scenes";
    if (!fs::is_directory(folder)) GTEST_SKIP() << "no scenes at " << folder;
    file_ = folder / GetParam().file;
  }

  void load(std::uint64_t maxTrianglesPerLeaf) {
    auto scene = loadScene(file_, {.maxTrianglesPerLeaf = maxTrianglesPerLeaf});
    ASSERT_TRUE(scene) << scene.error().text();
    graph_ = std::move(*scene);
    geometries_ = Geometries::of(graph_);
    ASSERT_EQ(geometries_.leaves.size(), graph_.leaves.size());
    walls_.clear();
    for (const auto& [columns, rows] : {std::pair{4, 4}, std::pair{3, 2}}) {
      std::vector<View>& views = walls_.emplace_back();
      for (const NamedPose& pose : posesFor(graph_, geometries_))
        views.push_back(viewFor(gridWall(columns, rows, 50), pose, graph_, geometries_));
    }
  }

  /// For each leaf of another hierarchy of the same scene its index in the graph's.
  [[nodiscard]] std::vector<std::uint32_t> orderOf(const Scene& other) const {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> leafOf;
    for (std::uint32_t leaf = 0; leaf < graph_.leaves.size(); ++leaf)
      leafOf[{graph_.leaves[leaf].graphLeaf, graph_.leaves[leaf].part}] = leaf;
    EXPECT_EQ(leafOf.size(), graph_.leaves.size());
    std::vector<std::uint32_t> order;
    for (const SceneLeaf& leaf : other.leaves)
      order.push_back(leafOf.at({leaf.graphLeaf, leaf.part}));
    return order;
  }

  /// One culler goes through all views of a wall and remembers; a fresh one must list the same.
  void judge(const Scene& scene, const std::string& hierarchy) {
    const std::vector<std::uint32_t> order = orderOf(scene);
    ASSERT_EQ(order.size(), graph_.leaves.size());
    for (const std::vector<View>& views : walls_) {
      for (std::size_t i = 0; i < candidates_.size(); ++i) {
        const auto& [name, options] = candidates_[i];
        if ((i + turn_) % (isPlain(options) ? GetParam().everyPlain : GetParam().every) != 0) continue;
        cull::Culler culler(scene.hierarchy, options);
        for (const View& view : views) {
          const cull::Result& result = culler.cull(view.grid);
          ASSERT_EQ(firstDrop(result, view.meets, order), "")
              << name << " on " << hierarchy << ", " << view.name;
          ++culls_;
          if (options.switches.motionCoherence || (i + turn_) % GetParam().every != 0) continue;
          cull::Culler fresh(scene.hierarchy, options);
          ASSERT_EQ(fresh.cull(view.grid).lists, result.lists)
              << name << " on " << hierarchy << ", " << view.name;
        }
      }
      ++turn_;
    }
  }
  static bool isPlain(const cull::Options& options) {
    const cull::Switches& s = options.switches;
    return s.firstLevel && s.planeMasking && !s.planeCoherency && !s.octantTest && !s.signTable &&
           !s.sphereFirst && !s.motionCoherence && !s.regroup;
  }

  /// Pairs of leaves with triangles.
  [[nodiscard]] std::uint64_t pairsOf(const cull::Result& result) const {
    std::uint64_t pairs = 0;
    for (const VisibleList& list : result.lists)
      forEachLeaf(list, [&](std::uint32_t leaf) { pairs += geometries_.leaves[leaf].empty() ? 0 : 1; });
    return pairs;
  }

  void expectTheUnionToBeTheWholeAndPrintTheExcess() {
    std::uint64_t pairs = 0, exact = 0;
    for (const std::vector<View>& views : walls_) {
      for (const View& view : views) {
        cull::Culler tiled(graph_.hierarchy, {}), untiled(graph_.hierarchy, {});
        const cull::Result& result = tiled.cull(view.grid);
        pairs += pairsOf(result);
        exact += view.exactPairs;
        VisibleList sum;
        for (const VisibleList& list : result.lists)
          sum = unionOf(sum, list);
        const VisibleList whole = untiled.cull(view.untiled).lists[0];
        const std::uint64_t differing =
            leafCount(differenceOf(sum, whole)) + leafCount(differenceOf(whole, sum));
        EXPECT_LE(differing, leafCount(whole) / 200 + 2)
            << view.name << ": " << leafCount(whole) << " on the wall, " << leafCount(sum) << " on its tiles";
      }
    }
    EXPECT_TRUE(exact > 0 || std::ranges::all_of(
                                 graph_.leaves,
                                 [&](const SceneLeaf& leaf) { return graph_.billboardOf(leaf) != nullptr; }))
        << "nothing is in view";
    std::printf("excess of adaptive/obb: %-45s %6zu leaves %8llu pairs %8llu exact %7.2f %%\n",
                GetParam().file, graph_.leaves.size(), static_cast<unsigned long long>(pairs),
                static_cast<unsigned long long>(exact),
                exact == 0 ? 0.0 : 100 * (static_cast<double>(pairs) / static_cast<double>(exact) - 1));
  }

  fs::path file_;
  Scene graph_;
  Geometries geometries_;
  std::vector<std::vector<View>> walls_;
  const std::vector<Candidate> candidates_ = allCandidates();
  std::size_t turn_ = 0, culls_ = 0;
};

TEST_P(SceneContract, HoldsOnEveryHierarchy) {
  for (const std::uint64_t most : {0, 200}) {
    ASSERT_NO_FATAL_FAILURE(load(most));
    if (most == 0) expectTheUnionToBeTheWholeAndPrintTheExcess();
    for (const HierarchyKind kind : {HierarchyKind::Graph, HierarchyKind::Bvh, HierarchyKind::Octree,
                                     HierarchyKind::LooseOctree, HierarchyKind::Kd}) {
      const auto scene = loadScene(file_, {.hierarchy = kind, .maxTrianglesPerLeaf = most});
      ASSERT_TRUE(scene) << scene.error().text();
      ASSERT_NO_FATAL_FAILURE(
          judge(*scene, std::string(nameOf(kind)) + " with MTPL " + std::to_string(most)));
    }
  }
  std::printf("%zu cullings\n", culls_);
}

// Those of ../shared/scenes/SCENES.md that load: not the Draco and meshopt ones, which are refused.
INSTANTIATE_TEST_SUITE_P(
    Scenes, SceneContract,
    ::testing::Values(
        Case{"city/denhaag.glb", 10, 2}, Case{"city/delft.gltf", 3}, Case{"city/munich.glb"},
        Case{"city/munich.osgt"}, Case{"city/munich.obj"}, Case{"building/clinic.glb", 20, 2},
        Case{"building/bonza_boxes.glb", 3}, Case{"building/sponza_boxes.glb"}, Case{"maps/czest2ctf.glb", 5},
        Case{"maps/ctf_inyard.glb", 5}, Case{"models/2CylinderEngine.glb", 3}, Case{"models/retroufo.glb"},
        Case{"models/many_cubes/many-cubes.gltf", 3}, Case{"models/node_hierarchy/02_node_hierarchy.gltf"},
        Case{"models/parent_inverse_anim/06_parent-inverse-anim.gltf"}, Case{"models/CesiumMan.glb"},
        Case{"models/AnimatedMorphCube/AnimatedMorphCube.gltf"}, Case{"ext/delft_quantized.glb", 3},
        Case{"ext/gpu_instancing/24_gpu_instancing.gltf"}, Case{"osg/cow.osgt"}, Case{"osg/glider.osgt"},
        Case{"osg/dumptruck.osgt"}, Case{"osg/spaceship.osgt"}, Case{"osg/lz.osgt"}, Case{"osg/clock.osgt"},
        Case{"osg/robot.osgt"}, Case{"track/e-speedway.ac", 3}, Case{"track/e-speedway.osgt", 3}),
    [](const auto& test) {
      std::string name = test.param.file;
      std::ranges::replace_if(
          name, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
      return name;
    });

}  // namespace
}  // namespace tessera::test
