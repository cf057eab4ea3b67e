#include <string>

#include "common/scene/synthetic/plant.h"

namespace tessera::synthetic {
namespace {

constexpr double kBayX = 8.8;
constexpr double kBayZ = 11;
constexpr std::uint32_t kBaysX = 5;
constexpr std::uint32_t kBaysZ = 3;
constexpr double kStoreyM = 11;
constexpr std::uint32_t kStoreys = 5;
constexpr double kWidthM = kBayX * kBaysX;
constexpr double kDepthM = kBayZ * kBaysZ;

std::string named(const char* what, std::size_t number) {
  return what + (' ' + std::to_string(number));
}

void addColumns(Plant& plant, GroupId storey, bool lowest) {
  const GroupId columns = plant.model.group(storey, "Columns");
  const Vec3 top(0, kStoreyM, 0);
  for (std::uint32_t i = 0; i <= kBaysX; ++i) {
    for (std::uint32_t k = 0; k <= kBaysZ; ++k) {
      // The furnace hangs free in the middle.
      if (i >= 2 && i <= 3 && k >= 1 && k <= 2) continue;
      Parts parts = {beam(Vec3::Zero(), top, 0.8, 0.6)};
      if (lowest) parts.push_back(blockOn({0, 0, 0}, {1.3, 0.5, 1.3}));
      plant.model.leaf(columns, named("Column", i * (kBaysZ + 1) + k + 1), plant.paint.steel,
                       std::move(parts), at(kBayX * i, 0, kBayZ * k));
    }
  }
}

void addBeams(Plant& plant, GroupId storey) {
  const GroupId alongX = plant.model.group(storey, "Girders", at(0, kStoreyM - 0.6, 0));
  for (std::uint32_t k = 0; k <= kBaysZ; ++k) {
    for (std::uint32_t i = 0; i < kBaysX; ++i) {
      if (i == 2 && k >= 1 && k <= 2) continue;
      plant.model.leaf(alongX, named("Girder", k * kBaysX + i + 1), plant.paint.steel,
                       {beam({0, 0, 0}, {kBayX, 0, 0}, 0.9, 0.4)}, at(kBayX * i, 0, kBayZ * k));
    }
  }
  const GroupId alongZ = plant.model.group(storey, "Beams", at(0, kStoreyM - 0.5, 0));
  for (std::uint32_t i = 0; i <= kBaysX; ++i) {
    for (std::uint32_t k = 0; k < kBaysZ; ++k) {
      if (i >= 2 && i <= 3 && k == 1) continue;
      plant.model.leaf(alongZ, named("Beam", i * kBaysZ + k + 1), plant.paint.steel,
                       {beam({0, 0, 0}, {0, 0, kBayZ}, 0.6, 0.3)}, at(kBayX * i, 0, kBayZ * k));
    }
  }
}

void addBraces(Plant& plant, GroupId storey) {
  const GroupId braces = plant.model.group(storey, "Bracing");
  const auto cross = [&](const char* name, const Vec3& foot, const Vec3& across) {
    const Vec3 up(0, kStoreyM - 0.8, 0);
    plant.model.leaf(braces, name, plant.paint.steel,
                     {beam({0, 0, 0}, across + up, 0.3, 0.3), beam(across, up, 0.3, 0.3)}, at(foot));
  };
  cross("North", {kBayX * 2, 0.4, 0}, {kBayX, 0, 0});
  cross("West", {0, 0.4, kBayZ}, {0, 0, kBayZ});
  cross("East", {kWidthM, 0.4, kBayZ}, {0, 0, kBayZ});
  cross("South", {kBayX, 0.4, kDepthM}, {kBayX, 0, 0});
}

void addFloor(Plant& plant, GroupId storey) {
  const GroupId floor = plant.model.group(storey, "Floor", at(0, kStoreyM, 0));
  addPlatform(plant, floor, "South walkway", at(0, 0, kDepthM - 6),
              {.sizeM = {kWidthM, 6}, .north = true, .south = true, .east = true, .west = true});
  addPlatform(plant, floor, "North walkway", at(0, 0, 0), {.sizeM = {kWidthM, 5}});
  addPlatform(plant, floor, "West walkway", at(0, 0, 5),
              {.sizeM = {8, kDepthM - 11}, .north = false, .south = false});
  addPlatform(plant, floor, "East walkway", at(kWidthM - 8, 0, 5),
              {.sizeM = {8, kDepthM - 11}, .north = false, .south = false});
}

void addFurnace(Plant& plant, GroupId boiler) {
  Model& model = plant.model;
  const GroupId furnace = model.group(boiler, "Furnace", at(kWidthM / 2, 0, kDepthM / 2));
  const Vec2 half(6.6, 5.2);
  model.leaf(furnace, "Walls", plant.paint.claddingDark,
             {blockOn({0, 11, 0}, {half.x() * 2, 40, half.y() * 2})});
  model.leaf(
      furnace, "Ash hopper", plant.paint.claddingDark,
      {prism({{-1.5, 5}, {1.5, 5}, {half.x(), 11}, {-half.x(), 11}}, half.y() * 2, at(0, 0, -half.y()))});
  model.leaf(furnace, "Wall tubes", plant.paint.rust,
             {repeated(tube({-half.x() + 0.3, 11, half.y()}, {-half.x() + 0.3, 51, half.y()}, 0.11), 26,
                       {0.5, 0, 0}),
              repeated(tube({half.x(), 11, -half.y() + 0.3}, {half.x(), 51, -half.y() + 0.3}, 0.11), 20,
                       {0, 0, 0.5}),
              repeated(tube({-half.x(), 11, -half.y() + 0.3}, {-half.x(), 51, -half.y() + 0.3}, 0.11), 20,
                       {0, 0, 0.5})});
  const GroupId buckstays = model.group(furnace, "Buckstays");
  for (std::uint32_t i = 0; i < 10; ++i) {
    model.leaf(buckstays, named("Buckstay", i + 1), plant.paint.steelDark,
               {box({-half.x() - 0.4, 0, half.y() + 0.1}, {half.x() + 0.4, 0.45, half.y() + 0.45}),
                box({-half.x() - 0.4, 0, -half.y() - 0.45}, {half.x() + 0.4, 0.45, -half.y() - 0.1}),
                box({half.x() + 0.1, 0, -half.y()}, {half.x() + 0.45, 0.45, half.y()}),
                box({-half.x() - 0.45, 0, -half.y()}, {-half.x() - 0.1, 0.45, half.y()})},
               at(0, 12.5 + 4 * i, 0));
  }
  const GroupId burners = model.group(furnace, "Burners");
  for (std::uint32_t row = 0; row < 3; ++row) {
    const GroupId level =
        model.group(burners, named("Burner level", row + 1), at(0, 15 + 4.0 * row, half.y()));
    for (std::uint32_t i = 0; i < 4; ++i) {
      model.leaf(level, named("Burner", i + 1), plant.paint.machineBlue,
                 {turned({0, 0, 0}, polyline({{0.9, 0}, {0.9, 0.7}, {0.45, 1.1}, {0.45, 1.8}, {0, 1.8}}),
                         Vec3::UnitZ())},
                 at(-4.8 + 3.2 * i, 0, 0));
    }
  }
  const GroupId drum = model.group(furnace, "Steam drum", at(0, 53, 3));
  model.leaf(drum, "Drum", plant.paint.aluminium, {vessel({-8, 0, 0}, {8, 0, 0}, 1, 0.6)});
  model.leaf(drum, "Hangers", plant.paint.steelDark,
             {repeated(box({-6, -1.1, -1.15}, {-5.7, 3, -1.0}), 5, {3, 0, 0}),
              repeated(box({-6, -1.1, 1.0}, {-5.7, 3, 1.15}), 5, {3, 0, 0})});
  model.leaf(drum, "Safety valves", plant.paint.red,
             {repeated(rod({-6, 0.9, 0}, {-6, 2.2, 0}, 0.18), 4, {4, 0, 0})});
}

void addBoilerPiping(Plant& plant, GroupId boiler) {
  const GroupId piping = plant.model.group(boiler, "Boiler piping", at(kWidthM / 2, 0, kDepthM / 2));
  for (std::uint32_t i = 0; i < 4; ++i) {
    const double x = -4.5 + 3.0 * i;
    addPipeRun(plant, piping,
               {.name = named("Downcomer", i + 1),
                .material = plant.pipe(Condensate),
                .radiusM = 0.25,
                .path = {{x, 52.2, 4}, {x, 49.5, 4}, {x, 49.5, 6.3}, {x, 9, 6.3}, {x, 9, 3}},
                .spoolM = 21,
                .endFlanges = false});
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const double z = -4.5 + 1.8 * i;
    const double y = 40 - 3.5 * i;
    addPipeRun(plant, piping,
               {.name = named("Superheater line", i + 1),
                .material = plant.pipe(i % 2 == 0 ? Steam : Condensate),
                .radiusM = 0.28 - 0.02 * i,
                .path = {{6.6, y, z},
                         {10.0 + 0.5 * i, y, z},
                         {10.0 + 0.5 * i, 6 + 1.2 * i, z},
                         {10.0 + 0.5 * i, 6 + 1.2 * i, 20}},
                .spoolM = 13,
                .valvesOn = {2}});
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const double x = -18 - 0.7 * (i % 2);
    const double y = 4 + 5.5 * i;
    addPipeRun(plant, piping,
               {.name = named("Feed line", i + 1),
                .material = plant.pipe(i % 3 == 0   ? Gas
                                       : i % 3 == 1 ? Water
                                                    : Air),
                .radiusM = 0.09 + 0.02 * (i % 3),
                .path = {{x, 0.5, 14 - 0.6 * i}, {x, y, 14 - 0.6 * i}, {-8, y, 14 - 0.6 * i}, {-8, y, 5.8}},
                .spoolM = 12,
                .endFlanges = false,
                .valvesOn = {1}});
  }
}

void addStairTower(Plant& plant, GroupId boiler) {
  Model& model = plant.model;
  const GroupId tower = model.group(boiler, "Stair tower", at(kWidthM + 0.5, 0, kDepthM - 12));
  Parts frame;
  for (const double x : {0.0, 8.0}) {
    for (const double z : {0.0, 3.2})
      frame.push_back(beam({x, 0, z}, {x, kStoreyM * kStoreys + 1, z}, 0.3, 0.3));
  }
  model.leaf(tower, "Frame", plant.paint.steel, std::move(frame));
  const double riseM = kStoreyM / 2;
  for (std::uint32_t i = 0; i < 2 * kStoreys; ++i) {
    const bool back = i % 2 == 1;
    const GroupId flight = model.group(tower, named("Flight", i + 1), at(0, riseM * i, 0));
    model.leaf(flight, "Stairs", plant.paint.galvanized, steelStairs(5, riseM, 1),
               at({back ? 6.5 : 1.5, 0, back ? 2.4 : 0.8}, turnY(back ? kPi : 0)));
    model.leaf(flight, "Landing", plant.paint.grating, grating({1.5, 3.2}), at(back ? 0 : 6.5, riseM, 0));
    model.leaf(flight, "Landing rail", plant.paint.railing,
               railing({back ? 0.05 : 7.95, riseM, 0}, {back ? 0.05 : 7.95, riseM, 3.2}));
  }
}

void addEnclosure(Plant& plant, GroupId boiler) {
  Model& model = plant.model;
  const double topM = kStoreyM * kStoreys;
  const GroupId shell = model.group(boiler, "Roof and cladding", at(0, topM, 0));
  for (std::uint32_t i = 0; i < kBaysX; ++i) {
    model.leaf(shell, named("Roof panel", i + 1), plant.paint.roof,
               {box({0, 0.8, -0.6}, {kBayX, 1.1, kDepthM + 0.6}),
                repeated(box({0.3, 1.1, -0.6}, {0.5, 1.25, kDepthM + 0.6}), 5, {1.76, 0, 0})},
               at(kBayX * i, 0, 0));
    for (const bool south : {false, true}) {
      model.leaf(shell, named(south ? "South cladding" : "North cladding", i + 1), plant.paint.claddingBlue,
                 {box({0, -13, 0}, {kBayX, 0.9, 0.12}),
                  repeated(box({0.2, -13, -0.08}, {0.35, 0.9, 0.2}), 11, {0.8, 0, 0})},
                 at(kBayX * i, 0, south ? kDepthM + 0.5 : -0.62));
    }
  }
  for (const bool east : {false, true}) {
    model.leaf(shell, east ? "East cladding" : "West cladding", plant.paint.claddingBlue,
               {box({0, -13, -0.6}, {0.12, 0.9, kDepthM + 0.6}),
                repeated(box({-0.08, -13, 0}, {0.2, 0.9, 0.15}), 38, {0, 0, 0.88})},
               at(east ? kWidthM + 0.5 : -0.62, 0, 0));
  }
  model.leaf(shell, "Penthouse", plant.paint.claddingLight, {box({14, 1.1, 8}, {30, 5.5, 25})});
  model.leaf(shell, "Vent stacks", plant.paint.aluminium,
             {repeated(tube({5, 1, 6}, {5, 6, 6}, 0.35), 3, {2.2, 0, 0}),
              repeated(tube({34, 1, 26}, {34, 5, 26}, 0.5), 3, {2.4, 0, 0})});
}

void addMills(Plant& plant, GroupId boiler) {
  Model& model = plant.model;
  const GroupId mills = model.group(boiler, "Coal mills", at(4, 0, kDepthM - 4));
  for (std::uint32_t i = 0; i < 5; ++i) {
    const GroupId mill = model.group(mills, named("Mill", i + 1), at(kBayX * i + 0.4, 0, 0));
    model.leaf(mill, "Foundation", plant.paint.concrete, {blockOn({0, 0, 0}, {4.4, 0.8, 4.4})});
    model.leaf(mill, "Housing", plant.paint.machine,
               {turned({0, 0.8, 0},
                       {line({1.8, 0}, {1.8, 1}), line({1.8, 1}, {1.5, 1.2}), line({1.5, 1.2}, {1.5, 3}),
                        line({1.5, 3}, {1.9, 3.4}), line({1.9, 3.4}, {1.9, 4.6}),
                        line({1.9, 4.6}, {0.6, 6.2}), line({0.6, 6.2}, {0, 6.2})})});
    model.leaf(mill, "Feed pipe", plant.paint.galvanized, {tube({0, 7, 0}, {0, 10.4, 0}, 0.45)});
    model.leaf(mill, "Motor", plant.paint.machineBlue, {vessel({2, 1.8, 0}, {3.4, 1.8, 0}, 0.6, 0.2)});
  }
}

}  // namespace

void addBoilerHouse(Plant& plant, GroupId root) {
  const GroupId boiler = plant.model.group(root, "Boiler house", at(-24, 0, -70));
  plant.model.leaf(boiler, "Base slab", plant.paint.concrete,
                   {box({-2, 0, -2}, {kWidthM + 10, 0.15, kDepthM + 2})});
  const GroupId steel = plant.model.group(boiler, "Steelwork");
  for (std::uint32_t i = 0; i < kStoreys; ++i) {
    const GroupId storey = plant.model.group(steel, named("Storey", i + 1), at(0, kStoreyM * i, 0));
    addColumns(plant, storey, i == 0);
    addBeams(plant, storey);
    addBraces(plant, storey);
    addFloor(plant, storey);
  }
  addFurnace(plant, boiler);
  addBoilerPiping(plant, boiler);
  addStairTower(plant, boiler);
  addEnclosure(plant, boiler);
  addMills(plant, boiler);
}

}  // namespace tessera::synthetic
