#include <string>

#include "common/scene/synthetic/plant.h"

namespace tessera::synthetic {
namespace {

std::string named(const char* what, std::size_t number) {
  return what + (' ' + std::to_string(number));
}

/// Stack of porcelain discs along `axis`.
Part insulator(const Vec3& base, double lengthM, double radiusM, const Vec3& axis = Vec3::UnitY()) {
  std::vector<Vec2> points;
  constexpr std::uint32_t kDiscs = 4;
  for (std::uint32_t i = 0; i < kDiscs; ++i) {
    const double y = lengthM * i / kDiscs;
    points.emplace_back(radiusM * 0.5, y);
    points.emplace_back(radiusM, y + lengthM * 0.45 / kDiscs);
  }
  points.emplace_back(radiusM * 0.4, lengthM);
  return turned(base, polyline(points), axis);
}

void addTransformer(Plant& plant, GroupId area, std::uint32_t number, const Vec3& where) {
  Model& model = plant.model;
  const GroupId transformer = model.group(area, named("Transformer", number), at(where));
  model.leaf(transformer, "Pit", plant.paint.concreteDark, {box({-4.2, 0, -3.4}, {4.2, 0.4, 3.4})});
  model.leaf(transformer, "Fire wall", plant.paint.concrete, {box({-4.5, 0, -4.1}, {4.5, 6.5, -3.7})});
  model.leaf(transformer, "Tank", plant.paint.machine,
             {box({-2.6, 0.7, -1.4}, {2.6, 4, 1.4}),
              repeated(box({-2.4, 0.7, -1.5}, {-2.25, 4, 1.5}), 6, {0.93, 0, 0})});
  const GroupId radiators = model.group(transformer, "Radiators");
  for (std::uint32_t i = 0; i < 4; ++i) {
    model.leaf(radiators, named("Radiator", i + 1), plant.paint.machine,
               {repeated(box({0, 1, 0}, {0.06, 3.8, 0.9}), 10, {0.16, 0, 0})},
               at(i % 2 == 0 ? -2.1 : 0.6, 0, i < 2 ? 1.6 : -2.5));
  }
  model.leaf(transformer, "Conservator", plant.paint.machine,
             {rod({-2.2, 5, -0.9}, {1.6, 5, -0.9}, 0.5),
              repeated(box({-1.5, 4, -1.0}, {-1.4, 4.7, -0.8}), 2, {2.4, 0, 0})});
  model.leaf(transformer, "High voltage bushings", plant.paint.porcelain,
             {repeated(insulator({-1.6, 4, 0.5}, 2.2, 0.26), 3, {1.6, 0, 0})});
  model.leaf(transformer, "Low voltage bushings", plant.paint.porcelain,
             {repeated(insulator({-1.9, 4, -0.2}, 0.9, 0.16), 4, {0.9, 0, 0})});
  model.leaf(transformer, "Control cabinet", plant.paint.cabinet, {box({2.9, 0.5, -0.6}, {3.5, 2.3, 0.6})});
}

/// Lattice portal across +z of its own frame.
void addGantry(Plant& plant, GroupId parent, const std::string& name, const Vec3& where) {
  Model& model = plant.model;
  constexpr double kHeightM = 11;
  constexpr double kSpanM = 12;
  const GroupId gantry = model.group(parent, name, at(where));
  const auto tower = [&](const char* towerName, double z) {
    Parts parts;
    for (const double sx : {-1.0, 1.0}) {
      for (const double sz : {-1.0, 1.0})
        parts.push_back(bar({0.7 * sx, 0, 0.7 * sz}, {0.3 * sx, kHeightM, 0.3 * sz}, 0.12));
    }
    for (std::uint32_t i = 0; i < 5; ++i) {
      const auto half = [](double y) { return 0.7 - y * 0.4 / 11; };
      const double y0 = kHeightM * i / 5;
      const double y1 = kHeightM * (i + 1) / 5;
      for (const double s : {-1.0, 1.0}) {
        parts.push_back(bar({-half(y0), y0, s * half(y0)}, {half(y1), y1, s * half(y1)}, 0.07));
        parts.push_back(bar({s * half(y0), y0, -half(y0)}, {s * half(y1), y1, half(y1)}, 0.07));
      }
    }
    model.leaf(gantry, towerName, plant.paint.galvanized, std::move(parts), at(0, 0, z));
  };
  tower("North tower", 0);
  tower("South tower", kSpanM);
  Parts girder;
  for (const double x : {-0.35, 0.35}) {
    for (const double y : {kHeightM - 0.3, kHeightM + 0.4})
      girder.push_back(bar({x, y, 0}, {x, y, kSpanM}, 0.1));
    girder.push_back(repeated(bar({x, kHeightM - 0.3, 0}, {x, kHeightM + 0.4, 1}, 0.06), 12, {0, 0, 1}));
  }
  model.leaf(gantry, "Girder", plant.paint.galvanized, std::move(girder));
  model.leaf(gantry, "Insulators", plant.paint.porcelain,
             {repeated(insulator({0, kHeightM - 1.9, 3}, 1.6, 0.16), 3, {0, 0, 3})});
}

void addBay(Plant& plant, GroupId yard, std::uint32_t number, double z) {
  Model& model = plant.model;
  const GroupId bay = model.group(yard, named("Bay", number), at(0, 0, z));
  addGantry(plant, bay, "Gantry west", {0, 0, 0});
  addGantry(plant, bay, "Gantry east", {44, 0, 0});
  const GroupId conductors = model.group(bay, "Conductors");
  for (std::uint32_t phase = 0; phase < 3; ++phase) {
    const double pz = 3.0 + 3 * phase;
    Parts wire;
    for (std::uint32_t i = 0; i < 8; ++i) {
      // A parabola is near enough to a catenary.
      const auto sag = [](double t) { return 9.1 - 1.6 * 4 * t * (1 - t); };
      const double t0 = i / 8.0;
      const double t1 = (i + 1) / 8.0;
      wire.push_back(tube({44 * t0, sag(t0), pz}, {44 * t1, sag(t1), pz}, 0.035));
    }
    model.leaf(conductors, named("Phase", phase + 1), plant.paint.copper, std::move(wire));
  }
  const char* const kDevices[] = {"Disconnector", "Circuit breaker", "Current transformer", "Earthing switch",
                                  "Surge arrester"};
  for (std::uint32_t d = 0; d < 5; ++d) {
    const GroupId device = model.group(bay, kDevices[d], at(6.0 + 8 * d, 0, 0));
    const Vec3 phase(0, 0, 3);
    model.leaf(device, "Supports", plant.paint.galvanized,
               {repeated(bar({0, 0, 3}, {0, 2.4, 3}, 0.25), 3, phase),
                repeated(blockOn({0, 2.4, 3}, {1.2, 0.15, 0.4}), 3, phase),
                repeated(blockOn({0, 0, 3}, {0.7, 0.2, 0.7}), 3, phase)});
    for (std::uint32_t i = 0; i < 3; ++i) {
      Parts post = {insulator({0, 2.55, 0}, 1.9, 0.2)};
      if (d % 2 == 0) post = {insulator({-0.45, 2.55, 0}, 1.7, 0.16), insulator({0.45, 2.55, 0}, 1.7, 0.16)};
      model.leaf(device, named("Insulators", i + 1), d == 2 ? plant.paint.machine : plant.paint.porcelain,
                 std::move(post), at(0, 0, 3.0 + 3 * i));
    }
    model.leaf(device, "Drive", plant.paint.cabinet, {blockOn({0.9, 0, 6}, {0.6, 1.7, 0.8})});
  }
}

void addControlBuilding(Plant& plant, GroupId area) {
  Model& model = plant.model;
  const GroupId building = model.group(area, "Relay building", at(120, 0, -23));
  model.leaf(building, "Walls", plant.paint.brick, {box({0, 0, 0}, {14, 4.2, 34})});
  model.leaf(building, "Roof", plant.paint.concrete, {box({-0.5, 4.2, -0.5}, {14.5, 4.6, 34.5})});
  model.leaf(building, "Windows", plant.paint.glass,
             {repeated(box({-0.05, 1.4, 2}, {0.1, 2.8, 4}), 8, {0, 0, 4})});
  model.leaf(building, "Doors", plant.paint.claddingBlue,
             {repeated(box({-0.08, 0, 0.4}, {0.1, 2.2, 1.5}), 3, {0, 0, 16})});
  model.leaf(building, "Air handling", plant.paint.aluminium,
             {repeated(box({4, 4.6, 4}, {7, 6, 7}), 4, {0, 0, 7.5})});
  addCabinets(plant, building, at({-1.5, 0, 8}, turnY(-kPi / 2)), 8);
}

}  // namespace

void addSwitchyard(Plant& plant, GroupId root) {
  const GroupId area = plant.model.group(root, "Switchyard");
  const GroupId transformers = plant.model.group(area, "Transformers");
  for (std::uint32_t i = 0; i < 4; ++i)
    addTransformer(plant, transformers, i + 1, {36.5, 0, -20 + 9.5 * i});
  const GroupId yard = plant.model.group(area, "Yard", at(60, 0, -24));
  plant.model.leaf(yard, "Gravel", plant.paint.gravel, {box({-6, 0, -2}, {52, 0.1, 38})});
  for (std::uint32_t i = 0; i < 3; ++i)
    addBay(plant, yard, i + 1, 12.0 * i);
  addControlBuilding(plant, area);
}

}  // namespace tessera::synthetic
