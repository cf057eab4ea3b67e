#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/synthetic/model.h"
#include "common/scene/synthetic/parts.h"
#include "common/scene/synthetic/random.h"

// The power plant while it is being built. Its areas are one function each, in plant_*.cpp; the plan is
// in power_plant.cpp. Metres; x runs east, z south, ground at y = 0.
namespace tessera::synthetic {

/// Material ids.
struct Paint {
  std::uint32_t concrete, concreteDark, asphalt, gravel, grass, marking;
  std::uint32_t steel, steelDark, galvanized, railing, grating, rust;
  std::uint32_t claddingLight, claddingBlue, claddingDark, roof, glass, brick;
  std::uint32_t tankWhite, tankGrey, aluminium, machine, machineBlue, cabinet, porcelain, copper;
  std::uint32_t red, white, coal, rubber, timber, leaves, waterSurface;
  std::vector<std::uint32_t> pipes;  ///< by medium: steam, water, fire, gas, air, oil, acid, condensate
  std::vector<std::uint32_t> vehicles, drums;
};

enum Medium : std::uint8_t { Steam, Water, Fire, Gas, Air, Oil, Acid, Condensate };

struct Plant {
  Model model;
  Random random;  ///< follows the seed: sizes, colours
  Random layout;  ///< the same for every seed: whatever decides how many leaves there are
  Paint paint;

  [[nodiscard]] std::uint32_t pipe(Medium medium) const { return paint.pipes[medium]; }
};

[[nodiscard]] Paint mixPaint(Model& model);

/// A pipe along a path with right or 45 degree bends, as a group of straights, elbows and flanges.
struct PipeRun {
  std::string name;
  std::uint32_t material = 0;
  double radiusM = 0.1;
  std::vector<Vec3> path;
  double spoolM = 24;  ///< longest straight without a flanged joint
  bool endFlanges = true;
  std::vector<std::uint32_t> valvesOn = {};  ///< straights (by number) that carry a valve
};
void addPipeRun(Plant& plant, GroupId parent, const PipeRun& run);

/// Where a valve sits on its pipe: the axis runs along `along`, the stem along `stem`; both unit.
struct ValveSite {
  Vec3 center = Vec3::Zero();
  Vec3 along = Vec3::UnitX();
  Vec3 stem = Vec3::UnitY();
  double radiusM = 0.1;
};
void addValve(Plant& plant, GroupId parent, const ValveSite& site);

/// Pump with motor on a plinth, shaft along +x, about 2.6 * `sizeM` long.
void addPump(Plant& plant, GroupId parent, const std::string& name, const Placement& placement, double sizeM);
/// A row of electrical cabinets along +x.
void addCabinets(Plant& plant, GroupId parent, const Placement& placement, std::uint32_t cabinetCount);
/// Platform of grating on the xz rectangle from the origin to `sizeM`, with rails on the given sides.
struct Platform {
  Vec2 sizeM = {4, 3};
  bool north = true, south = true, east = true, west = true;
};
void addPlatform(Plant& plant, GroupId parent, const std::string& name, const Placement& placement,
                 const Platform& platform);

void addSite(Plant& plant, GroupId root);
void addCoolingTowers(Plant& plant, GroupId root);
void addBoilerHouse(Plant& plant, GroupId root);
void addTurbineHall(Plant& plant, GroupId root);
void addFlueGas(Plant& plant, GroupId root);
void addCoalYard(Plant& plant, GroupId root);
void addPipeRacks(Plant& plant, GroupId root);
void addProcessUnits(Plant& plant, GroupId root);
void addTankFarm(Plant& plant, GroupId root);
void addSwitchyard(Plant& plant, GroupId root);
/// Storage yard of exactly `leafCount` leaves, 2 or more.
void addLaydownYard(Plant& plant, GroupId root, std::uint32_t leafCount);

}  // namespace tessera::synthetic
