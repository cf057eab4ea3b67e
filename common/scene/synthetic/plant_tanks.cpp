#include <string>

#include "common/scene/synthetic/plant.h"

namespace tessera::synthetic {
namespace {

struct Tank {
  std::string name;
  Vec3 where = Vec3::Zero();
  double radiusM = 8;
  double heightM = 12;
  bool dome = false;
  std::uint32_t paint = 0;
};

std::string named(const char* what, std::size_t number) {
  return what + (' ' + std::to_string(number));
}

void addShell(Plant& plant, GroupId tank, const Tank& spec) {
  Model& model = plant.model;
  const double r = spec.radiusM;
  const double h = spec.heightM;
  const GroupId shell = model.group(tank, "Shell");
  model.leaf(shell, "Foundation", plant.paint.concrete,
             {turned({0, 0, 0}, polyline({{r + 0.8, 0}, {r + 0.5, 0.35}, {r - 0.2, 0.35}}))});
  constexpr std::uint32_t kCourses = 3;
  for (std::uint32_t i = 0; i < kCourses; ++i) {
    const double courseM = (h - 0.35) / kCourses;
    model.leaf(shell, named("Course", i + 1), spec.paint, {turned({0, 0, 0}, {line({r, 0}, {r, courseM})})},
               at(0, 0.35 + courseM * i, 0));
  }
  model.leaf(
      shell, "Wind girders", spec.paint,
      {fromLevel(
           turned({0, h * 0.62, 0}, polyline({{r - 0.1, 0}, {r + 0.22, 0}, {r + 0.22, 0.1}, {r - 0.1, 0.1}})),
           0.8),
       turned({0, h - 0.15, 0}, polyline({{r - 0.1, 0}, {r + 0.15, 0}, {r + 0.15, 0.15}, {r - 0.1, 0.15}}))});
  std::vector<Curve> roof = spec.dome ? std::vector<Curve>{arc({0, 0}, {r, r * 0.32}, 0, kPi / 2)}
                                      : std::vector<Curve>{line({r, 0}, {0, r * 0.2})};
  model.leaf(shell, "Roof", spec.paint, {turned({0, h, 0}, std::move(roof))});
}

/// Stairs that wind up the shell from the foot to the rim.
Parts spiralStairs(double radiusM, double heightM) {
  const auto steps = static_cast<std::uint32_t>(heightM / 0.22);
  const double turnRad = 0.3 / (radiusM + 0.5);
  Part step = box({radiusM + 0.05, 0.2, -0.16}, {radiusM + 0.95, 0.24, 0.16});
  step.repeat = {.count = steps, .stepM = {0, 0.22, 0}, .turnRad = turnRad};
  Part post = tube({radiusM + 0.92, 0.22, 0}, {radiusM + 0.92, 1.3, 0}, 0.022);
  post.repeat = {.count = steps / 4, .stepM = {0, 0.88, 0}, .turnRad = 4 * turnRad};
  Vec3 next = onCircle(radiusM + 0.92, turnRad * 4, 1.3 + 0.88);
  Part rail = tube({radiusM + 0.92, 1.3, 0}, next, 0.03);
  rail.repeat = {.count = steps / 4 - 1, .stepM = {0, 0.88, 0}, .turnRad = 4 * turnRad, .exact = true};
  return {step, post, rail};
}

void addTank(Plant& plant, GroupId area, const Tank& spec) {
  Model& model = plant.model;
  const double r = spec.radiusM;
  const double h = spec.heightM;
  const GroupId tank = model.group(area, spec.name, at(spec.where));
  addShell(plant, tank, spec);
  const GroupId access = model.group(tank, "Access");
  model.leaf(access, "Stairs", plant.paint.galvanized, spiralStairs(r, h));
  model.leaf(access, "Roof railing", plant.paint.railing, roundRailing(r - 0.25, h));
  model.leaf(
      access, "Centre vent", plant.paint.aluminium,
      {turned({0, h + r * (spec.dome ? 0.3 : 0.18), 0}, polyline({{0.3, 0}, {0.3, 1}, {0.6, 1}, {0, 1.5}}))});
  const GroupId nozzles = model.group(tank, "Nozzles");
  const Vec3 south(0, 0, 1);
  model.leaf(nozzles, "Manway", plant.paint.steelDark,
             {rod(south * (r - 0.2) + Vec3(2, 1.3, 0), south * (r + 0.25) + Vec3(2, 1.3, 0), 0.4),
              rod(south * (r + 0.2) + Vec3(2, 1.3, 0), south * (r + 0.32) + Vec3(2, 1.3, 0), 0.52)});
  model.leaf(nozzles, "Level gauge", plant.paint.red, {box({-0.15, 0.8, r}, {0.15, h - 0.4, r + 0.08})});
  for (std::uint32_t i = 0; i < 2; ++i) {
    const double x = -2.5 - 1.6 * i;
    addPipeRun(plant, tank,
               {.name = i == 0 ? "Filling line" : "Suction line",
                .material = plant.pipe(i == 0 ? Oil : Water),
                .radiusM = 0.2,
                .path = {{x, 1.0, r - 0.9}, {x, 1.0, r + 3 + 0.7 * i}, {x, 0.55, r + 3.0 + 0.7 * i}},
                .endFlanges = i == 0,
                .valvesOn = {0}});
  }
}

void addBund(Plant& plant, GroupId area, const std::string& name, const Vec3& min, const Vec3& max) {
  const GroupId bund = plant.model.group(area, name, at(min));
  const Vec3 size = max - min;
  plant.model.leaf(bund, "Floor", plant.paint.concrete, {box({0, 0, 0}, {size.x(), 0.06, size.z()})});
  plant.model.leaf(bund, "North wall", plant.paint.concreteDark, {box({0, 0.06, 0}, {size.x(), 1.1, 0.3})});
  plant.model.leaf(bund, "South wall", plant.paint.concreteDark,
                   {box({0, 0.06, size.z() - 0.3}, {size.x(), 1.1, size.z()})});
  plant.model.leaf(bund, "West wall", plant.paint.concreteDark,
                   {box({0, 0.06, 0.3}, {0.3, 1.1, size.z() - 0.3})});
  plant.model.leaf(bund, "East wall", plant.paint.concreteDark,
                   {box({size.x() - 0.3, 0.06, 0.3}, {size.x(), 1.1, size.z() - 0.3})});
  plant.model.leaf(bund, "Stile", plant.paint.galvanized, steelStairs(1.8, 1.1, 0.9),
                   at({1.5, 0, size.z() + 1.8}, turnY(kPi / 2)));
}

}  // namespace

void addTankFarm(Plant& plant, GroupId root) {
  const GroupId area = plant.model.group(root, "Tank farm");
  addBund(plant, area, "North bund", {60, 0, 41}, {147, 0, 67});
  addBund(plant, area, "South bund", {60, 0, 72}, {147, 0, 96});
  const Paint& p = plant.paint;
  const Tank tanks[] = {
      {.name = "Demineralized water tank",
       .where = {72, 0, 53},
       .radiusM = 9,
       .heightM = 13,
       .dome = true,
       .paint = p.tankWhite},
      {.name = "Raw water tank",
       .where = {95, 0, 53},
       .radiusM = 10,
       .heightM = 11,
       .dome = false,
       .paint = p.tankWhite},
      {.name = "Fire water tank",
       .where = {117, 0, 53},
       .radiusM = 8.5,
       .heightM = 14,
       .dome = false,
       .paint = p.red},
      {.name = "Condensate tank",
       .where = {136, 0, 53},
       .radiusM = 7.5,
       .heightM = 12,
       .dome = true,
       .paint = p.tankGrey},
      {.name = "Fuel oil tank 1",
       .where = {71, 0, 83},
       .radiusM = 8,
       .heightM = 12,
       .dome = false,
       .paint = p.tankGrey},
      {.name = "Fuel oil tank 2",
       .where = {91, 0, 83},
       .radiusM = 8,
       .heightM = 12,
       .dome = false,
       .paint = p.tankGrey},
      {.name = "Diesel tank",
       .where = {108, 0, 83},
       .radiusM = 5.5,
       .heightM = 10,
       .dome = true,
       .paint = p.tankWhite},
      {.name = "Acid tank",
       .where = {122, 0, 83},
       .radiusM = 4,
       .heightM = 8,
       .dome = true,
       .paint = p.tankWhite},
      {.name = "Caustic tank",
       .where = {133, 0, 83},
       .radiusM = 4,
       .heightM = 8,
       .dome = true,
       .paint = p.tankWhite},
      {.name = "Brine tank",
       .where = {142.5, 0, 83},
       .radiusM = 3,
       .heightM = 6.5,
       .dome = false,
       .paint = p.machine},
  };
  for (const Tank& tank : tanks)
    addTank(plant, area, tank);
  const GroupId pumps = plant.model.group(area, "Pump row");
  for (std::uint32_t i = 0; i < 6; ++i) {
    const double x = 64.0 + 13.5 * i;
    const GroupId pair = plant.model.group(pumps, named("Pump set", i + 1), at(x, 0, 69.5));
    addPump(plant, pair, "Pump", at(0, 0, 0), 0.8);
    addPipeRun(plant, pair,
               {.name = "Discharge",
                .material = plant.pipe(i % 2 == 0 ? Water : Oil),
                .radiusM = 0.14,
                .path = {{0.28, 1.2, 0}, {0.28, 2.6, 0}, {5.0, 2.6, 0}, {5.0, 0.6, 0}},
                .valvesOn = {1}});
  }
}

}  // namespace tessera::synthetic
