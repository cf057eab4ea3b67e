#include <string>

#include "common/scene/synthetic/plant.h"

namespace tessera::synthetic {
namespace {

void addGround(Plant& plant, GroupId site) {
  Model& model = plant.model;
  const GroupId ground = model.group(site, "Ground");
  model.leaf(ground, "Slab", plant.paint.gravel, {box({-150, -1, -100}, {150, 0, 100})});
  model.leaf(ground, "Lawn west", plant.paint.grass, {box({-148, 0, 46}, {-98, 0.08, 98})});
  model.leaf(ground, "Lawn north", plant.paint.grass, {box({-148, 0, -98}, {-84, 0.08, -92})});
  const GroupId roads = model.group(ground, "Roads");
  const auto road = [&](const char* name, const Vec3& min, const Vec3& max) {
    model.leaf(roads, name, plant.paint.asphalt, {box(min, max)});
  };
  road("Main road", {-150, 0, 30.5}, {150, 0.12, 37.5});
  road("West road", {-87, 0, -100}, {-80, 0.121, 100});
  road("East road", {42, 0, -30}, {49, 0.121, 100});
  road("North road", {-80, 0, -33}, {150, 0.122, -27});
  Part dashes = repeated(box({-148, 0, 33.9}, {-145, 0.14, 34.1}), 49, {6, 0, 0});
  model.leaf(roads, "Markings", plant.paint.marking,
             {dashes, repeated(box({-83.6, 0, -98}, {-83.4, 0.14, -95}), 33, {0, 0, 6}),
              repeated(box({45.4, 0, -28}, {45.6, 0.14, -25}), 21, {0, 0, 6})});
}

void addFence(Plant& plant, GroupId site) {
  constexpr double kPanelM = 25;
  const GroupId fence = plant.model.group(site, "Fence");
  Parts parts = {repeated(tube({0, 0, 0}, {0, 2.4, 0}, 0.05), 5, {5, 0, 0}),
                 repeated(bar({0, 0.3, 0}, {kPanelM, 0.3, 0}, 0.05), 3, {0, 0.95, 0}),
                 fromLevel(repeated(bar({0, 0.3, 0}, {kPanelM, 0.3, 0}, 0.02), 13, {0, 0.15, 0}), 1.5),
                 fromLevel(repeated(bar({0, 0.3, 0}, {0, 2.2, 0}, 0.02), 124, {0.2, 0, 0}), 4)};
  const FormId panel = plant.model.form(plant.paint.galvanized, std::move(parts));
  const auto side = [&](const char* name, const Vec3& start, double turnRad, std::uint32_t panels) {
    const GroupId group = plant.model.group(fence, name, at(start, turnY(turnRad)));
    for (std::uint32_t i = 0; i < panels; ++i) {
      plant.model.leaf(group, "Panel " + std::to_string(i + 1), panel, at(kPanelM * i, 0, 0));
    }
  };
  side("North side", {-150, 0, -99.4}, 0, 12);
  side("South side", {-150, 0, 99.4}, 0, 12);
  side("West side", {-149.4, 0, 30}, kPi / 2, 5);
  side("East side", {149.4, 0, 30}, kPi / 2, 5);
}

void addLamps(Plant& plant, GroupId site) {
  Model& model = plant.model;
  const GroupId lamps = model.group(site, "Street lamps");
  const FormId pole = model.form(plant.paint.galvanized,
                                 {turned({0, 0, 0}, polyline({{0.2, 0}, {0.2, 0.4}, {0.1, 0.45}, {0.06, 8}})),
                                  tube({0, 7.9, 0}, {1.8, 8.4, 0}, 0.05)});
  const FormId head = model.form(plant.paint.white, {box({1.5, 8.33, -0.15}, {2.4, 8.47, 0.15})});
  const auto lamp = [&](std::uint32_t number, const Vec3& where, double turnRad) {
    const GroupId group = model.group(lamps, "Lamp " + std::to_string(number), at(where, turnY(turnRad)));
    model.leaf(group, "Pole", pole);
    model.leaf(group, "Head", head);
  };
  std::uint32_t number = 0;
  for (std::uint32_t i = 0; i < 12; ++i)
    lamp(++number, {-138.0 + 25 * i, 0, 38.5}, kPi / 2);
  for (std::uint32_t i = 0; i < 7; ++i)
    lamp(++number, {-88, 0, -90.0 + 24 * i}, 0);
  for (std::uint32_t i = 0; i < 5; ++i)
    lamp(++number, {50, 0, -20.0 + 24 * i}, kPi);
}

void addTree(Plant& plant, GroupId parent, std::uint32_t number, const Vec3& where) {
  const double heightM = plant.random.between(5, 9);
  const double crownM = heightM * plant.random.between(0.22, 0.3);
  const GroupId tree = plant.model.group(parent, "Tree " + std::to_string(number), at(where));
  plant.model.leaf(tree, "Trunk", plant.paint.timber, {tube({0, 0, 0}, {0, heightM * 0.5, 0}, 0.14)});
  plant.model.leaf(
      tree, "Crown", plant.paint.leaves,
      {turned({0, heightM * 0.62, 0}, {arc({0, 0}, {crownM, heightM * 0.38}, -kPi / 2, kPi / 2)}),
       fromLevel(turned({crownM * 0.4, heightM * 0.5, crownM * 0.3},
                        {arc({0, 0}, {crownM * 0.7, heightM * 0.22}, -kPi / 2, kPi / 2)}),
                 1.5)});
}

void addCar(Plant& plant, GroupId parent, std::uint32_t number, const Placement& placement) {
  Model& model = plant.model;
  const auto& colours = plant.paint.vehicles;
  const std::uint32_t colour = colours[plant.random.index(static_cast<std::uint32_t>(colours.size()))];
  const GroupId car = model.group(parent, "Car " + std::to_string(number), placement);
  model.leaf(car, "Body", colour,
             {prism({{-2.1, 0.3},
                     {2.1, 0.3},
                     {2.15, 0.75},
                     {1.2, 0.9},
                     {0.6, 1.4},
                     {-1.2, 1.42},
                     {-1.9, 0.95},
                     {-2.15, 0.85}},
                    1.7, at(0, 0, -0.85))});
  model.leaf(car, "Windows", plant.paint.glass,
             {prism({{1.12, 0.93}, {0.62, 1.32}, {-1.15, 1.34}, {-1.7, 0.95}}, 1.72, at(0, 0, -0.86))});
  Part wheel = rod({1.3, 0.32, 0.6}, {1.3, 0.32, 0.87}, 0.32);
  Part other = rod({1.3, 0.32, -0.87}, {1.3, 0.32, -0.6}, 0.32);
  model.leaf(car, "Wheels", plant.paint.rubber,
             {repeated(wheel, 2, {-2.6, 0, 0}), repeated(other, 2, {-2.6, 0, 0})});
}

void addOffice(Plant& plant, GroupId site) {
  Model& model = plant.model;
  const GroupId office = model.group(site, "Office building", at(-125, 0, 58));
  const GroupId shell = model.group(office, "Shell");
  model.leaf(shell, "Plinth", plant.paint.concreteDark, {blockOn({0, 0, 0}, {37, 0.6, 15})});
  for (std::uint32_t storey = 0; storey < 4; ++storey) {
    const double y = 0.6 + 3.5 * storey;
    const GroupId group = model.group(shell, "Storey " + std::to_string(storey + 1), at(0, y, 0));
    model.leaf(group, "Walls", plant.paint.claddingLight,
               {blockOn({0, 0, 0}, {36, 1.1, 14}), blockOn({0, 3, 0}, {36, 0.5, 14}),
                repeated(box({-18, 1.1, -7}, {-17.4, 3, 7}), 2, {35.4, 0, 0})});
    model.leaf(group, "Glazing", plant.paint.glass, {blockOn({0, 1.1, 0}, {35.4, 1.9, 13.6})});
    model.leaf(group, "Mullions", plant.paint.steelDark,
               {repeated(box({-16.6, 1.1, -6.95}, {-16.5, 3, 6.95}), 17, {2.1, 0, 0})});
  }
  const GroupId roof = model.group(office, "Roof", at(0, 14.6, 0));
  model.leaf(roof, "Parapet", plant.paint.concrete, {blockOn({0, 0, 0}, {36.6, 0.5, 14.6})});
  model.leaf(roof, "Plant room", plant.paint.claddingBlue, {blockOn({-8, 0.5, 0}, {9, 3, 7})});
  for (std::uint32_t i = 0; i < 3; ++i) {
    model.leaf(roof, "Chiller " + std::to_string(i + 1), plant.paint.aluminium,
               {blockOn({0, 0.5, 0}, {3, 1.4, 2}), rod({-0.7, 1.9, 0}, {-0.7, 2.1, 0}, 0.6),
                rod({0.7, 1.9, 0}, {0.7, 2.1, 0}, 0.6)},
               at(4.0 + 4.5 * i, 0, 2));
  }
  model.leaf(office, "Canopy", plant.paint.steel,
             {box({-4, 3.4, 7}, {4, 3.7, 10.5}),
              repeated(tube({-3.6, 0, 10}, {-3.6, 3.4, 10}, 0.1), 2, {7.2, 0, 0})});
}

}  // namespace

void addSite(Plant& plant, GroupId root) {
  Model& model = plant.model;
  const GroupId site = model.group(root, "Site");
  addGround(plant, site);
  addFence(plant, site);
  addLamps(plant, site);
  addOffice(plant, site);
  const GroupId trees = model.group(site, "Trees");
  for (std::uint32_t i = 0; i < 16; ++i) {
    addTree(plant, trees, i + 1, {-145 + plant.random.between(0, 3), 0, 42.0 + 3.5 * i});
  }
  const GroupId parking = model.group(site, "Parking", at(-140, 0.1, 76));
  model.leaf(parking, "Pavement", plant.paint.asphalt, {box({-3, 0, -4}, {46, 0.05, 20})});
  model.leaf(parking, "Stripes", plant.paint.marking,
             {repeated(box({-1.35, 0, -2.8}, {-1.25, 0.06, 2.8}), 17, {2.7, 0, 0}),
              repeated(box({-1.35, 0, 13.2}, {-1.25, 0.06, 18.8}), 17, {2.7, 0, 0})});
  for (std::uint32_t i = 0; i < 22; ++i) {
    const double x = 2.7 * (i % 16);
    if (plant.layout.chance(0.2)) continue;
    addCar(plant, parking, i + 1, at({x, 0.05, i < 16 ? 0.0 : 16.0}, turnY(i % 3 == 0 ? kPi / 2 : -kPi / 2)));
  }
}

void addLaydownYard(Plant& plant, GroupId root, std::uint32_t leafCount) {
  constexpr std::uint32_t kBays = 12;
  Model& model = plant.model;
  const GroupId yard = model.group(root, "Laydown yard", at(-77, 0, 42));
  model.leaf(yard, "Pavement", plant.paint.concrete, {box({-1, 0, -2}, {33, 0.1, 6})});
  const auto& colours = plant.paint.drums;
  GroupId row = yard;
  for (std::uint32_t i = 0; i + 1 < leafCount; ++i) {
    // A last row of one item would be a group with one child.
    if (i % kBays == 0 && i + 2 < leafCount) {
      const std::uint32_t number = i / kBays;
      row = model.group(yard, "Row " + std::to_string(number + 1), at(0.5, 0.1, 2.6 * number));
    }
    const Placement place = at(2.6 * (i % kBays), 0, 0);
    const std::uint32_t colour = colours[plant.random.index(static_cast<std::uint32_t>(colours.size()))];
    switch (plant.random.index(4)) {
      case 0:
        model.leaf(row, "Drums", colour,
                   {repeated(rod({0.3, 0, 0.3}, {0.3, 0.9, 0.3}, 0.29), 3, {0.62, 0, 0}),
                    repeated(rod({0.3, 0, 0.92}, {0.3, 0.9, 0.92}, 0.29), 3, {0.62, 0, 0})},
                   place);
        break;
      case 1:
        model.leaf(row, "Crate", plant.paint.timber,
                   {box({0.1, 0.1, 0.1}, {1.9, plant.random.between(0.8, 1.8), 1.7}),
                    repeated(box({0.1, 0, 0.1}, {1.9, 0.1, 0.3}), 3, {0, 0, 0.7})},
                   place);
        break;
      case 2:
        model.leaf(row, "Pipe stack", plant.paint.rust,
                   {repeated(tube({0, 0.2, 0.3}, {2.4, 0.2, 0.3}, 0.2), 4, {0, 0, 0.42}),
                    repeated(tube({0, 0.56, 0.51}, {2.4, 0.56, 0.51}, 0.2), 3, {0, 0, 0.42})},
                   place);
        break;
      default:
        model.leaf(row, "Container", colour,
                   {box({0, 0.1, 0}, {2.3, 2.2, 2.0}),
                    repeated(box({0.1, 0.2, 2.0}, {0.2, 2.1, 2.06}), 8, {0.28, 0, 0})},
                   place);
        break;
    }
  }
}

}  // namespace tessera::synthetic
