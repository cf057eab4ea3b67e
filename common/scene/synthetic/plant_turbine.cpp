#include <string>

#include "common/scene/synthetic/plant.h"

namespace tessera::synthetic {
namespace {

// The hall's frame: x from 0 to kLengthM, z from 0 (north) to kDepthM.
constexpr double kBayM = 9.2;
constexpr std::uint32_t kBays = 10;
constexpr double kLengthM = kBayM * kBays;
constexpr double kDepthM = 34;
constexpr double kEavesM = 20;
constexpr double kRidgeM = 24;
constexpr double kFloorM = 8;  ///< the machines' floor

std::string named(const char* what, std::size_t number) {
  return what + (' ' + std::to_string(number));
}

void addFrames(Plant& plant, GroupId hall) {
  const GroupId frames = plant.model.group(hall, "Frames");
  for (std::uint32_t i = 0; i <= kBays; ++i) {
    const GroupId frame = plant.model.group(frames, named("Frame", i + 1), at(kBayM * i, 0, 0));
    const auto column = [&](const char* name, double z) {
      plant.model.leaf(frame, name, plant.paint.steel,
                       {beam({0, 0, 0}, {0, kEavesM, 0}, 0.9, 0.5), blockOn({0, 0, 0}, {1.2, 0.5, 1.2})},
                       at(0, 0, z));
    };
    column("North column", 0.6);
    column("South column", kDepthM - 0.6);
    Parts truss = {bar({0, kEavesM, 0.6}, {0, kRidgeM, kDepthM / 2}, 0.35),
                   bar({0, kEavesM, kDepthM - 0.6}, {0, kRidgeM, kDepthM / 2}, 0.35),
                   bar({0, kEavesM, 0.6}, {0, kEavesM, kDepthM - 0.6}, 0.3)};
    constexpr std::uint32_t kPanels = 8;
    for (std::uint32_t k = 1; k < kPanels; ++k) {
      const double z = kDepthM * k / kPanels;
      const double y = kEavesM + (kRidgeM - kEavesM) * (1 - std::abs(2.0 * k / kPanels - 1));
      truss.push_back(bar({0, kEavesM, z}, {0, y, z}, 0.18));
      const double next = kDepthM * (k < kPanels / 2 ? k - 1 : k + 1) / kPanels;
      truss.push_back(bar({0, y, z}, {0, kEavesM, next}, 0.18));
    }
    plant.model.leaf(frame, "Truss", plant.paint.steel, std::move(truss));
  }
}

void addWallBay(Plant& plant, GroupId wall, std::uint32_t bay, double z, bool south) {
  Model& model = plant.model;
  const GroupId group = model.group(wall, named("Bay", bay + 1), at({kBayM * bay, 0, z}));
  const double out = south ? 0.1 : -0.1;
  const auto panel = [&](const char* name, std::uint32_t paint, double y0, double y1) {
    model.leaf(group, name, paint,
               {box({0, y0, -0.08}, {kBayM, y1, 0.08}),
                repeated(box({0.25, y0, out - 0.06}, {0.45, y1, out + 0.06}), 11, {0.8, 0, 0})});
  };
  // Every third bay of the road side stands open: one can look and walk in.
  const bool open = south && bay % 3 == 1;
  if (!open) panel("Lower cladding", plant.paint.claddingLight, 1, 6.5);
  if (open) {
    model.leaf(group, "Door frame", plant.paint.railing,
               {box({0.4, 0, -0.2}, {0.7, 6.5, 0.2}), box({kBayM - 0.7, 0, -0.2}, {kBayM - 0.4, 6.5, 0.2}),
                box({0.4, 6.2, -0.2}, {kBayM - 0.4, 6.5, 0.2})});
  }
  model.leaf(group, "Window band", plant.paint.glass, {box({0, 6.5, -0.03}, {kBayM, 9.5, 0.03})});
  model.leaf(group, "Mullions", plant.paint.steelDark,
             {repeated(box({0, 6.5, -0.1}, {0.12, 9.5, 0.1}), 7, {1.51, 0, 0}),
              box({0, 7.9, -0.08}, {kBayM, 8.05, 0.08})});
  panel("Upper cladding", plant.paint.claddingBlue, 9.5, kEavesM);
  if (!open) model.leaf(group, "Plinth", plant.paint.concreteDark, {box({0, 0, -0.25}, {kBayM, 1, 0.25})});
}

void addShell(Plant& plant, GroupId hall) {
  Model& model = plant.model;
  const GroupId shell = model.group(hall, "Shell");
  const GroupId south = model.group(shell, "South wall");
  const GroupId north = model.group(shell, "North wall");
  for (std::uint32_t bay = 0; bay < kBays; ++bay) {
    addWallBay(plant, south, bay, kDepthM, true);
    addWallBay(plant, north, bay, 0, false);
  }
  const GroupId roof = model.group(shell, "Roof");
  // A roof sheet slopes from the eaves to the ridge; in its own frame it lies flat along x.
  const Vec3 slope = Vec3(0, kRidgeM - kEavesM + 0.4, -kDepthM / 2 - 0.8);
  for (std::uint32_t bay = 0; bay < kBays; ++bay) {
    for (const bool onSouth : {true, false}) {
      const Vec3 up = Vec3(0, slope.y(), onSouth ? slope.z() : -slope.z()).normalized();
      const Vec3 x = onSouth ? Vec3::UnitX() : Vec3(-Vec3::UnitX());
      Parts sheet = {box({0, 0, 0}, {kBayM, slope.norm(), 0.2}),
                     repeated(box({0.3, 0, 0.2}, {0.42, slope.norm(), 0.3}), 11, {0.8, 0, 0})};
      model.leaf(
          roof, named(onSouth ? "South sheet" : "North sheet", bay + 1), plant.paint.roof, std::move(sheet),
          at({onSouth ? kBayM * bay : kBayM * (bay + 1), kEavesM - 0.1, onSouth ? kDepthM + 0.8 : -0.8},
             fromAxes(x, up)));
    }
    if (bay % 2 == 1) {
      model.leaf(roof, named("Ridge vent", bay + 1), plant.paint.aluminium,
                 {box({1.5, kRidgeM, kDepthM / 2 - 1.4}, {kBayM - 1.5, kRidgeM + 1.8, kDepthM / 2 + 1.4})},
                 at(kBayM * bay, 0, 0));
    }
  }
  for (const bool east : {false, true}) {
    model.leaf(
        shell, east ? "East gable" : "West gable", plant.paint.claddingBlue,
        {prism({{0, 6.5}, {kDepthM, 6.5}, {kDepthM, kEavesM}, {kDepthM / 2, kRidgeM}, {0, kEavesM}}, 0.16),
         repeated(box({0.4, 6.5, -0.06}, {0.55, kEavesM - 0.05, 0.22}), 42, {0.8, 0, 0})},
        at({east ? kLengthM : 0, 0, 0}, turnY(-kPi / 2)));
  }
  model.leaf(shell, "Ground slab", plant.paint.concrete,
             {box({-2, 0, -2}, {kLengthM + 2, 0.15, kDepthM + 2})});
}

void addCrane(Plant& plant, GroupId hall) {
  Model& model = plant.model;
  const GroupId crane = model.group(hall, "Overhead crane", at(0, 16.5, 0));
  model.leaf(crane, "Rails", plant.paint.steelDark,
             {beam({0, 0, 1.6}, {kLengthM, 0, 1.6}, 0.8, 0.4),
              beam({0, 0, kDepthM - 1.6}, {kLengthM, 0, kDepthM - 1.6}, 0.8, 0.4)});
  model.leaf(
      crane, "Bridge", plant.paint.railing,
      {box({40, 0.5, 1.2}, {41, 2.2, kDepthM - 1.2}), box({43.5, 0.5, 1.2}, {44.5, 2.2, kDepthM - 1.2})});
  model.leaf(crane, "Trolley", plant.paint.red,
             {box({39.8, 2.2, 12}, {44.7, 3.2, 15.5}), rod({40.5, 2.7, 13.7}, {44, 2.7, 13.7}, 0.5)});
  model.leaf(crane, "Hook", plant.paint.steelDark,
             {tube({42.2, -5, 13.7}, {42.2, 2.2, 13.7}, 0.06), blockOn({42.2, -5.8, 13.7}, {0.9, 0.9, 0.5}),
              ring({42.2, -6.2, 13.7}, 0.35, 0.09, Vec3::UnitZ())});
}

void addTurbine(Plant& plant, GroupId set) {
  Model& model = plant.model;
  const Vec3 x = Vec3::UnitX();
  const GroupId turbine = model.group(set, "Turbine");
  model.leaf(
      turbine, "High pressure casing", plant.paint.aluminium,
      {turned({1, 1.8, 0}, polyline({{0, 0}, {0.9, 0}, {1.3, 0.5}, {1.3, 2}, {0.9, 2.6}, {0, 2.6}}), x)});
  model.leaf(
      turbine, "Intermediate pressure casing", plant.paint.aluminium,
      {turned({4.4, 1.8, 0}, polyline({{0, 0}, {1.0, 0}, {1.6, 0.8}, {1.6, 2.2}, {1.0, 3}, {0, 3}}), x)});
  model.leaf(turbine, "Low pressure casing", plant.paint.tankWhite,
             {prism({{-2.4, 0}, {2.4, 0}, {2.4, 2}, {1.5, 3.6}, {-1.5, 3.6}, {-2.4, 2}}, 5,
                    at({8.2, 0, 0}, turnY(kPi / 2))),
              repeated(box({8.6, 1.9, -2.6}, {8.9, 2.3, 2.6}), 5, {1.05, 0, 0})});
  model.leaf(turbine, "Crossover pipe", plant.paint.aluminium,
             {tube({5.9, 3.3, 0}, {5.9, 4.2, 0}, 0.55),
              Part{.shape = Elbow{.pipeRadiusM = 0.55, .bendRadiusM = 0.9},
                   .placement = at(5.9, 4.2, 0),
                   .repeat = {}},
              tube({6.8, 5.1, 0}, {9.6, 5.1, 0}, 0.55),
              Part{.shape = Elbow{.pipeRadiusM = 0.55, .bendRadiusM = 0.9},
                   .placement = at({9.6, 5.1, 0}, fromAxes(-Vec3::UnitY(), x)),
                   .repeat = {}},
              tube({10.5, 4.2, 0}, {10.5, 3.4, 0}, 0.55)});
  model.leaf(turbine, "Shaft", plant.paint.steelDark, {rod({0.4, 1.8, 0}, {21, 1.8, 0}, 0.32)});
  const GroupId generator = model.group(set, "Generator", at(14.6, 0, 0));
  model.leaf(generator, "Stator", plant.paint.machineBlue,
             {rod({0, 1.8, 0}, {5.6, 1.8, 0}, 1.7),
              repeated(collar({0.3, 1.8, 0}, 1.69, 1.85, 0.18, x), 6, {0.95, 0, 0})});
  model.leaf(generator, "Feet", plant.paint.machineBlue, {box({0.3, 0, -1.9}, {5.3, 0.9, 1.9})});
  model.leaf(generator, "Exciter", plant.paint.machine,
             {rod({5.9, 1.6, 0}, {7.6, 1.6, 0}, 0.85), box({6, 0, -0.9}, {7.5, 1, 0.9})});
  model.leaf(generator, "Coolers", plant.paint.aluminium,
             {repeated(box({0.6, 2.9, -0.9}, {1.9, 3.9, 0.9}), 3, {1.55, 0, 0})});
}

void addSet(Plant& plant, GroupId hall, std::uint32_t number, double x) {
  Model& model = plant.model;
  const GroupId set = model.group(hall, named("Turbine set", number), at(x, kFloorM, 15));
  Parts pedestal = {box({-0.5, -0.9, -3.4}, {23, 0, 3.4})};
  pedestal.push_back(repeated(box({0, -kFloorM, -3.2}, {1.4, -0.9, -1.8}), 4, {6.8, 0, 0}));
  pedestal.push_back(repeated(box({0, -kFloorM, 1.8}, {1.4, -0.9, 3.2}), 4, {6.8, 0, 0}));
  model.leaf(set, "Pedestal", plant.paint.concrete, std::move(pedestal));
  addTurbine(plant, set);
  const GroupId condenser = model.group(set, "Condenser", at(10.6, -kFloorM, 0));
  model.leaf(condenser, "Shell", plant.paint.machine,
             {box({-2.2, 0.8, -1.7}, {2.2, 6.9, 1.7}),
              repeated(box({-2.3, 1.5, -1.8}, {2.3, 1.65, 1.8}), 5, {0, 1.1, 0})});
  model.leaf(condenser, "Water boxes", plant.paint.machineBlue,
             {vessel({0, 3, 1.7}, {0, 3, 3.0}, 1.5, 0.5), vessel({0, 3, -3.0}, {0, 3, -1.7}, 1.5, 0.5)});
  const GroupId piping = model.group(set, "Piping");
  for (std::uint32_t i = 0; i < 3; ++i) {
    const double px = 2.0 + 2.2 * i;
    addPipeRun(
        plant, piping,
        {.name = named("Main steam", i + 1),
         .material = plant.pipe(i == 2 ? Condensate : Steam),
         .radiusM = 0.24,
         .path =
             {{px, 0.7, -1.0}, {px, -2.4, -1.0}, {px, -2.4, -9.5}, {px, -5.8, -9.5}, {px + 5, -5.8, -9.5}},
         .valvesOn = {2}});
  }
  addPipeRun(plant, piping,
             {.name = "Cooling water inlet",
              .material = plant.pipe(Water),
              .radiusM = 0.6,
              .path = {{10.6, -5, 3.4}, {10.6, -5, 8}, {10.6, -7.2, 8}, {4, -7.2, 8}}});
  addPipeRun(plant, piping,
             {.name = "Cooling water outlet",
              .material = plant.pipe(Water),
              .radiusM = 0.6,
              .path = {{12.2, -5, 2.6}, {12.2, -5, 11}, {12.2, -7.2, 11}, {4, -7.2, 11}}});
  addPipeRun(plant, piping,
             {.name = "Lube oil",
              .material = plant.pipe(Oil),
              .radiusM = 0.08,
              .path = {{1, 0.4, 3.2}, {1, -4, 3.2}, {20, -4, 3.2}, {20, -7.4, 3.2}},
              .valvesOn = {1}});
  addPump(plant, set, "Condensate pump", at(16, -kFloorM, -7), 0.9);
  addCabinets(plant, set, at(16, 0.1, 8), 4);
}

void addMachineFloor(Plant& plant, GroupId hall) {
  Model& model = plant.model;
  const GroupId floor = model.group(hall, "Machine floor", at(0, kFloorM, 0));
  model.leaf(floor, "South slab", plant.paint.concrete, {box({2, -0.35, 19}, {kLengthM - 2, 0, 26})});
  model.leaf(floor, "North slab", plant.paint.concrete, {box({2, -0.35, 4}, {kLengthM - 2, 0, 11})});
  model.leaf(floor, "Railing south", plant.paint.railing, railing({2, 0, 25.9}, {kLengthM - 2, 0, 25.9}));
  model.leaf(floor, "Railing north", plant.paint.railing, railing({2, 0, 4.1}, {kLengthM - 2, 0, 4.1}));
  model.leaf(floor, "Columns", plant.paint.steel,
             {repeated(beam({4, -kFloorM, 25}, {4, -0.35, 25}, 0.4, 0.4), 8, {12, 0, 0}),
              repeated(beam({4, -kFloorM, 5}, {4, -0.35, 5}, 0.4, 0.4), 8, {12, 0, 0})});
  model.leaf(floor, "Stairs", plant.paint.galvanized, steelStairs(9, kFloorM, 1.4), at(6, -kFloorM, 27));
}

}  // namespace

void addTurbineHall(Plant& plant, GroupId root) {
  const GroupId hall = plant.model.group(root, "Turbine hall", at(-72, 0, -22));
  addFrames(plant, hall);
  addShell(plant, hall);
  addCrane(plant, hall);
  addMachineFloor(plant, hall);
  for (std::uint32_t i = 0; i < 3; ++i)
    addSet(plant, hall, i + 1, 5.0 + 29 * i);
}

}  // namespace tessera::synthetic
