#include <string>

#include "common/scene/synthetic/palace.h"

namespace tessera::synthetic {
namespace {

std::string named(const char* what, std::size_t number) {
  return what + (' ' + std::to_string(number));
}

void addPrayerHall(Palace& palace, GroupId mosque) {
  Model& model = palace.model;
  const GroupId hall = model.group(mosque, "Prayer hall", at(-52, 1, 0));
  model.leaf(hall, "Plinth", palace.stone.redDark, {box({-10, -1, -34}, {9, 0.4, 34})});
  model.leaf(hall, "Back wall", palace.stone.redDark, {box({-10, 0.4, -34}, {-9, 11, 34})});
  model.leaf(hall, "Roof", palace.stone.paving, {box({-10, 10.5, -34}, {8, 11, 34})});
  model.leaf(hall, "Columns", palace.stone.red, columnGrid(4, 15, 4.4, 9.8));
  // The great portal (iwan) and its flanks face the court, +x.
  const ArchBay portal{
      .widthM = 16, .heightM = 19, .depthM = 3, .openingWidthM = 9.5, .springM = 8, .riseM = 7};
  model.leaf(hall, "Portal", palace.stone.red,
             {Part{.shape = portal, .placement = at({9, 0.4, 0}, turnY(kPi / 2)), .repeat = {}}});
  const ArchBay flank{
      .widthM = 5.2, .heightM = 10.6, .depthM = 1, .openingWidthM = 3.8, .springM = 5, .riseM = 3};
  for (const bool south : {false, true}) {
    model.leaf(hall, south ? "South flank" : "North flank", palace.stone.red,
               {exactly(repeated(Part{.shape = flank,
                                      .placement = at({9, 0.4, south ? 10.6 : -31.4}, turnY(kPi / 2)),
                                      .repeat = {}},
                                 5, {0, 0, 5.2}))});
    Part merlons = battlements(26, 1.1);
    merlons.placement = at({0, 0, 0}, turnY(-kPi / 2));
    merlons.repeat.stepM = {0, 0, merlons.repeat.stepM.x()};
    merlons.placement.positionM = {9, 11, south ? 8.2 : -33.8};
    model.leaf(hall, south ? "South battlements" : "North battlements", palace.stone.redLight, {merlons});
  }
  const GroupId domes = model.group(hall, "Domes", at(0, 11, 0));
  for (std::uint32_t i = 0; i < 3; ++i) {
    const GroupId dome = model.group(domes, named("Dome", i + 1), at(i == 1 ? -1 : 0, 0, -21 + 21.0 * i));
    const double r = i == 1 ? 6.5 : 4.6;
    model.leaf(dome, "Drum", palace.stone.red,
               {turned({0, 0, 0}, polyline({{r * 1.15, 0}, {r * 1.15, 1.6}, {r, 2.2}, {r * 0.9, 2.2}}))});
    Parts shell = pointedDome(r);
    for (Part& part : shell)
      part.placement.positionM.y() += 2.1;
    model.leaf(dome, "Shell", i == 1 ? palace.stone.marble : palace.stone.redLight, std::move(shell));
  }
  for (std::uint32_t i = 0; i < 4; ++i) {
    addChhatri(palace, hall, named("Roof kiosk", i + 1), at(6, 11, -31 + 20.66 * i), 1.3);
  }
}

}  // namespace

void addMosque(Palace& palace, GroupId root) {
  Model& model = palace.model;
  const GroupId mosque = model.group(root, "Great mosque", at(-130, 0, 40));
  model.leaf(mosque, "Court", palace.stone.paving, {box({-62, 0, -48}, {52, 1, 48})});
  model.leaf(mosque, "Paving joints", palace.stone.redDark,
             {exactly(repeated(box({-40, 1, -44}, {-39.9, 1.01, 44}), 30, {3, 0, 0})),
              exactly(repeated(box({-40, 1, -44}, {47, 1.012, -43.9}), 30, {0, 0, 3}))});
  addPrayerHall(palace, mosque);
  addArcade(palace, mosque, {.name = "North arcade", .placement = at(-42, 1, -41), .bays = 22, .bayM = 4.1});
  addArcade(palace, mosque,
            {.name = "South arcade west", .placement = at({-5, 1, 41}, turnY(kPi)), .bays = 9, .bayM = 4.1});
  addArcade(palace, mosque,
            {.name = "South arcade east", .placement = at({48, 1, 41}, turnY(kPi)), .bays = 8, .bayM = 4.1});
  addArcade(palace, mosque,
            {.name = "East arcade", .placement = at({46, 1, -41}, turnY(-kPi / 2)), .bays = 20, .bayM = 4.1});
  for (std::uint32_t i = 0; i < 4; ++i) {
    addChhatri(palace, mosque, named("Corner kiosk", i + 1),
               at(i % 2 == 0 ? -40 : 48, 7.4, i < 2 ? -43.5 : 43.5), 1.8);
  }
}

void addGreatGate(Palace& palace, GroupId root) {
  Model& model = palace.model;
  const GroupId gate = model.group(root, "Great gate", at(-127, 0, 92));
  model.leaf(gate, "Terrace", palace.stone.redDark, {box({-24, 0, -8}, {24, 8, 8})});
  model.leaf(gate, "Stairs", palace.stone.redLight,
             {Part{.shape = Stairs{.widthM = 46, .stepCount = 42, .riseM = 8.0 / 42, .goingM = 0.36},
                   .placement = at({0, 0, 8 + 42 * 0.36}, turnY(kPi / 2)),
                   .repeat = {}}});
  const ArchBay great{
      .widthM = 28, .heightM = 38, .depthM = 8, .openingWidthM = 16, .springM = 17, .riseM = 11};
  model.leaf(gate, "Portal", palace.stone.red,
             {Part{.shape = great, .placement = at(0, 8, 0), .repeat = {}}});
  const ArchBay inner{
      .widthM = 16.2, .heightM = 30, .depthM = 1, .openingWidthM = 5, .springM = 6, .riseM = 4};
  model.leaf(gate, "Inner screen", palace.stone.redLight,
             {Part{.shape = inner, .placement = at(0, 8, -2.5), .repeat = {}}});
  model.leaf(gate, "Inlay", palace.stone.marble,
             {box({-13.2, 9, 4.0}, {-12.4, 43.6, 4.1}), box({12.4, 9, 4.0}, {13.2, 43.6, 4.1}),
              box({-12.4, 42.8, 4.0}, {12.4, 43.6, 4.1}), box({-9.4, 9, 4.0}, {-9.0, 40.5, 4.1}),
              box({9.0, 9, 4.0}, {9.4, 40.5, 4.1}), box({-9.0, 40.1, 4.0}, {9.0, 40.5, 4.1})});
  for (const bool east : {false, true}) {
    const double side = east ? 1 : -1;
    const GroupId wing =
        model.group(gate, east ? "East wing" : "West wing", at({side * 18.2, 8, -1}, turnY(side * kPi / 5)));
    for (std::uint32_t storey = 0; storey < 3; ++storey) {
      const ArchBay window{
          .widthM = 9.5, .heightM = 11, .depthM = 5, .openingWidthM = 4.6, .springM = 4.5, .riseM = 3.4};
      model.leaf(wing, named("Storey", storey + 1), palace.stone.red,
                 {Part{.shape = window, .placement = at(0, 11.0 * storey, 0), .repeat = {}}});
    }
    model.leaf(wing, "Back", palace.stone.redDark, {box({-4.7, 0, -3.2}, {4.7, 33, -2.5})});
    Part merlons = battlements(9.5, 1.3);
    merlons.placement.positionM += Vec3(-4.75, 33, 2.2);
    model.leaf(wing, "Battlements", palace.stone.redLight, {merlons});
  }
  const GroupId roof = model.group(gate, "Roof", at(0, 46, 0));
  Part merlons = battlements(28, 1.5);
  merlons.placement.positionM += Vec3(-14, 0, 3.6);
  model.leaf(roof, "Battlements", palace.stone.redLight, {merlons});
  model.leaf(roof, "Deck", palace.stone.paving, {box({-14, 0, -4}, {14, 0.1, 3.4})});
  for (std::uint32_t i = 0; i < 7; ++i)
    addChhatri(palace, roof, named("Kiosk", i + 1), at(-12 + 4.0 * i, 0.1, -1), i == 3 ? 1.5 : 1.2);
}

void addTomb(Palace& palace, GroupId root) {
  Model& model = palace.model;
  const GroupId tomb = model.group(root, "Marble tomb", at(-118, 1, 12));
  model.leaf(tomb, "Platform", palace.stone.marble, {blockOn({0, 0, 0}, {16, 0.9, 16})});
  model.leaf(tomb, "Chamber", palace.stone.marble, {blockOn({0, 0.9, 0}, {7, 4.6, 7})});
  const GroupId screens = model.group(tomb, "Screens", at(0, 0.9, 0));
  for (std::uint32_t side = 0; side < 4; ++side) {
    const GroupId wall = model.group(screens, named("Side", side + 1), at({0, 0, 0}, turnY(kPi / 2 * side)));
    model.leaf(
        wall, "Jali", palace.stone.marble,
        {exactly(repeated(Part{.shape = Jali{.cellM = 0.34, .columns = 7, .rows = 8, .thicknessM = 0.07},
                               .placement = at(-6.2, 0.6, 6),
                               .repeat = {}},
                          4, {3.3, 0, 0}))});
    Parts posts;
    for (Part part : carvedColumn(3.9, 0.17)) {
      if (part.repeat.count != 1) continue;
      part.placement.positionM += Vec3(-6.5, 0, 6);
      posts.push_back(exactly(repeated(std::move(part), 4, {3.3, 0, 0})));
    }
    model.leaf(wall, "Columns", palace.stone.marble, std::move(posts));
    model.leaf(wall, "Brackets", palace.stone.marble,
               {repeated(prism({{0, -1.1}, {1.4, 0}, {0, 0}}, 0.16, at({-6.42, 3.9, 6.1}, turnY(-kPi / 2))),
                         4, {3.3, 0, 0})});
  }
  model.leaf(tomb, "Eave", palace.stone.marble, {[] {
               Part slab = eave({13, 13}, 1.6);
               slab.placement = at(0, 5, 0);
               return slab;
             }()});
  Parts dome = pointedDome(3.4);
  for (Part& part : dome)
    part.placement.positionM.y() += 5.5;
  model.leaf(tomb, "Dome", palace.stone.marble, std::move(dome));
}

}  // namespace tessera::synthetic
