#include <string>

#include "common/scene/synthetic/palace.h"

namespace tessera::synthetic {
namespace {

std::string named(const char* what, std::size_t number) {
  return what + (' ' + std::to_string(number));
}

/// A walled residence around a court: four ranges, corner blocks with domes, tiled roofs.
void addQueensPalace(Palace& palace, GroupId parent) {
  Model& model = palace.model;
  const GroupId house = model.group(parent, "Queen's palace", at(-56, 0, -24));
  model.leaf(house, "Court", palace.stone.paving, {blockOn({0, 0, 0}, {56, 0.5, 56})});
  addArcade(palace, house,
            {.name = "North range", .placement = at(-20, 0.5, -20), .bays = 10, .bayM = 4, .depthM = 7});
  addArcade(palace, house,
            {.name = "South range",
             .placement = at({20, 0.5, 20}, turnY(kPi)),
             .bays = 10,
             .bayM = 4,
             .depthM = 7});
  addArcade(palace, house,
            {.name = "East range",
             .placement = at({20, 0.5, -20}, turnY(-kPi / 2)),
             .bays = 10,
             .bayM = 4,
             .depthM = 7});
  addArcade(palace, house,
            {.name = "West range",
             .placement = at({-20, 0.5, 20}, turnY(kPi / 2)),
             .bays = 10,
             .bayM = 4,
             .depthM = 7});
  for (std::uint32_t i = 0; i < 4; ++i) {
    const GroupId corner =
        model.group(house, named("Corner", i + 1), at(i % 2 == 0 ? -24 : 24, 0.5, i < 2 ? -24 : 24));
    model.leaf(corner, "Block", palace.stone.red, {blockOn({0, 0, 0}, {8.4, 9, 8.4})});
    model.leaf(corner, "Eave", palace.stone.redDark, {[] {
                 Part slab = eave({8.4, 8.4}, 1);
                 slab.placement = at(0, 8.8, 0);
                 return slab;
               }()});
    Parts dome = pointedDome(3.2);
    for (Part& part : dome)
      part.placement.positionM.y() += 9;
    model.leaf(corner, "Dome", palace.stone.redLight, std::move(dome));
  }
  for (const bool south : {false, true}) {
    const GroupId upper =
        model.group(house, south ? "South upper hall" : "North upper hall", at(0, 6.9, south ? 23.5 : -23.5));
    const ArchBay bay{
        .widthM = 4, .heightM = 4, .depthM = 0.6, .openingWidthM = 2.4, .springM = 1.8, .riseM = 1.1};
    for (const double side : {-1.0, 1.0}) {
      model.leaf(upper, side < 0 ? "North wall" : "South wall", palace.stone.red,
                 {exactly(repeated(Part{.shape = bay, .placement = at(-6, 0, side * 2.8), .repeat = {}}, 4,
                                   {4, 0, 0}))});
    }
    model.leaf(upper, "Roof", palace.stone.glazed,
               {prism({{-3.6, 0}, {3.6, 0}, {0, 2.6}}, 17.4, at({-8.7, 4, 0}, turnY(kPi / 2))),
                repeated(tube({-8.5, 4.04, 3.6}, {-8.5, 6.64, 0}, 0.09), 40, {0.44, 0, 0}),
                repeated(tube({-8.5, 4.04, -3.6}, {-8.5, 6.64, 0}, 0.09), 40, {0.44, 0, 0})});
    model.leaf(upper, "Finials", palace.stone.gilt,
               {repeated(turned({-8, 6.6, 0},
                                {arc({0, 0.3}, {0.2, 0.3}, -kPi / 2, kPi / 2), line({0.06, 0.6}, {0, 1.3})}),
                         5, {4, 0, 0})});
  }
  model.leaf(house, "Basil altar", palace.stone.marble,
             {blockOn({0, 0.5, 0}, {2.4, 1.2, 2.4}), blockOn({0, 1.7, 0}, {1.4, 0.8, 1.4})});
}

/// A small two-storey house with two domes.
void addHouse(Palace& palace, GroupId parent, const std::string& name, const Placement& placement,
              std::uint32_t domes) {
  Model& model = palace.model;
  const GroupId house = model.group(parent, name, placement);
  model.leaf(house, "Plinth", palace.stone.redDark, {blockOn({0, 0, 0}, {20, 0.9, 20})});
  for (std::uint32_t side = 0; side < 4; ++side) {
    const ArchBay bay{
        .widthM = 5.3, .heightM = 5, .depthM = 0.8, .openingWidthM = 2.2, .springM = 2.2, .riseM = 1.2};
    model.leaf(house, named("Wall", side + 1), palace.stone.red,
               {exactly(repeated(Part{.shape = bay, .placement = at(-5.3, 0.9, 7.5), .repeat = {}}, 3,
                                 {5.3, 0, 0}))},
               at({0, 0, 0}, turnY(kPi / 2 * side)));
  }
  model.leaf(house, "Eave", palace.stone.redDark, {[] {
               Part slab = eave({16, 16}, 1.4);
               slab.placement = at(0, 6.1, 0);
               return slab;
             }()});
  const GroupId upper = model.group(house, "Upper rooms", at(0, 6.1, 0));
  for (std::uint32_t i = 0; i < domes; ++i) {
    const GroupId room =
        model.group(upper, named("Room", i + 1), at(i % 2 == 0 ? -4.4 : 4.4, 0, i % 2 == 0 ? -4.4 : 4.4));
    model.leaf(room, "Walls", palace.stone.red, {blockOn({0, 0, 0}, {6.6, 4, 6.6})});
    model.leaf(room, "Eave", palace.stone.redDark, {[] {
                 Part slab = eave({6.6, 6.6}, 0.9);
                 slab.placement = at(0, 3.9, 0);
                 return slab;
               }()});
    Parts dome = pointedDome(2.9);
    for (Part& part : dome)
      part.placement.positionM.y() += 4;
    model.leaf(room, "Dome", palace.stone.plaster, std::move(dome));
  }
  Part screen{.shape = Jali{.cellM = 0.28, .columns = 10, .rows = 5, .thicknessM = 0.07},
              .placement = at(2, 0, 7.2),
              .repeat = {}};
  model.leaf(upper, "Screen", palace.stone.redLight, {screen});
}

}  // namespace

void addResidences(Palace& palace, GroupId root) {
  const GroupId residences = palace.model.group(root, "Residences");
  palace.model.leaf(residences, "Great court", palace.stone.paving, {box({-28, 0, -98}, {73, 0.08, 62})});
  addQueensPalace(palace, residences);
  addArcade(palace, residences,
            {.name = "Long cloister", .placement = at({72, 0.08, 64}, turnY(kPi)), .bays = 22, .bayM = 4.5});
  addHouse(palace, residences, "House of the minister", at(-104, 0, -56), 2);
  addHouse(palace, residences, "Golden house", at(-24, 0, -72), 2);
  addHouse(palace, residences, "House of the doctor", at(62, 0, 14), 2);
  addHouse(palace, residences, "Guest house", at(6, 0, 36), 2);
}

void addMinar(Palace& palace, GroupId root) {
  Model& model = palace.model;
  const GroupId minar = model.group(root, "Elephant tower", at(-60, 0, -104));
  model.leaf(minar, "Base", palace.stone.redDark,
             {blockOn({0, 0, 0}, {22, 1.2, 22}), rod({0, 1.2, 0}, {0, 4.2, 0}, 6)});
  model.leaf(minar, "Shaft", palace.stone.red,
             {turned({0, 4.2, 0}, polyline({{3.6, 0}, {3.2, 8}, {3.4, 8.2}, {2.9, 16}}))});
  Parts tusks;
  for (std::uint32_t i = 0; i < 14; ++i) {
    // Staggered rows of stone tusks.
    const double y = 5.2 + i;
    const double radiusM = 3.45 - 0.04 * i;
    const Vec3 out = onCircle(1, (i % 2) * kPi / 16);
    tusks.push_back(around(turned(out * radiusM + Vec3(0, y, 0),
                                  {line({0.12, 0}, {0.09, 0.4}), line({0.09, 0.4}, {0, 0.8})}, out),
                           16));
  }
  model.leaf(minar, "Tusks", palace.stone.marble, std::move(tusks));
  model.leaf(minar, "Gallery", palace.stone.redLight,
             {turned({0, 20.2, 0}, polyline({{2.9, -0.8}, {4.2, 0}, {4.2, 0.3}, {0, 0.3}})),
              around(box({3.9, 20.5, -0.08}, {4.1, 21.4, 0.08}), 32)});
  addChhatri(palace, minar, "Lantern", at(0, 20.5, 0), 2.2);
}

void addCityWall(Palace& palace, GroupId root) {
  constexpr double kSectionM = 30;
  constexpr double kHeightM = 7;
  Model& model = palace.model;
  const GroupId walls = model.group(root, "City wall");
  const auto side = [&](const char* name, const Vec3& start, double turnRad, std::uint32_t sections) {
    const GroupId group = model.group(walls, name, at(start, turnY(turnRad)));
    for (std::uint32_t i = 0; i < sections; ++i) {
      const GroupId section = model.group(group, named("Section", i + 1), at(kSectionM * i, 0, 0));
      model.leaf(section, "Curtain", palace.stone.redDark,
                 {box({0, 0, -0.8}, {kSectionM, kHeightM, 0.8}),
                  box({0, kHeightM - 1.5, 0.8}, {kSectionM, kHeightM - 1.2, 2.2})});
      Part merlons = battlements(kSectionM, 1.5);
      merlons.placement.positionM += Vec3(0, kHeightM, -0.6);
      model.leaf(section, "Battlements", palace.stone.redDark, {merlons});
      model.leaf(section, "Bastion", palace.stone.red,
                 {turned({0, 0, 0}, polyline({{3.4, 0},
                                              {2.8, kHeightM + 1.5},
                                              {3.1, kHeightM + 1.5},
                                              {3.1, kHeightM + 2.3},
                                              {2.5, kHeightM + 2.3},
                                              {2.5, kHeightM + 1.2},
                                              {0, kHeightM + 1.2}}))});
    }
  };
  side("North wall", {-210, 0, -130}, 0, 13);
  side("East wall", {180, 0, -130}, -kPi / 2, 8);
  side("West wall", {-210, 0, 110}, kPi / 2, 8);
  side("South wall", {180, 0, 110}, kPi, 9);
  side("South wall by the gate", {-150, 0, 110}, kPi, 2);
}

void addGarden(Palace& palace, GroupId root, std::uint32_t leafCount) {
  constexpr std::uint32_t kPerBed = 4;
  Model& model = palace.model;
  const GroupId garden = model.group(root, "Garden", at(96, 0, 20));
  model.leaf(garden, "Lawn", palace.stone.lawn, {box({0, 0, 0}, {44, 0.2, 14})});
  GroupId bed = garden;
  for (std::uint32_t i = 0; i + 1 < leafCount; ++i) {
    // A last bed of one plant would be a group with one child.
    if (i % kPerBed == 0 && i + 2 < leafCount) {
      const std::uint32_t number = i / kPerBed;
      const std::uint32_t row = number / 3;
      bed = model.group(garden, named("Bed", number + 1), at(5 + 14.0 * (number % 3), 0.2, 4.5 + 14.0 * row));
    }
    const double r = palace.random.between(1.2, 2);
    const std::uint32_t back = i % kPerBed / 2;
    const Placement where = at(4.5 * (i % 2), 0, 4.5 * back);
    if (palace.random.chance(0.4)) {
      model.leaf(bed, "Cypress", palace.stone.foliage,
                 {turned({0, 0.3, 0}, {arc({0, 3.6}, {r * 0.7, 3.6}, -kPi / 2, kPi / 2)}),
                  tube({0, 0, 0}, {0, 0.7, 0}, 0.12)},
                 where);
    } else {
      model.leaf(bed, "Shrub", palace.stone.foliage,
                 {turned({0, 0, 0}, {arc({0, r * 0.7}, {r, r * 0.75}, -kPi / 2, kPi / 2)})}, where);
    }
  }
}

}  // namespace tessera::synthetic
