#include "common/scene/synthetic/plant.h"
#include "common/scene/synthetic/synthetic.h"

namespace tessera {
namespace synthetic {
namespace {

constexpr std::uint32_t kLeaves = 3919;
constexpr std::uint32_t kGroups = 1118;
constexpr std::uint64_t kLayoutSeed = 5037;
constexpr std::uint64_t kLeastTriangles = 110'000;
constexpr std::uint64_t kMostTriangles = 30'000'000;

}  // namespace

Paint mixPaint(Model& model) {
  const auto mix = [&](const char* name, std::uint32_t rgb, double roughness = 0.8) {
    return model.material({.name = name, .rgb = rgb, .roughness = roughness});
  };
  Paint p{};
  p.concrete = mix("Concrete", 0xb3aea3, 0.95);
  p.concreteDark = mix("Weathered concrete", 0x8f8b83, 0.95);
  p.asphalt = mix("Asphalt", 0x56585b, 0.95);
  p.gravel = mix("Gravel", 0x9c968a, 1);
  p.grass = mix("Grass", 0x6d8a4c, 1);
  p.marking = mix("Road marking", 0xe6e2d0);
  p.steel = mix("Painted steel", 0x7797a8, 0.6);
  p.steelDark = mix("Dark steel", 0x4b525a, 0.6);
  p.galvanized = mix("Galvanized steel", 0xb4babd, 0.5);
  p.railing = mix("Safety yellow", 0xe9b824, 0.6);
  p.grating = mix("Grating", 0x8a9094, 0.6);
  p.rust = mix("Weathered steel", 0x8b5e43, 0.9);
  p.claddingLight = mix("Light cladding", 0xd9dcdb, 0.6);
  p.claddingBlue = mix("Blue cladding", 0x5b86a8, 0.6);
  p.claddingDark = mix("Duct steel", 0x7c828a, 0.6);
  p.roof = mix("Roof sheet", 0xa9b2b5, 0.6);
  p.glass = mix("Glass", 0x35526a, 0.1);
  p.brick = mix("Brick", 0xa9654b, 0.95);
  p.tankWhite = mix("Tank white", 0xecebe4, 0.5);
  p.tankGrey = mix("Tank grey", 0xc3c8c6, 0.5);
  p.aluminium = mix("Aluminium jacket", 0xced2d4, 0.35);
  p.machine = mix("Machine green", 0x5f8f7d, 0.5);
  p.machineBlue = mix("Machine blue", 0x3a6ea5, 0.5);
  p.cabinet = mix("Cabinet grey", 0xd2cdbb, 0.6);
  p.porcelain = mix("Porcelain", 0x7a4a35, 0.2);
  p.copper = mix("Conductor", 0x9a8f86, 0.4);
  p.red = mix("Signal red", 0xc6342b, 0.6);
  p.white = mix("White", 0xf1efe9, 0.6);
  p.coal = mix("Coal", 0x2a2b2f, 1);
  p.rubber = mix("Rubber", 0x2e2f31, 0.9);
  p.timber = mix("Timber", 0x9b7a52, 0.9);
  p.leaves = mix("Foliage", 0x4f7a3a, 1);
  p.waterSurface = mix("Water", 0x3f7f93, 0.1);
  p.pipes = {mix("Steam pipe", 0xd3d6d8, 0.4), mix("Water pipe", 0x3f9a5f, 0.5),
             mix("Fire pipe", 0xc93a2e, 0.5),  mix("Gas pipe", 0xdfa92f, 0.5),
             mix("Air pipe", 0x86b9dc, 0.5),   mix("Oil pipe", 0x86552f, 0.5),
             mix("Acid pipe", 0x8a68b0, 0.5),  mix("Condensate pipe", 0xa7b9b0, 0.5)};
  p.vehicles = {mix("Car silver", 0xb9bec4, 0.3), mix("Car blue", 0x2f5597, 0.3),
                mix("Car red", 0xa32a2a, 0.3), mix("Car white", 0xf2f2f0, 0.3),
                mix("Car black", 0x2b2d31, 0.3)};
  p.drums = {mix("Drum blue", 0x2e62a8, 0.5), mix("Drum red", 0xb5402f, 0.5),
             mix("Drum green", 0x3f7d57, 0.5), mix("Drum ochre", 0xc8923a, 0.5)};
  return p;
}

namespace {

Result<std::string> makePlant(const PowerPlantOptions& options) {
  Model model("Power plant");
  const Paint paint = mixPaint(model);
  Plant plant{std::move(model), Random(options.seed), Random(kLayoutSeed), paint};
  const GroupId root = plant.model.root();
  addSite(plant, root);
  addCoolingTowers(plant, root);
  addBoilerHouse(plant, root);
  addTurbineHall(plant, root);
  addFlueGas(plant, root);
  addCoalYard(plant, root);
  addPipeRacks(plant, root);
  addProcessUnits(plant, root);
  addTankFarm(plant, root);
  addSwitchyard(plant, root);
  const std::uint32_t leafCount = plant.model.leafCount();
  if (leafCount + 2 > kLeaves) return runtimeError("power plant", "its parts are too many");
  addLaydownYard(plant, root, kLeaves - leafCount);
  if (!plant.model.splitGroupsTo(kGroups))
    return runtimeError("power plant", "its groups cannot be made to count");
  return plant.model.toGlb(options.triangles);
}

}  // namespace
}  // namespace synthetic

Result<std::string> makePowerPlantGlb(const PowerPlantOptions& options) {
  if (options.triangles < synthetic::kLeastTriangles || options.triangles > synthetic::kMostTriangles) {
    return inputError("power plant", "triangles must be " + std::to_string(synthetic::kLeastTriangles) +
                                         " to " + std::to_string(synthetic::kMostTriangles));
  }
  return synthetic::makePlant(options);
}

}  // namespace tessera
