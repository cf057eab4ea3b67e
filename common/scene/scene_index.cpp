#include "common/scene/scene_index.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "common/scene/index_sections.h"
#include "common/scene/scene_motion.h"

namespace tessera {

namespace {

using Json = nlohmann::json;

// Numbers of sections; they keep their meaning for as long as kSceneIndexVersion stays.
enum Section : std::uint32_t {
  kFacts = 0,
  kLeaves,
  kBillboards,
  kPathNodes,
  kNames,
  kAssets,
  kAssetNeeds,
  kAssetPlaces,
  kMotion,
  kHierarchy = 32,  ///< and the numbers that follow: ObjectHierarchy::Arrays
};

std::string factsOf(const Scene& scene, const std::vector<SceneDependency>& dependencies) {
  Json files = Json::array();
  for (const SceneDependency& file : dependencies)
    files.push_back({file.path, file.sha256});
  return Json{{"version", kSceneIndexVersion},        {"source", scene.source},     {"gltf", scene.isGltf},
              {"graph_leaves", scene.graphLeafCount}, {"warnings", scene.warnings}, {"dependencies", files}}
      .dump(-1, ' ', false, Json::error_handler_t::replace);
}

Status readFacts(const Column<char>& text, IndexedScene& out) {
  const Json facts = Json::parse(text.begin(), text.end(), nullptr, false);
  try {
    if (facts.at("version").get<int>() != kSceneIndexVersion)
      return runtimeError("scene index", "is of another version");
    out.scene.source = facts.at("source").get<std::string>();
    out.scene.isGltf = facts.at("gltf").get<bool>();
    out.scene.graphLeafCount = facts.at("graph_leaves").get<std::uint32_t>();
    out.scene.warnings = facts.at("warnings").get<std::vector<std::string>>();
    for (const Json& file : facts.at("dependencies"))
      out.dependencies.push_back({file.at(0).get<std::string>(), file.at(1).get<std::string>()});
  } catch (const Json::exception&) {
    return runtimeError("scene index", "has facts that cannot be read");
  }
  return Done{};
}

/// Reads columns until one fails.
class Columns {
 public:
  explicit Columns(const SectionReader& sections) : sections_(sections) {}
  template <class T>
  Column<T> read(std::uint32_t id) {
    auto column = sections_.column<T>(id);
    if (column) return std::move(*column);
    if (status_) status_ = column.error();
    return {};
  }
  template <class T>
  void into(Column<T>& column, std::uint32_t id) {
    column = read<T>(id);
  }
  [[nodiscard]] const Status& status() const { return status_; }

 private:
  const SectionReader& sections_;
  Status status_ = Done{};
};

ObjectHierarchy readHierarchy(Columns& columns) {
  ObjectHierarchy::Arrays arrays;
  std::uint32_t id = kHierarchy;
  columns.into(arrays.subtreeEnd, id++);
  columns.into(arrays.parent, id++);
  columns.into(arrays.leafBegin, id++);
  columns.into(arrays.leafNode, id++);
  columns.into(arrays.aabbs, id++);
  columns.into(arrays.obbs, id++);
  columns.into(arrays.spheres, id++);
  return ObjectHierarchy(std::move(arrays));
}

}  // namespace

std::string encodeSceneIndex(const Scene& scene, const Column<StoredAsset>& places,
                             const std::vector<SceneDependency>& dependencies) {
  const std::string facts = factsOf(scene, dependencies);
  SectionWriter writer;
  writer.add(kFacts, std::string_view(facts));
  writer.add(kLeaves, scene.leaves);
  writer.add(kBillboards, scene.billboards);
  writer.add(kPathNodes, scene.pathNodes);
  writer.add(kNames, scene.names);
  writer.add(kAssets, scene.assets.rows());
  writer.add(kAssetNeeds, scene.assets.needs());
  writer.add(kAssetPlaces, places);
  writer.add(kMotion, scene.motion);
  std::uint32_t id = kHierarchy;
  scene.hierarchy.visitArrays([&](const auto& array) { writer.add(id++, array); });
  return writer.finish();
}

Result<IndexedScene> openSceneIndex(std::span<std::byte> bytes, std::shared_ptr<const void> keeper) {
  const auto sections = SectionReader::open(bytes, std::move(keeper));
  if (!sections) return sections.error();
  IndexedScene out;
  Columns columns(*sections);
  if (Status status = readFacts(columns.read<char>(kFacts), out); !status) return status.error();
  Scene& scene = out.scene;
  columns.into(scene.leaves, kLeaves);
  columns.into(scene.billboards, kBillboards);
  columns.into(scene.pathNodes, kPathNodes);
  columns.into(scene.names, kNames);
  scene.assets = AssetTable(columns.read<AssetRow>(kAssets), columns.read<std::uint32_t>(kAssetNeeds),
                            std::make_shared<MemoryAssets>());
  columns.into(out.places, kAssetPlaces);
  columns.into(scene.motion, kMotion);
  scene.hierarchy = readHierarchy(columns);
  if (!columns.status()) return columns.status().error();
  if (scene.leaves.size() != scene.hierarchy.leafCount() || out.places.size() != scene.assets.size() ||
      scene.leaves.empty()) {
    return runtimeError("scene index", "has arrays that do not fit each other");
  }
  if (Status status = hideAsLoaded(scene); !status) return status.error();
  return out;
}

}  // namespace tessera
