#include <cmath>
#include <string>

#include "common/scene/synthetic/plant.h"

namespace tessera::synthetic {
namespace {

constexpr double kShellFromM = 6;
constexpr double kShellToM = 66;
constexpr double kWaistM = 15.5;
constexpr double kWaistHeightM = 50;
constexpr double kSlopeM = 34;

/// Outside up, over the rim, and down the inside.
Part shell() {
  constexpr double kThickM = 0.5;
  const double u = (kShellToM - kWaistHeightM) / kSlopeM;
  const double rimM = kWaistM * std::sqrt(1 + u * u);
  const double v = (kShellFromM - kWaistHeightM) / kSlopeM;
  const double footM = kWaistM * std::sqrt(1 + v * v);
  const double inner = (kWaistM - kThickM) / kWaistM;
  return turned({0, 0, 0}, {line({footM * inner, kShellFromM}, {footM, kShellFromM}),
                            hyperbola({kWaistM, kWaistHeightM}, kSlopeM, kShellFromM, kShellToM),
                            line({rimM, kShellToM}, {rimM * inner, kShellToM}),
                            hyperbola({kWaistM - kThickM, kWaistHeightM}, kSlopeM, kShellToM, kShellFromM)});
}

double shellRadius(double y) {
  const double u = (y - kWaistHeightM) / kSlopeM;
  return kWaistM * std::sqrt(1 + u * u);
}

void addTower(Plant& plant, GroupId parent, const std::string& name, const Vec3& where) {
  Model& model = plant.model;
  const GroupId tower = model.group(parent, name, at(where));
  const double footM = shellRadius(kShellFromM);
  const GroupId structure = model.group(tower, "Structure");
  model.leaf(structure, "Shell", plant.paint.concrete, {shell()});
  const double rimM = shellRadius(kShellToM);
  model.leaf(structure, "Rim", plant.paint.concreteDark,
             {turned({0, kShellToM - 1, 0},
                     polyline({{rimM - 0.6, -0.6}, {rimM + 1.2, 0}, {rimM + 1.2, 1.3}, {rimM - 0.6, 1.3}}))});
  Part left = bar(onCircle(footM + 1.5, 0, 0.5), onCircle(footM - 0.2, kPi / 24, kShellFromM + 0.3), 0.7);
  Part right = bar(onCircle(footM + 1.5, 0, 0.5), onCircle(footM - 0.2, -kPi / 24, kShellFromM + 0.3), 0.7);
  model.leaf(structure, "Legs", plant.paint.concreteDark,
             {exactly(around(left, 24)), exactly(around(right, 24))});
  model.leaf(structure, "Rim railing", plant.paint.railing, roundRailing(rimM + 1, kShellToM + 0.3));
  const GroupId basin = model.group(tower, "Basin");
  model.leaf(basin, "Wall", plant.paint.concreteDark,
             {turned({0, 0, 0},
                     polyline({{footM + 3, 0}, {footM + 3, 1.4}, {footM + 2.6, 1.4}, {footM + 2.6, 0}}))});
  model.leaf(basin, "Water", plant.paint.waterSurface,
             {turned({0, 0.9, 0}, polyline({{footM + 2.6, 0}, {0, 0}}))});
  model.leaf(basin, "Fill", plant.paint.timber,
             {turned({0, 3.4, 0}, polyline({{0, 0}, {footM - 2, 0}, {footM - 2, 2.6}, {0, 2.6}}))});
  model.leaf(basin, "Fill columns", plant.paint.concrete,
             {around(rod({footM * 0.8, 0.5, 0}, {footM * 0.8, 3.4, 0}, 0.3), 20),
              around(rod({footM * 0.45, 0.5, 0}, {footM * 0.45, 3.4, 0}, 0.3), 12)});
  const GroupId access = model.group(tower, "Access");
  // The ladder follows the shell in straight flights.
  for (std::uint32_t i = 0; i < 5; ++i) {
    const double y0 = kShellFromM + 12.0 * i;
    const double y1 = y0 + 12;
    const Vec3 low(0, y0, shellRadius(y0) + 0.25);
    const Vec3 high(0, y1, shellRadius(y1) + 0.25);
    const Vec3 up = (high - low).normalized();
    model.leaf(access, "Ladder " + std::to_string(i + 1), plant.paint.galvanized,
               cagedLadder((high - low).norm() - 1), at(low, fromAxes(Vec3::UnitX(), up)));
  }
  model.leaf(access, "Stair", plant.paint.railing, steelStairs(7, kShellFromM, 1),
             at({-7, 0, footM + 4}, turnY(0)));
}

void addPumpHouse(Plant& plant, GroupId parent) {
  Model& model = plant.model;
  const GroupId house = model.group(parent, "Circulating water pumps", at(-95, 0, -20));
  model.leaf(house, "Pit", plant.paint.concreteDark, {box({-5, 0, -12}, {5, 0.5, 12})});
  for (std::uint32_t i = 0; i < 4; ++i) {
    const double z = -9.0 + 6 * i;
    addPump(plant, house, "Pump " + std::to_string(i + 1), at(-3, 0.5, z), 1.7);
    addPipeRun(plant, house,
               {.name = "Discharge " + std::to_string(i + 1),
                .material = plant.pipe(Water),
                .radiusM = 0.45,
                .path = {{-2.4, 3, z}, {-2.4, 5.5, z}, {4, 5.5, z}, {4, 2.2, z}},
                .valvesOn = {1}});
  }
  addCabinets(plant, house, at({5.5, 0.0, -6}, turnY(kPi / 2)), 5);
}

}  // namespace

void addCoolingTowers(Plant& plant, GroupId root) {
  const GroupId area = plant.model.group(root, "Cooling water");
  addTower(plant, area, "Cooling tower 1", {-118, 0, -62});
  addTower(plant, area, "Cooling tower 2", {-118, 0, 1});
  addPumpHouse(plant, area);
  const GroupId mains = plant.model.group(area, "Circulating mains");
  for (std::uint32_t i = 0; i < 2; ++i) {
    const double z = -18.5 + 4.5 * i;
    const double r = 1.1;
    addPipeRun(plant, mains,
               {.name = i == 0 ? "Supply main" : "Return main",
                .material = plant.pipe(Water),
                .radiusM = r,
                .path = {{-90.5, 1.6, z},
                         {-90.5, 1.6 + 4.4 * i + 4.6, z},
                         {-73, 6.2 + 4.4 * i, z},
                         {-73, 1.6, z},
                         {-66, 1.6, z}},
                .spoolM = 9});
  }
}

}  // namespace tessera::synthetic
