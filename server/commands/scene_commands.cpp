#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "common/base/file.h"
#include "common/scene/synthetic/synthetic.h"
#include "server/commands/commands.h"
#include "server/commands/inputs.h"

namespace tessera {

namespace {

using Json = nlohmann::ordered_json;

Json vec(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

Json leafJson(const Scene& scene, std::uint32_t leaf) {
  const SceneLeaf& from = scene.leaves[leaf];
  const Aabb& box = scene.hierarchy.aabb(scene.hierarchy.nodeOfLeaf(leaf));
  const Json source =
      scene.isGltf ? Json{{"node", from.source.gltfNode}, {"primitive", from.source.gltfPrimitive}}
                   : Json{{"node_path", scene.nodePathOf(leaf)}, {"drawable", from.source.osgDrawable}};
  return {{"id", leaf},
          {"path", scene.pathOf(leaf)},
          {"source", source},
          {"box", {{"min", vec(box.min)}, {"max", vec(box.max)}}},
          {"triangles", from.triangles}};
}

struct Summary {
  std::uint32_t inner, leaves;
};

Json sceneJson(const Scene& scene, const Summary& summary) {
  const ObjectHierarchy& oh = scene.hierarchy;
  Json leaves = Json::array();
  for (std::uint32_t leaf = 0; leaf < oh.leafCount(); ++leaf)
    leaves.push_back(leafJson(scene, leaf));
  return {{"format", "tessera-scene"},
          {"version", 1},
          {"scene", scene.source},
          {"nodes", oh.nodeCount()},
          {"inner_nodes", summary.inner},
          {"leaf_count", summary.leaves},
          {"mean_branching", oh.meanBranching()},
          {"depth", oh.depth()},
          {"triangles", scene.triangleCount()},
          {"assets", scene.assets.size()},
          {"asset_bytes", scene.assets.bytes()},
          {"box", {{"min", vec(oh.aabb(0).min)}, {"max", vec(oh.aabb(0).max)}}},
          {"center", vec(scene.sphere().center)},
          {"radius", scene.sphere().radius},
          {"warnings", scene.warnings},
          {"leaves", leaves}};
}

struct InspectFlags {
  InputFiles files;
  std::string json;
};

Status inspect(const InspectFlags& flags) {
  const auto scene = flags.files.readScene();
  if (!scene) return scene.error();
  const ObjectHierarchy& oh = scene->hierarchy;
  const Summary summary{oh.nodeCount() - oh.leafCount(), oh.leafCount()};
  const Vec3 extent = oh.aabb(0).max - oh.aabb(0).min;
  std::printf("nodes      %u (%u inner, %u leaves), branching %.2f, depth %u\n", oh.nodeCount(),
              summary.inner, summary.leaves, oh.meanBranching(), oh.depth());
  std::printf("triangles  %llu\n", static_cast<unsigned long long>(scene->triangleCount()));
  std::printf("size       %g x %g x %g about (%g, %g, %g)\n", extent.x(), extent.y(), extent.z(),
              scene->sphere().center.x(), scene->sphere().center.y(), scene->sphere().center.z());
  std::printf("assets     %zu, %.2f MB\n", scene->assets.size(),
              static_cast<double>(scene->assets.bytes()) / 1e6);
  if (flags.json.empty()) return Done{};
  return writeFileAtomically(flags.json, sceneJson(*scene, summary).dump() + "\n");
}

struct MakeFlags {
  std::uint64_t seed = 1, triangles = 0, leaves = 0;
  std::string out;
};

template <class Options>
Status writeScene(const MakeFlags& flags, Result<std::string> (*make)(const Options&),
                  const Options& options) {
  const auto bytes = make(options);
  if (!bytes) return bytes.error();
  if (Status status = writeFileAtomically(flags.out, *bytes); !status) return status;
  std::printf("%s: %.2f MB\n", flags.out.c_str(), static_cast<double>(bytes->size()) / 1e6);
  return Done{};
}

std::shared_ptr<MakeFlags> addKind(CLI::App& make, const char* kind, const char* description,
                                   CLI::App*& app) {
  app = make.add_subcommand(kind, description);
  auto flags = std::make_shared<MakeFlags>();
  app->add_option("--seed", flags->seed, "The same arguments give the same bytes")->capture_default_str();
  app->add_option("--out", flags->out, "The .glb to write")->required();
  return flags;
}

void addMakeCommand(CLI::App& scene, std::vector<Command>& commands) {
  CLI::App* make = scene.add_subcommand("make", "Makes a synthetic scene as .glb");
  make->require_subcommand(1);
  CLI::App* app = nullptr;

  auto plant = addKind(*make, "powerplant", "A power plant of 5,037 nodes, 3,919 of them leaves", app);
  plant->triangles = PowerPlantOptions{}.triangles;
  app->add_option("--triangles", plant->triangles, "Triangles, to within 1 %")->capture_default_str();
  commands.push_back({app, [plant] {
                        return writeScene(
                            *plant, makePowerPlantGlb,
                            PowerPlantOptions{.seed = plant->seed, .triangles = plant->triangles});
                      }});

  auto palace = addKind(*make, "fatehpur", "A palace of 770 nodes, 482 of them leaves", app);
  palace->triangles = FatehpurOptions{}.triangles;
  app->add_option("--triangles", palace->triangles, "Triangles, to within 1 %")->capture_default_str();
  commands.push_back({app, [palace] {
                        return writeScene(
                            *palace, makeFatehpurGlb,
                            FatehpurOptions{.seed = palace->seed, .triangles = palace->triangles});
                      }});

  auto city = addKind(*make, "city", "A city of exactly as many leaves as asked for", app);
  city->leaves = CityOptions{}.leaves;
  app->add_option("--leaves", city->leaves, "Leaves")->capture_default_str();
  commands.push_back({app, [city] {
                        return writeScene(*city, makeCityGlb,
                                          CityOptions{.seed = city->seed, .leaves = city->leaves});
                      }});
}

}  // namespace

void addSceneCommands(CLI::App& tessera, std::vector<Command>& commands) {
  CLI::App* scene = tessera.add_subcommand("scene", "What is in a scene; synthetic scenes");
  scene->require_subcommand(1);
  CLI::App* app = scene->add_subcommand("inspect", "Counts, sizes and every leaf of a scene");
  auto flags = std::make_shared<InspectFlags>();
  app->add_option("scene,--scene", flags->files.scene, "The scene file")->required();
  flags->files.addUp(*app);
  flags->files.addStore(*app);
  app->add_option("--json", flags->json, "Write all of it to this file");
  commands.push_back({app, [flags] { return inspect(*flags); }});
  addMakeCommand(*scene, commands);
}

}  // namespace tessera
