#include <algorithm>
#include <string>

#include "common/scene/synthetic/plant.h"

namespace tessera::synthetic {
namespace {

constexpr double kBayM = 8;
constexpr double kTierHeightsM[] = {5.2, 7.6, 10};

std::string named(const char* what, std::size_t number) {
  return what + (' ' + std::to_string(number));
}

/// A pipe rack along +x of its own frame; z from 0 to widthM.
struct Rack {
  std::string name;
  Placement placement;
  std::uint32_t bays = 4;
  std::uint32_t tiers = 2;
  double widthM = 6;
  std::uint32_t pipesPerTier = 5;
  bool tray = true;
};

void addBents(Plant& plant, GroupId rack, const Rack& spec) {
  Model& model = plant.model;
  const double topM = kTierHeightsM[spec.tiers - 1] + 0.2;
  const double w = spec.widthM;
  const GroupId bents = model.group(rack, "Bents");
  for (std::uint32_t i = 0; i <= spec.bays; ++i) {
    const GroupId bent = model.group(bents, named("Bent", i + 1), at(kBayM * i, 0, 0));
    Parts columns;
    for (const double z : {0.0, w}) {
      columns.push_back(beam({0, 0, z}, {0, topM + 1.6, z}, 0.4, 0.35));
      columns.push_back(blockOn({0, 0, z}, {0.8, 0.4, 0.8}));
    }
    model.leaf(bent, "Columns", plant.paint.steel, std::move(columns));
    Parts tiers;
    for (std::uint32_t t = 0; t < spec.tiers; ++t) {
      const double y = kTierHeightsM[t] - 0.2;
      tiers.push_back(beam({0, y, 0}, {0, y, w}, 0.4, 0.25));
    }
    model.leaf(bent, "Tier beams", plant.paint.steel, std::move(tiers));
    if (i == spec.bays) continue;
    Parts struts;
    for (const double z : {0.0, w}) {
      struts.push_back(beam({0, topM - 1.4, z}, {kBayM, topM - 1.4, z}, 0.3, 0.2));
      struts.push_back(beam({0, kTierHeightsM[0] - 1.2, z}, {kBayM, kTierHeightsM[0] - 1.2, z}, 0.3, 0.2));
      if (i % 4 == 2) {
        struts.push_back(bar({0, 0.5, z}, {kBayM, kTierHeightsM[0] - 1.3, z}, 0.14));
        struts.push_back(bar({kBayM, 0.5, z}, {0, kTierHeightsM[0] - 1.3, z}, 0.14));
      }
    }
    model.leaf(bent, "Struts", plant.paint.steel, std::move(struts));
  }
}

/// The path of one rack pipe; its ends turn down, or aside over the rack's edge.
std::vector<Vec3> rackPath(Plant& plant, const Rack& spec, double y, double z, double radiusM) {
  const double lengthM = kBayM * spec.bays;
  const double bendM = 3 * radiusM;
  const double from = plant.layout.between(0.05, 0.2) * lengthM;
  const double to = lengthM - plant.layout.between(0.05, 0.2) * lengthM;
  const double aside = z < spec.widthM / 2 ? -1.2 - bendM : spec.widthM + 1.2 + bendM;
  std::vector<Vec3> path;
  if (plant.layout.chance(0.55)) {
    path.insert(path.end(), {Vec3(from, 0.5, aside), Vec3(from, y + 2.2 * bendM, aside),
                             Vec3(from, y + 2.2 * bendM, z), Vec3(from, y, z)});
  } else {
    path.emplace_back(-0.5, y, z);
  }
  if (plant.layout.chance(0.35) && lengthM > 80) {
    // Expansion loop: sideways would meet the neighbours, so it rises.
    const double x = lengthM * plant.layout.between(0.35, 0.65);
    const double loopM = std::max(1.8, 2.4 * bendM);
    path.insert(path.end(), {Vec3(x, y, z), Vec3(x, y + loopM, z), Vec3(x + 1.4 * loopM, y + loopM, z),
                             Vec3(x + 1.4 * loopM, y, z)});
  }
  if (plant.layout.chance(0.55)) {
    path.insert(path.end(), {Vec3(to, y, z), Vec3(to, y + 2.2 * bendM, z), Vec3(to, y + 2.2 * bendM, aside),
                             Vec3(to, 0.5, aside)});
  } else {
    path.emplace_back(lengthM + 0.5, y, z);
  }
  return path;
}

void addRackPipes(Plant& plant, GroupId rack, const Rack& spec) {
  constexpr Medium kMedia[] = {Steam, Water, Condensate, Gas, Air, Water, Oil, Acid, Fire};
  constexpr double kRadii[] = {0.32, 0.22, 0.16, 0.11, 0.085, 0.06};
  for (std::uint32_t t = 0; t < spec.tiers; ++t) {
    const GroupId tier = plant.model.group(rack, named("Tier", t + 1));
    double z = 0.35;
    for (std::uint32_t i = 0; i < spec.pipesPerTier; ++i) {
      const double radiusM = kRadii[(i * 5 + t * 3 + plant.random.index(2)) % 6];
      z += radiusM;
      const double y = kTierHeightsM[t] + radiusM + 0.02;
      const double spread = (spec.widthM - 0.7) / spec.pipesPerTier;
      const double centerZ = 0.35 + spread * (i + 0.5);
      addPipeRun(plant, tier,
                 {.name = named("Line", 100 * (t + 1) + i + 1),
                  .material = plant.pipe(kMedia[(i + 4 * t) % 9]),
                  .radiusM = std::min(radiusM, spread * 0.38),
                  .path = rackPath(plant, spec, y, centerZ, radiusM),
                  .spoolM = 64,
                  .endFlanges = true,
                  .valvesOn = plant.layout.chance(0.4) ? std::vector<std::uint32_t>{0}
                                                       : std::vector<std::uint32_t>{}});
      z += radiusM;
    }
  }
}

void addTrays(Plant& plant, GroupId rack, const Rack& spec) {
  const double y = kTierHeightsM[spec.tiers - 1] + 1.7;
  const GroupId trays = plant.model.group(rack, "Cable trays", at(0, y, 0));
  const std::uint32_t pieces = (spec.bays + 3) / 4;
  const double pieceM = kBayM * spec.bays / pieces;
  plant.model.leaf(
      trays, "Brackets", plant.paint.steel,
      {repeated(box({-0.1, -0.15, -0.1}, {0.1, 0, spec.widthM + 0.1}), spec.bays + 1, {kBayM, 0, 0})});
  for (std::uint32_t i = 0; i < pieces; ++i) {
    const GroupId piece = plant.model.group(trays, named("Tray", i + 1), at(pieceM * i, 0, 0));
    plant.model.leaf(piece, "Tray", plant.paint.galvanized,
                     {box({0, 0, 0.8}, {pieceM, 0.15, 0.84}), box({0, 0, 1.76}, {pieceM, 0.15, 1.8}),
                      repeated(box({0.2, 0, 0.84}, {0.3, 0.04, 1.76}),
                               static_cast<std::uint32_t>(pieceM / 1.0), {1.0, 0, 0})});
    plant.model.leaf(piece, "Cables", plant.paint.rubber,
                     {repeated(tube({0, 0.08, 0.95}, {pieceM, 0.08, 0.95}, 0.035), 8, {0, 0, 0.1})});
  }
}

void addRack(Plant& plant, GroupId area, const Rack& spec) {
  const GroupId rack = plant.model.group(area, spec.name, spec.placement);
  addBents(plant, rack, spec);
  addRackPipes(plant, rack, spec);
  if (spec.tray) addTrays(plant, rack, spec);
}

}  // namespace

void addPipeRacks(Plant& plant, GroupId root) {
  const GroupId area = plant.model.group(root, "Pipe racks");
  addRack(plant, area,
          {.name = "Main rack",
           .placement = at(-78, 0, 17.5),
           .bays = 28,
           .tiers = 3,
           .widthM = 8,
           .pipesPerTier = 6});
  addRack(plant, area,
          {.name = "Boiler rack",
           .placement = at({22, 0, 16}, turnY(kPi / 2)),
           .bays = 6,
           .tiers = 3,
           .widthM = 6,
           .pipesPerTier = 3});
  addRack(plant, area,
          {.name = "Process rack",
           .placement = at(-41, 0, 66),
           .bays = 10,
           .tiers = 2,
           .widthM = 6,
           .pipesPerTier = 4});
  addRack(plant, area,
          {.name = "Connecting rack",
           .placement = at({-3, 0, 66}, turnY(kPi / 2)),
           .bays = 5,
           .tiers = 2,
           .widthM = 6,
           .pipesPerTier = 4});
  addRack(plant, area,
          {.name = "Tank farm rack",
           .placement = at({52, 0, 92}, turnY(kPi / 2)),
           .bays = 8,
           .tiers = 2,
           .widthM = 4,
           .pipesPerTier = 3});
}

}  // namespace tessera::synthetic
