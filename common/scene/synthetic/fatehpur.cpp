#include <string>

#include "common/scene/synthetic/palace.h"
#include "common/scene/synthetic/synthetic.h"

namespace tessera {
namespace synthetic {
namespace {

constexpr std::uint32_t kLeaves = 482;
constexpr std::uint32_t kGroups = 288;
constexpr std::uint64_t kLeastTriangles = 100'000;
constexpr std::uint64_t kMostTriangles = 30'000'000;

Stone quarry(Model& model) {
  const auto cut = [&](const char* name, std::uint32_t rgb, double roughness = 0.9) {
    return model.material({.name = name, .rgb = rgb, .roughness = roughness});
  };
  Stone s{};
  s.red = cut("Red sandstone", 0xb5624a);
  s.redDark = cut("Weathered sandstone", 0x9a5340);
  s.redLight = cut("Pale sandstone", 0xc98268);
  s.paving = cut("Sandstone paving", 0xc9a487);
  s.marble = cut("White marble", 0xeee8dc, 0.4);
  s.plaster = cut("Lime plaster", 0xd9c3a5);
  s.glazed = cut("Glazed tiles", 0x3d7f9c, 0.2);
  s.water = cut("Water", 0x4a8a78, 0.1);
  s.lawn = cut("Lawn", 0x7c9550, 1);
  s.earth = cut("Dry earth", 0xb89b78, 1);
  s.gilt = cut("Gilt", 0xd9b24a, 0.3);
  s.foliage = cut("Foliage", 0x50763f, 1);
  return s;
}

Result<std::string> makePalace(const FatehpurOptions& options) {
  Model model("Fatehpur");
  const Stone stone = quarry(model);
  Palace palace{std::move(model), Random(options.seed), stone};
  const GroupId root = palace.model.root();
  palace.model.leaf(root, "Ground", stone.earth, {box({-225, -1, -145}, {195, 0, 130})});
  addMosque(palace, root);
  addGreatGate(palace, root);
  addTomb(palace, root);
  addPanchMahal(palace, root);
  addAudienceHalls(palace, root);
  addPool(palace, root);
  addResidences(palace, root);
  addMinar(palace, root);
  addCityWall(palace, root);
  const std::uint32_t leafCount = palace.model.leafCount();
  if (leafCount + 2 > kLeaves) return runtimeError("fatehpur", "its parts are too many");
  addGarden(palace, root, kLeaves - leafCount);
  if (!palace.model.splitGroupsTo(kGroups))
    return runtimeError("fatehpur", "its groups cannot be made to count");
  return palace.model.toGlb(options.triangles);
}

}  // namespace
}  // namespace synthetic

Result<std::string> makeFatehpurGlb(const FatehpurOptions& options) {
  if (options.triangles < synthetic::kLeastTriangles || options.triangles > synthetic::kMostTriangles) {
    return inputError("fatehpur", "triangles must be " + std::to_string(synthetic::kLeastTriangles) + " to " +
                                      std::to_string(synthetic::kMostTriangles));
  }
  return synthetic::makePalace(options);
}

}  // namespace tessera
