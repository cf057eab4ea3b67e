#include <string>

#include "common/scene/synthetic/plant.h"

namespace tessera::synthetic {
namespace {

std::string named(const char* what, std::size_t number) {
  return what + (' ' + std::to_string(number));
}

/// A standing column with skirt, round platforms, ladders and an overhead line. Returns its height.
void addColumn(Plant& plant, GroupId unit, const Vec3& where, double radiusM, double heightM) {
  Model& model = plant.model;
  const GroupId column = model.group(unit, "Column", at(where));
  const double r = radiusM;
  constexpr double kSkirtM = 2.4;
  const GroupId body = model.group(column, "Vessel");
  model.leaf(body, "Foundation", plant.paint.concrete,
             {turned({0, 0, 0}, polyline({{r + 0.6, 0}, {r + 0.6, 0.5}, {0, 0.5}}))});
  model.leaf(
      body, "Skirt", plant.paint.steelDark,
      {turned({0, 0.5, 0}, polyline({{r + 0.25, 0}, {r + 0.25, 0.15}, {r, 0.15}, {r, kSkirtM - 0.5}}))});
  model.leaf(body, "Shell", plant.paint.aluminium, {vessel({0, kSkirtM, 0}, {0, heightM, 0}, r, r * 0.5)});
  Parts bands;
  for (double y = kSkirtM + 1.5; y < heightM; y += 3)
    bands.push_back(
        fromLevel(turned({0, y, 0}, polyline({{r, 0}, {r + 0.03, 0.02}, {r + 0.03, 0.1}, {r, 0.12}})),
                  bands.empty() ? 0 : 1.3));
  model.leaf(body, "Insulation bands", plant.paint.galvanized, std::move(bands));
  const GroupId nozzles = model.group(column, "Nozzles");
  for (std::uint32_t i = 0; i < 3; ++i) {
    const double y = kSkirtM + (heightM - kSkirtM) * (0.2 + 0.3 * i);
    const Vec3 out = onCircle(1, 0.6 + 1.7 * i);
    model.leaf(nozzles, named("Nozzle", i + 1), plant.paint.aluminium,
               {tube(out * (r - 0.1), out * (r + 0.35), 0.18), collar(out * (r + 0.3), 0, 0.3, 0.08, out)},
               at(0, y, 0));
  }
  model.leaf(nozzles, "Manway", plant.paint.aluminium,
             {rod({0, 0, r - 0.1}, {0, 0, r + 0.25}, 0.35), rod({0, 0, r + 0.25}, {0, 0, r + 0.35}, 0.45)},
             at(0, kSkirtM + 1, 0));
  double previous = 0;
  std::uint32_t number = 0;
  for (double y = 6; y < heightM; y += 6.5) {
    const GroupId level = model.group(column, named("Level", ++number), at(0, y, 0));
    model.leaf(level, "Deck", plant.paint.grating,
               {turned({0, 0, 0}, polyline({{r, -0.1}, {r + 1.3, -0.1}, {r + 1.3, 0}, {r, 0}})),
                around(bar({r, -0.9, 0}, {r + 1.2, -0.15, 0}, 0.1), 6)});
    model.leaf(level, "Railing", plant.paint.railing, roundRailing(r + 1.25, 0));
    const Vec3 foot = onCircle(r + 1.15, number % 2 == 0 ? 1.0 : 2.3);
    model.leaf(level, "Ladder", plant.paint.galvanized, cagedLadder(y - previous),
               at(foot - Vec3(0, y - previous, 0), turnY(number % 2 == 0 ? 1.0 + kPi / 2 : 2.3 + kPi / 2)));
    previous = y;
  }
  addPipeRun(plant, column,
             {.name = "Overhead line",
              .material = plant.pipe(Steam),
              .radiusM = 0.24,
              .path = {{0, heightM + r * 0.5, 0},
                       {0, heightM + r * 0.5 + 1.4, 0},
                       {r + 2.0, heightM + r * 0.5 + 1.4, 0},
                       {r + 2.0, 1, 0},
                       {r + 4.0, 1, 0}},
              .spoolM = 14,
              .endFlanges = false,
              .valvesOn = {2}});
}

void addDrum(Plant& plant, GroupId unit, const std::string& name, const Vec3& where, double radiusM,
             double lengthM) {
  Model& model = plant.model;
  const GroupId drum = model.group(unit, name, at(where));
  const double r = radiusM;
  const double axisY = r + 1.3;
  model.leaf(drum, "Shell", plant.random.chance(0.5) ? plant.paint.tankWhite : plant.paint.aluminium,
             {vessel({r, axisY, 0}, {lengthM - r, axisY, 0}, r, r * 0.5)});
  model.leaf(drum, "Saddles", plant.paint.steelDark,
             {repeated(prism({{-r * 0.85, 0.6},
                              {r * 0.85, 0.6},
                              {r * 0.9, axisY - r * 0.4},
                              {0, axisY - r * 0.99},
                              {-r * 0.9, axisY - r * 0.4}},
                             0.3, at({lengthM * 0.25, 0, 0}, turnY(kPi / 2))),
                       2, {lengthM * 0.5, 0, 0})});
  model.leaf(drum, "Plinths", plant.paint.concrete,
             {repeated(blockOn({lengthM * 0.25 + 0.15, 0, 0}, {0.8, 0.6, r * 2}), 2, {lengthM * 0.5, 0, 0})});
  model.leaf(drum, "Nozzles", plant.paint.galvanized,
             {repeated(rod({lengthM * 0.3, axisY + r * 0.9, 0}, {lengthM * 0.3, axisY + r + 0.4, 0}, 0.16), 3,
                       {lengthM * 0.2, 0, 0}),
              repeated(rod({lengthM * 0.3, axisY + r + 0.32, 0}, {lengthM * 0.3, axisY + r + 0.42, 0}, 0.26),
                       3, {lengthM * 0.2, 0, 0})});
  addPipeRun(plant, drum,
             {.name = "Outlet",
              .material = plant.pipe(Condensate),
              .radiusM = 0.14,
              .path = {{lengthM * 0.5, axisY + r + 0.4, 0},
                       {lengthM * 0.5, axisY + r + 1.4, 0},
                       {lengthM * 0.5, axisY + r + 1.4, r + 1.2},
                       {lengthM * 0.5, 0.8, r + 1.2},
                       {lengthM * 0.5 + 3, 0.8, r + 1.2}},
              .endFlanges = false,
              .valvesOn = {3}});
}

void addExchangers(Plant& plant, GroupId unit, const Vec3& where) {
  Model& model = plant.model;
  const GroupId group = model.group(unit, "Heat exchangers", at(where));
  for (std::uint32_t i = 0; i < 2; ++i) {
    const GroupId one = model.group(group, named("Exchanger", i + 1), at(0, 1.5 + 1.9 * i, 0));
    model.leaf(one, "Shell", plant.paint.aluminium, {tube({0.9, 0, 0}, {5.2, 0, 0}, 0.6)});
    model.leaf(one, "Channel", plant.paint.machineBlue,
               {turned({0, 0, 0},
                       polyline({{0, 0},
                                 {0.78, 0},
                                 {0.78, 0.12},
                                 {0.62, 0.12},
                                 {0.62, 0.75},
                                 {0.78, 0.75},
                                 {0.78, 0.95},
                                 {0.6, 0.95}}),
                       Vec3::UnitX())});
    model.leaf(one, "Cover", plant.paint.machineBlue,
               {turned({5.15, 0, 0},
                       {line({0.6, 0}, {0.78, 0}), line({0.78, 0}, {0.78, 0.14}),
                        line({0.78, 0.14}, {0.6, 0.14}), arc({0, 0.14}, {0.6, 0.4}, 0, kPi / 2)},
                       Vec3::UnitX())});
    model.leaf(one, "Nozzles", plant.paint.aluminium,
               {repeated(rod({1.5, 0.55, 0}, {1.5, 0.9, 0}, 0.17), 2, {3, 0, 0}),
                repeated(rod({0.4, -0.95, 0}, {0.4, 0.95, 0}, 0.15), 1, {0, 0, 0})});
  }
  model.leaf(group, "Supports", plant.paint.steelDark,
             {repeated(box({1.2, 0.3, -0.5}, {1.5, 2.9, 0.5}), 2, {3, 0, 0})});
  model.leaf(group, "Plinth", plant.paint.concrete, {box({0.6, 0, -0.8}, {5, 0.3, 0.8})});
  addPipeRun(plant, group,
             {.name = "Inlet",
              .material = plant.pipe(Water),
              .radiusM = 0.15,
              .path = {{0.4, 4.35, 0}, {0.4, 5.4, 0}, {0.4, 5.4, -2.2}, {0.4, 0.9, -2.2}, {3.4, 0.9, -2.2}},
              .endFlanges = false,
              .valvesOn = {2}});
}

/// A two-storey steel structure with stairs and small vessels on its upper deck.
void addStructure(Plant& plant, GroupId unit, const Vec3& where) {
  Model& model = plant.model;
  const GroupId structure = model.group(unit, "Structure", at(where));
  constexpr double kX = 9;
  constexpr double kZ = 6;
  const GroupId frame = model.group(structure, "Frame");
  for (std::uint32_t i = 0; i < 2; ++i) {
    model.leaf(frame, i == 0 ? "North columns" : "South columns", plant.paint.steel,
               {repeated(beam({0, 0, 0}, {0, 7.2, 0}, 0.35, 0.35), 3, {kX / 2, 0, 0}),
                repeated(blockOn({0, 0, 0}, {0.7, 0.3, 0.7}), 3, {kX / 2, 0, 0})},
               at(0, 0, kZ * i));
  }
  for (std::uint32_t storey = 1; storey <= 2; ++storey) {
    const double y = 3.6 * storey;
    const GroupId level = model.group(structure, named("Level", storey), at(0, y, 0));
    model.leaf(
        level, "Beams", plant.paint.steel,
        {beam({0, -0.45, 0}, {kX, -0.45, 0}, 0.35, 0.2), beam({0, -0.45, kZ}, {kX, -0.45, kZ}, 0.35, 0.2),
         repeated(beam({0, -0.45, 0}, {0, -0.45, kZ}, 0.3, 0.2), 3, {kX / 2, 0, 0})});
    addPlatform(plant, level, "Deck", at(0, 0, 0), {.sizeM = {kX, kZ}, .east = storey == 2});
  }
  model.leaf(structure, "Stairs", plant.paint.galvanized, steelStairs(4.5, 3.6, 0.9),
             at({kX + 4.5, 0, 1}, turnY(kPi)));
  const GroupId vessels = model.group(structure, "Dosing vessels", at(0, 7.2, 0));
  for (std::uint32_t i = 0; i < 3; ++i) {
    model.leaf(vessels, named("Vessel", i + 1),
               plant.random.chance(0.5) ? plant.paint.tankWhite : plant.paint.machine,
               {turned({0, 0.5, 0}, {line({0, 0}, {0.5, 0.3}), line({0.5, 0.3}, {1, 0.6}),
                                     line({1, 0.6}, {1, 2.4}), arc({0, 2.4}, {1, 0.4}, 0, kPi / 2)}),
                around(box({0.8, 0, -0.06}, {0.92, 1.2, 0.06}), 4)},
               at(1.6 + 2.9 * i, 0, 3));
  }
  addPipeRun(plant, structure,
             {.name = "Feed header",
              .material = plant.pipe(Acid),
              .radiusM = 0.09,
              .path = {{1.6, 10.0, 3}, {1.6, 10.8, 3}, {7.6, 10.8, 3}, {7.6, 10.8, -1}, {7.6, 0.6, -1}},
              .spoolM = 12,
              .endFlanges = false,
              .valvesOn = {1}});
  addPipeRun(plant, structure,
             {.name = "Drain",
              .material = plant.pipe(Oil),
              .radiusM = 0.08,
              .path = {{2, 6.6, 7}, {2, 0.8, 7}, {7, 0.8, 7}},
              .endFlanges = false,
              .valvesOn = {0}});
}

void addUnit(Plant& plant, GroupId area, std::uint32_t number, const Placement& placement) {
  Model& model = plant.model;
  const GroupId unit = model.group(area, named("Unit", number), placement);
  const GroupId ground = model.group(unit, "Ground");
  model.leaf(ground, "Slab", plant.paint.concrete, {box({-9, 0, -10}, {9.5, 0.12, 10})});
  model.leaf(ground, "Kerb", plant.paint.marking,
             {box({-9, 0.12, -10}, {9.5, 0.25, -9.8}), box({-9, 0.12, 9.8}, {9.5, 0.25, 10}),
              box({-9, 0.12, -9.8}, {-8.8, 0.25, 9.8})});
  const double heightM = plant.layout.between(14, 26);
  addColumn(plant, unit, {-5.5, 0.12, -5}, plant.random.between(0.9, 1.5), heightM);
  const double drumRadiusM = plant.random.between(0.8, 1.2);
  addDrum(plant, unit, "Drum", {-1.2, 0.12, -7}, drumRadiusM, plant.random.between(5.5, 7.5));
  addExchangers(plant, unit, {-8.4, 0.12, 1.5});
  addStructure(plant, unit, {-1, 0.12, 1.4});
  addPump(plant, unit, "Pump A", at(-7.8, 0.12, 6), 0.8);
  addPump(plant, unit, "Pump B", at(-7.8, 0.12, 8.4), 0.8);
  addCabinets(plant, unit, at(5.5, 0.12, -9), 2);
  addPipeRun(
      plant, unit,
      {.name = "Suction line",
       .material = plant.pipe(Water),
       .radiusM = 0.13,
       .path = {{-8.2, 0.72, 6}, {-8.7, 0.72, 6}, {-8.7, 3.2, 6}, {-8.7, 3.2, -2.6}, {-6.4, 3.2, -2.6}},
       .endFlanges = false});
  addPipeRun(plant, unit,
             {.name = "Fire main",
              .material = plant.pipe(Fire),
              .radiusM = 0.1,
              .path = {{9, 0.4, -9.2}, {9, 0.4, 9.2}},
              .spoolM = 20,
              .valvesOn = {0}});
}

}  // namespace

void addProcessUnits(Plant& plant, GroupId root) {
  const GroupId area = plant.model.group(root, "Water treatment and chemicals");
  for (std::uint32_t i = 0; i < 8; ++i) {
    const bool north = i < 4;
    const double x = -31.0 + 20 * (i % 4) + (i % 4 >= 2 ? 2.0 : 0.0);
    // Both rows turn their structures' backs to the rack between them.
    addUnit(plant, area, i + 1, at({x, 0, north ? 51.0 : 86.0}, turnY(north ? 0 : kPi)));
  }
}

}  // namespace tessera::synthetic
