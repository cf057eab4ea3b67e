#include <algorithm>

#include <gtest/gtest.h>

#include "common/scene/gltf/import_gltf.h"
#include "tests/common/scene/gltf_builder.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

// ---- real scenes

class RealGltf : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::is_directory(scenes())) GTEST_SKIP() << "no scenes at " << scenes();
  }
  static fs::path scenes() { return fs::path(TESSERA_SOURCE_DIR) / "../shared/scenes"; }
};

TEST_F(RealGltf, haveTheirNodesPrimitivesAndTriangles) {
  struct Known {
    const char* file;
    std::size_t nodes;
    std::size_t primitives;
    std::size_t triangles;
  };
  const std::vector<Known> all = {
      {"city/denhaag.glb", 8587, 5971, 41187},
      {"city/delft.gltf", 650, 570, 36267},
      {"city/munich.glb", 125, 111, 3411},
      {"building/clinic.glb", 23818, 14783, 1010815},
      {"building/bonza_boxes.glb", 368, 486, 5832},
      {"building/sponza_boxes.glb", 27, 25, 300},
      {"maps/czest2ctf.glb", 3572, 1797, 37302},
      {"maps/ctf_inyard.glb", 3204, 1917, 29322},
      {"models/2CylinderEngine.glb", 82, 115, 121496},
      {"models/retroufo.glb", 253, 77, 16428},
      {"models/many_cubes/many-cubes.gltf", 506, 501, 6012},
      {"models/node_hierarchy/02_node_hierarchy.gltf", 3, 2, 60},
      {"models/parent_inverse_anim/06_parent-inverse-anim.gltf", 12, 10, 120},
      {"models/CesiumMan.glb", 22, 1, 4672},
      {"models/AnimatedMorphCube/AnimatedMorphCube.gltf", 1, 1, 12},
      {"ext/delft_quantized.glb", 1220, 570, 36267},
      {"ext/gpu_instancing/24_gpu_instancing.gltf", 6, 3, 8066},
  };
  for (const Known& known : all) {
    const auto graph = importGltf(scenes() / known.file);
    ASSERT_TRUE(graph) << errorOf(graph);
    const SceneFigures figures = figuresOf(*graph);
    EXPECT_EQ(figures.nodes, known.nodes) << known.file;
    EXPECT_EQ(figures.leaves, known.primitives) << known.file;
    EXPECT_EQ(figures.triangles, known.triangles) << known.file;
    EXPECT_EQ(graph->gltfSources.size(), known.nodes) << known.file;
  }
}

TEST_F(RealGltf, warnOfInstancing) {
  const auto graph = importGltf(scenes() / "ext/gpu_instancing/24_gpu_instancing.gltf");
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_TRUE(warns(*graph, "EXT_mesh_gpu_instancing"));
}

TEST_F(RealGltf, refuseCompressedOnesByName) {
  for (const char* file :
       {"ext/2CylinderEngine_draco/2CylinderEngine.gltf", "ext/milktruck_draco/CesiumMilkTruck.gltf"}) {
    EXPECT_NE(errorOf(importGltf(scenes() / file)).find("KHR_draco_mesh_compression"), std::string::npos);
  }
  for (const char* file : {"ext/box_meshopt/BoxMeshopt.glb", "ext/box_meshopt/BoxMeshopt.gltf",
                           "ext/pirate_meshopt_quantized.glb"}) {
    EXPECT_NE(errorOf(importGltf(scenes() / file)).find("EXT_meshopt_compression"), std::string::npos);
  }
}

TEST_F(RealGltf, quantizedDelftHasTheBoundsOfDelft) {
  const auto plain = importGltf(scenes() / "city/delft.gltf");
  const auto quantized = importGltf(scenes() / "ext/delft_quantized.glb");
  ASSERT_TRUE(plain && quantized);
  const SceneFigures a = figuresOf(*plain);
  const SceneFigures b = figuresOf(*quantized);
  ASSERT_EQ(a.boxes.size(), b.boxes.size());
  for (std::size_t i = 0; i < a.boxes.size(); ++i) {
    const osg::Vec3d size = a.boxes[i]._max - a.boxes[i]._min;
    const double slack = std::max({size.x(), size.y(), size.z()}) / 32767 + 1e-4;
    EXPECT_NEAR((a.boxes[i]._min - b.boxes[i]._min).length(), 0, slack) << i;
    EXPECT_NEAR((a.boxes[i]._max - b.boxes[i]._max).length(), 0, slack) << i;
  }
}

TEST_F(RealGltf, everyPrefixIsAnError) {
  std::ifstream in(scenes() / "city/munich.glb", std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  const TempFolder folder;
  for (std::size_t length = 0; length < bytes.size(); length += length < 200 ? 1 : bytes.size() / 100) {
    ASSERT_FALSE(importGltf(folder.write("cut.glb", bytes.substr(0, length)))) << length;
  }
}

}  // namespace
}  // namespace tessera::test
