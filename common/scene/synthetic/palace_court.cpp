#include <string>

#include "common/scene/synthetic/palace.h"

namespace tessera::synthetic {
namespace {

std::string named(const char* what, std::size_t number) {
  return what + (' ' + std::to_string(number));
}

/// A balustrade of turned balusters around a rectangle centred on the origin.
Parts balustrade(const Vec2& sizeM, double y) {
  const double x = sizeM.x() / 2;
  const double z = sizeM.y() / 2;
  Parts parts = {
      box({-x, y + 0.8, -z}, {x, y + 0.95, -z + 0.2}), box({-x, y + 0.8, z - 0.2}, {x, y + 0.95, z}),
      box({-x, y + 0.8, -z}, {-x + 0.2, y + 0.95, z}), box({x - 0.2, y + 0.8, -z}, {x, y + 0.95, z})};
  const std::vector<Curve> profile = {arc({0.05, 0.2}, {0.06, 0.2}, -kPi / 2, kPi / 2),
                                      arc({0.05, 0.6}, {0.06, 0.2}, -kPi / 2, kPi / 2)};
  for (const double side : {-1.0, 1.0}) {
    const auto alongX = static_cast<std::uint32_t>(sizeM.x() / 0.35);
    const auto alongZ = static_cast<std::uint32_t>(sizeM.y() / 0.35);
    parts.push_back(repeated(turned({-x + 0.1, y, side * (z - 0.1)}, profile), alongX,
                             {(2 * x - 0.2) / (alongX - 1), 0, 0}));
    parts.push_back(repeated(turned({side * (x - 0.1), y, -z + 0.1}, profile), alongZ,
                             {0, 0, (2 * z - 0.2) / (alongZ - 1)}));
  }
  return parts;
}

Part moved(Part part, const Vec3& byM) {
  part.placement.positionM += byM;
  return part;
}

Parts moved(Parts parts, const Vec3& byM) {
  for (Part& part : parts)
    part.placement.positionM += byM;
  return parts;
}

void addDiwanIKhas(Palace& palace, GroupId halls) {
  Model& model = palace.model;
  const GroupId hall = model.group(halls, "Hall of private audience", at(34, 0, -78));
  const GroupId shell = model.group(hall, "Walls");
  for (std::uint32_t side = 0; side < 4; ++side) {
    const GroupId wall = model.group(shell, named("Side", side + 1), at({0, 0, 0}, turnY(kPi / 2 * side)));
    const ArchBay door{
        .widthM = 14, .heightM = 5.6, .depthM = 1.2, .openingWidthM = 2.6, .springM = 2.6, .riseM = 1.3};
    const ArchBay window{
        .widthM = 4.66, .heightM = 4.6, .depthM = 1.2, .openingWidthM = 1.8, .springM = 2.2, .riseM = 0.9};
    model.leaf(wall, "Ground floor", palace.stone.red,
               {Part{.shape = door, .placement = at(0, 0.6, 6.4), .repeat = {}}});
    model.leaf(wall, "Upper floor", palace.stone.red,
               {exactly(repeated(Part{.shape = window, .placement = at(-4.66, 6.2, 6.4), .repeat = {}}, 3,
                                 {4.66, 0, 0}))});
    model.leaf(wall, "Balcony", palace.stone.redLight,
               {box({-7.9, 6.0, 6.9}, {7.9, 6.25, 8.2}),
                repeated(prism({{0, -1}, {1.2, 0}, {0, 0}}, 0.25, at({-6.6, 6, 7}, turnY(-kPi / 2))), 12,
                         {1.2, 0, 0})});
  }
  model.leaf(hall, "Plinth", palace.stone.redDark, {blockOn({0, 0, 0}, {18, 0.6, 18})});
  model.leaf(hall, "Roof", palace.stone.paving, {blockOn({0, 10.8, 0}, {14.6, 0.5, 14.6})});
  model.leaf(hall, "Eave", palace.stone.redDark, {moved(eave({14, 14}, 1.7), {0, 11.1, 0})});
  model.leaf(hall, "Balustrade", palace.stone.redLight, balustrade({16, 16}, 6.25));
  const GroupId pillar = model.group(hall, "Central pillar");
  model.leaf(pillar, "Shaft", palace.stone.red, carvedColumn(4.2, 0.55));
  model.leaf(pillar, "Capital", palace.stone.redLight,
             {around(prism({{0.4, 3.2}, {2.0, 5.6}, {0.4, 5.6}}, 0.22, at(0, 0, -0.11)), 24),
              rod({0, 5.6, 0}, {0, 6, 0}, 2.2)});
  model.leaf(pillar, "Bridges", palace.stone.redLight,
             {exactly(around(box({1.5, 5.7, -0.6}, {8, 6, 0.6}), 4))});
  for (std::uint32_t i = 0; i < 4; ++i) {
    addChhatri(palace, hall, named("Kiosk", i + 1), at(i % 2 == 0 ? -5.6 : 5.6, 11.3, i < 2 ? -5.6 : 5.6),
               1.3);
  }
}

void addDiwanIAm(Palace& palace, GroupId halls) {
  Model& model = palace.model;
  const GroupId court = model.group(halls, "Court of public audience", at(110, 0, -62));
  model.leaf(court, "Lawn", palace.stone.lawn, {box({-36, 0, -40}, {36, 0.3, 40})});
  model.leaf(court, "Paths", palace.stone.paving,
             {box({-36, 0.3, -2.5}, {36, 0.4, 2.5}), box({-2.5, 0.3, -40}, {2.5, 0.41, 40})});
  addArcade(palace, court, {.name = "North arcade", .placement = at(-36, 0, -40), .bays = 18, .bayM = 4});
  addArcade(palace, court,
            {.name = "South arcade", .placement = at({36, 0, 40}, turnY(kPi)), .bays = 18, .bayM = 4});
  addArcade(palace, court,
            {.name = "East arcade", .placement = at({36, 0, -40}, turnY(-kPi / 2)), .bays = 20, .bayM = 4});
  addArcade(
      palace, court,
      {.name = "West arcade north", .placement = at({-36, 0, -7}, turnY(kPi / 2)), .bays = 8, .bayM = 4});
  addArcade(
      palace, court,
      {.name = "West arcade south", .placement = at({-36, 0, 40}, turnY(kPi / 2)), .bays = 8, .bayM = 4});
  const GroupId throne = model.group(court, "Throne pavilion", at(-38, 0, 0));
  model.leaf(throne, "Plinth", palace.stone.redDark, {blockOn({0, 0, 0}, {9, 2, 12})});
  model.leaf(throne, "Columns", palace.stone.red, moved(columnGrid(3, 4, 3.2, 5), {0, 2, 0}));
  model.leaf(throne, "Eave", palace.stone.redDark, {moved(eave({8, 11.5}, 1.5), {0, 7.1, 0})});
  model.leaf(throne, "Roof", palace.stone.redLight,
             {prism({{-4.5, 0}, {4.5, 0}, {0, 2.6}}, 11, at(0, 7.1, -5.5))});
  model.leaf(throne, "Screens", palace.stone.redLight,
             {exactly(repeated(Part{.shape = Jali{.cellM = 0.25, .columns = 8, .rows = 4, .thicknessM = 0.06},
                                    .placement = at({4.3, 2, -1.2}, turnY(kPi / 2)),
                                    .repeat = {}},
                               2, {0, 0, 4.4}))});
}

}  // namespace

void addPanchMahal(Palace& palace, GroupId root) {
  Model& model = palace.model;
  const GroupId mahal = model.group(root, "Five-storey palace", at(-12, 0, -34));
  model.leaf(mahal, "Terrace", palace.stone.redDark, {blockOn({0, 0, 0}, {32, 0.8, 24})});
  constexpr std::uint32_t kAlongX[] = {9, 7, 5, 4};
  constexpr std::uint32_t kAlongZ[] = {6, 6, 4, 3};
  constexpr double kSpacingM = 3.1;
  constexpr double kStoreyM = 4;
  double y = 0.8;
  for (std::uint32_t i = 0; i < 4; ++i) {
    const GroupId storey = model.group(mahal, named("Storey", i + 1), at(1.5 * i, y, 0.8 * i));
    const Vec2 size(kSpacingM * (kAlongX[i] - 1) + 1.4, kSpacingM * (kAlongZ[i] - 1) + 1.4);
    model.leaf(storey, "Columns", palace.stone.red,
               columnGrid(kAlongX[i], kAlongZ[i], kSpacingM, kStoreyM - 0.5));
    model.leaf(storey, "Slab", palace.stone.paving,
               {blockOn({0, kStoreyM - 0.5, 0}, {size.x(), 0.5, size.y()})});
    model.leaf(storey, "Eave", palace.stone.redDark, {moved(eave(size, 1), {0, kStoreyM - 0.2, 0})});
    model.leaf(storey, "Balustrade", palace.stone.redLight, balustrade(size, kStoreyM));
    y += kStoreyM;
  }
  addChhatri(palace, mahal, "Crowning kiosk", at(5.6, y, 3), 2);
}

void addAudienceHalls(Palace& palace, GroupId root) {
  const GroupId halls = palace.model.group(root, "Audience halls");
  addDiwanIKhas(palace, halls);
  addDiwanIAm(palace, halls);
}

void addPool(Palace& palace, GroupId root) {
  Model& model = palace.model;
  const GroupId pool = model.group(root, "Ornamental pool", at(28, 0, -26));
  model.leaf(pool, "Court", palace.stone.paving,
             {box({-22, 0, -22}, {-15, 0.4, 22}), box({15, 0, -22}, {22, 0.4, 22}),
              box({-15, 0, -22}, {15, 0.4, -15}), box({-15, 0, 15}, {15, 0.4, 22})});
  model.leaf(pool, "Water", palace.stone.water, {box({-15, 0.05, -15}, {15, 0.12, 15})});
  const GroupId steps = model.group(pool, "Steps");
  for (std::uint32_t side = 0; side < 4; ++side) {
    model.leaf(steps, named("Side", side + 1), palace.stone.redLight,
               {Part{.shape = Stairs{.widthM = 28, .stepCount = 3, .riseM = 0.13, .goingM = 0.5},
                     .placement = at({0, 0, 13.5}, turnY(-kPi / 2)),
                     .repeat = {}}},
               at({0, 0, 0}, turnY(kPi / 2 * side)));
  }
  const GroupId island = model.group(pool, "Island");
  model.leaf(island, "Platform", palace.stone.red, {blockOn({0, 0, 0}, {9, 0.9, 9})});
  model.leaf(island, "Bridges", palace.stone.red,
             {exactly(around(box({4.5, 0.5, -0.5}, {15, 0.75, 0.5}), 4)),
              exactly(around(box({6, 0, -0.3}, {6.4, 0.5, 0.3}), 4)),
              exactly(around(box({10, 0, -0.3}, {10.4, 0.5, 0.3}), 4))});
  model.leaf(island, "Seat", palace.stone.redLight, {blockOn({0, 0.9, 0}, {4, 0.5, 4})});
  model.leaf(island, "Balustrade", palace.stone.redLight, balustrade({8.8, 8.8}, 0.9));
}

}  // namespace tessera::synthetic
