#include <string>

#include "common/scene/synthetic/plant.h"

namespace tessera::synthetic {
namespace {

std::string named(const char* what, std::size_t number) {
  return what + (' ' + std::to_string(number));
}

void addChimney(Plant& plant, GroupId area) {
  constexpr double kHeightM = 80;
  constexpr double kFootM = 4.4;
  constexpr double kTopM = 2.7;
  constexpr std::uint32_t kBands = 10;
  Model& model = plant.model;
  const auto radius = [](double y) { return kFootM + (kTopM - kFootM) * y / kHeightM; };
  const GroupId chimney = model.group(area, "Chimney", at(-72, 0, -60));
  const GroupId shaft = model.group(chimney, "Shaft");
  model.leaf(shaft, "Base", plant.paint.concreteDark,
             {turned({0, 0, 0}, polyline({{6.2, 0}, {6.2, 2}, {4.9, 3.2}, {4.2, 3.2}}))});
  for (std::uint32_t i = 0; i < kBands; ++i) {
    // The lower half stays plain; aviation bands above.
    const double y0 = kHeightM * i / kBands;
    const double y1 = kHeightM * (i + 1) / kBands;
    const std::uint32_t paint = i < 4        ? plant.paint.concrete
                                : i % 2 == 1 ? plant.paint.red
                                             : plant.paint.white;
    model.leaf(shaft, named("Band", i + 1), paint,
               {turned({0, 0, 0}, {line({radius(y0), 0}, {radius(y1), y1 - y0})})}, at(0, y0, 0));
  }
  model.leaf(shaft, "Crown", plant.paint.steelDark,
             {turned({0, kHeightM - 0.6, 0}, polyline({{kTopM, 0},
                                                       {kTopM + 0.4, 0.3},
                                                       {kTopM + 0.4, 0.6},
                                                       {kTopM - 0.4, 0.6},
                                                       {kTopM - 0.4, -5},
                                                       {0, -5}}))});
  const GroupId access = model.group(chimney, "Access");
  for (std::uint32_t i = 0; i < 3; ++i) {
    const double y = 30.0 + 23 * i;
    const GroupId gallery = model.group(access, named("Gallery", i + 1), at(0, y, 0));
    const double inner = radius(y) - 0.1;
    model.leaf(
        gallery, "Deck", plant.paint.grating,
        {turned({0, 0, 0}, polyline({{inner, -0.12}, {inner + 1.5, -0.12}, {inner + 1.5, 0}, {inner, 0}}))});
    model.leaf(gallery, "Railing", plant.paint.railing, roundRailing(inner + 1.4, 0));
    model.leaf(gallery, "Lights", plant.paint.red,
               {around(rod({inner + 1.5, 0.2, 0}, {inner + 1.5, 0.9, 0}, 0.2), 4)});
  }
  for (std::uint32_t i = 0; i < 4; ++i) {
    const double y0 = 3.2 + 19 * i;
    const Vec3 low(0, y0, radius(y0) + 0.2);
    const Vec3 high(0, y0 + 18.5, radius(y0 + 18.5) + 0.2);
    model.leaf(access, named("Ladder", i + 1), plant.paint.galvanized, cagedLadder(18),
               at(low, fromAxes(Vec3::UnitX(), (high - low).normalized())));
  }
}

void addPrecipitator(Plant& plant, GroupId area, std::uint32_t number, const Vec3& where) {
  Model& model = plant.model;
  constexpr double kX = 22;
  constexpr double kZ = 11;
  const GroupId unit = model.group(area, named("Precipitator", number), at(where));
  const GroupId casing = model.group(unit, "Casing");
  model.leaf(casing, "Box", plant.paint.claddingLight, {box({0, 9, 0}, {kX, 20, kZ})});
  model.leaf(casing, "Stiffeners", plant.paint.steel,
             {repeated(box({0.8, 9, -0.25}, {1.1, 20, kZ + 0.25}), 8, {2.9, 0, 0}),
              box({-0.25, 12.5, -0.3}, {kX + 0.25, 12.9, kZ + 0.3}),
              box({-0.25, 16.5, -0.3}, {kX + 0.25, 16.9, kZ + 0.3})});
  model.leaf(casing, "Inlet hood", plant.paint.claddingDark,
             {prism({{0, 9.5}, {0, 19.5}, {-4, 16.5}, {-4, 12.5}}, kZ - 1, at(0, 0, 0.5))});
  Part outlet = prism({{kX, 9.5}, {kX + 4, 12.5}, {kX + 4, 16.5}, {kX, 19.5}}, kZ - 1, at(0, 0, 0.5));
  model.leaf(casing, "Outlet hood", plant.paint.claddingDark, {outlet});
  const GroupId hoppers = model.group(unit, "Hoppers");
  for (std::uint32_t i = 0; i < 4; ++i) {
    for (std::uint32_t k = 0; k < 2; ++k) {
      model.leaf(hoppers, named("Hopper", 2 * i + k + 1), plant.paint.claddingDark,
                 {prism({{-0.4, 4.5}, {0.4, 4.5}, {2.7, 9}, {-2.7, 9}}, 5.2, at(0, 0, -2.6)),
                  tube({0, 3.6, 0}, {0, 4.6, 0}, 0.3)},
                 at(2.75 + 5.5 * i, 0, 2.75 + 5.5 * k));
    }
  }
  const GroupId legs = model.group(unit, "Legs");
  for (std::uint32_t i = 0; i < 5; ++i) {
    model.leaf(legs, named("Bent", i + 1), plant.paint.steel,
               {beam({0, 0, 0.2}, {0, 9, 0.2}, 0.5, 0.5), beam({0, 0, kZ - 0.2}, {0, 9, kZ - 0.2}, 0.5, 0.5),
                beam({0, 0.5, 0.2}, {0, 8.5, kZ - 0.2}, 0.25, 0.25)},
               at(5.5 * i, 0, 0));
  }
  const GroupId roof = model.group(unit, "Roof", at(0, 20, 0));
  for (std::uint32_t i = 0; i < 6; ++i) {
    model.leaf(roof, named("Rectifier", i + 1), plant.paint.machine,
               {blockOn({0, 0.1, 0}, {1.6, 1.5, 1.2}), rod({0, 1.6, 0}, {0, 2.3, 0}, 0.15),
                repeated(box({-0.7, 0.3, 0.6}, {-0.64, 1.3, 0.8}), 8, {0.19, 0, 0})},
               at(2 + 3.5 * i, 0, 3 + 5.0 * (i % 2)));
  }
  model.leaf(roof, "Railing", plant.paint.railing,
             joined({railing({0, 0, 0}, {kX, 0, 0}), railing({0, 0, kZ}, {kX, 0, kZ}),
                     railing({0, 0, 0}, {0, 0, kZ}), railing({kX, 0, 0}, {kX, 0, kZ})}));
  addPlatform(plant, unit, "Hopper gallery", at(-0.5, 4, -1.4),
              {.sizeM = {kX + 1, 1.2}, .north = true, .south = false});
  model.leaf(unit, "Ladder", plant.paint.galvanized, cagedLadder(19.5), at({kX / 2, 0, kZ + 0.4}));
}

/// A duct of square section between two points on one axis.
void addDuct(Plant& plant, GroupId ducts, const std::string& name, const Vec3& from, const Vec3& to,
             double widthM) {
  Parts parts = {bar(from, to, widthM)};
  std::get<Extrusion>(parts.front().shape).capped = true;
  const double lengthM = (to - from).norm();
  const Vec3 along = (to - from) / lengthM;
  const auto ribs = static_cast<std::uint32_t>(lengthM / 1.8);
  if (ribs > 1)
    parts.push_back(repeated(bar(from + along * 0.8, from + along * 1.0, widthM + 0.25), ribs, along * 1.8));
  plant.model.leaf(ducts, name, plant.paint.claddingDark, std::move(parts));
}

void addFan(Plant& plant, GroupId area, std::uint32_t number, const Vec3& where) {
  Model& model = plant.model;
  const GroupId fan = model.group(area, named("Induced draught fan", number), at(where));
  model.leaf(fan, "Foundation", plant.paint.concrete, {box({-2.5, 0, -2.2}, {6.5, 1, 2.2})});
  model.leaf(fan, "Volute", plant.paint.machine,
             {rod({-1.1, 3.4, 0}, {1.1, 3.4, 0}, 2.2), box({-1.1, 3.4, 0.2}, {1.1, 6.6, 2.2})});
  model.leaf(fan, "Inlet box", plant.paint.claddingDark, {rod({1.1, 3.4, 0}, {1.9, 3.4, 0}, 1.3)});
  model.leaf(fan, "Shaft", plant.paint.steelDark,
             {rod({1.9, 3.4, 0}, {3.6, 3.4, 0}, 0.2), box({2.4, 1, -0.4}, {2.9, 3.2, 0.4})});
  model.leaf(fan, "Motor", plant.paint.machineBlue,
             {vessel({3.8, 3.2, 0}, {5.8, 3.2, 0}, 1, 0.3), box({3.9, 1, -0.9}, {5.7, 2.4, 0.9})});
}

}  // namespace

void addFlueGas(Plant& plant, GroupId root) {
  const GroupId area = plant.model.group(root, "Flue gas treatment");
  addChimney(plant, area);
  addPrecipitator(plant, area, 1, {-57, 0, -76});
  addPrecipitator(plant, area, 2, {-57, 0, -60});
  const GroupId ducts = plant.model.group(area, "Ducts");
  addDuct(plant, ducts, "Boiler outlet", {-12, 38, -54}, {-27, 38, -54}, 5);
  addDuct(plant, ducts, "Downcomer", {-27, 40.5, -54}, {-27, 14.5, -54}, 5);
  addDuct(plant, ducts, "Header", {-27, 14.5, -51.5}, {-27, 14.5, -75}, 4.5);
  addDuct(plant, ducts, "Inlet 1", {-29, 14.5, -70.5}, {-31, 14.5, -70.5}, 4);
  addDuct(plant, ducts, "Inlet 2", {-29, 14.5, -54.5}, {-31, 14.5, -54.5}, 4);
  addDuct(plant, ducts, "Outlet header", {-63, 14.5, -77}, {-63, 14.5, -47}, 4);
  addDuct(plant, ducts, "Chimney duct", {-65, 11, -60}, {-69, 11, -60}, 4);
  addDuct(plant, ducts, "Drop 1", {-63, 14.5, -48}, {-63, 5, -48}, 2.2);
  addDuct(plant, ducts, "Drop 2", {-63, 14.5, -74}, {-63, 5, -74}, 2.2);
  addFan(plant, area, 1, {-63, 0, -44});
  addFan(plant, area, 2, {-63, 0, -81});
  addCabinets(plant, area, at(-52, 0, -43), 6);
  for (std::uint32_t i = 0; i < 4; ++i) {
    addPipeRun(plant, area,
               {.name = named("Ash line", i + 1),
                .material = plant.paint.rust,
                .radiusM = 0.13,
                .path = {{-55.0 + 5.5 * i, 3.5, -73.2},
                         {-55.0 + 5.5 * i, 2.2 + 0.0 * i, -73.2},
                         {-55.0 + 5.5 * i, 2.2, -45.5 - 0.8 * i},
                         {-38, 2.2, -45.5 - 0.8 * i}},
                .spoolM = 12});
  }
}

}  // namespace tessera::synthetic
