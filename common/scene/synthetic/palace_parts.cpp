#include <cmath>
#include <string>

#include "common/scene/synthetic/palace.h"

namespace tessera::synthetic {

Parts carvedColumn(double heightM, double radiusM) {
  constexpr double kFineLevel = 0.8;
  const double r = radiusM;
  const double h = heightM;
  const Part coarse =
      turned({0, 0, 0}, polyline({{r * 1.2, 0}, {r, h * 0.12}, {r * 0.9, h * 0.86}, {r * 1.6, h}}));
  const Part shaft =
      turned({0, 0, 0}, {line({r * 1.5, 0}, {r * 1.5, h * 0.05}),
                         arc({r * 1.1, h * 0.08}, {r * 0.3, h * 0.03}, -kPi / 2, kPi / 2),
                         line({r * 1.05, h * 0.11}, {r, h * 0.14}), line({r, h * 0.14}, {r * 0.95, h * 0.45}),
                         arc({r * 0.95, h * 0.48}, {r * 0.16, h * 0.03}, -kPi / 2, kPi / 2),
                         line({r * 0.95, h * 0.51}, {r * 0.88, h * 0.8}),
                         arc({r * 0.88, h * 0.82}, {r * 0.3, h * 0.02}, -kPi / 2, kPi / 2),
                         line({r * 0.9, h * 0.84}, {r * 1.6, h * 0.94})});
  const Part capital = blockOn({0, h * 0.94, 0}, {r * 3.6, h * 0.06, r * 3.6});
  const Part bracket =
      prism({{r * 0.7, h * 0.8}, {r * 3.2, h * 0.94}, {r * 0.7, h * 0.94}}, r * 0.6, at(0, 0, -r * 0.3));
  return {belowLevel(tube({0, 0, 0}, {0, h, 0}, r), 0.25), belowLevel(fromLevel(coarse, 0.25), kFineLevel),
          fromLevel(shaft, kFineLevel), fromLevel(capital, 0.25), fromLevel(around(bracket, 4), 1.5)};
}

Parts pointedDome(double radiusM) {
  const double r = radiusM;
  // The shell leans in from 60 degrees on and ends in a lotus under the finial.
  const SinCos shoulder = sinCos(kPi / 3);
  const Vec2 neck(r * 1.02 * shoulder.cos, r * (0.25 + 1.02 * shoulder.sin));
  return {
      turned({0, 0, 0}, {line({r * 0.96, 0}, {r * 0.96, r * 0.25}),
                         arc({0, r * 0.25}, {r * 1.02, r * 1.02}, 0, kPi / 3), line(neck, {0, r * 1.52})}),
      ring({0, r * 1.4, 0}, r * 0.1, r * 0.05, Vec3::UnitY()),
      turned({0, r * 1.45, 0}, {arc({0, r * 0.12}, {r * 0.09, r * 0.1}, -kPi / 2, kPi / 2)}),
      turned({0, r * 1.66, 0}, polyline({{r * 0.03, 0}, {0, r * 0.35}}))};
}

Part eave(const Vec2& sizeM, double reachM) {
  constexpr double kThickM = 0.15;
  const double x = sizeM.x() / 2 + reachM;
  const double z = sizeM.y() / 2 + reachM;
  return box({-x, -kThickM, -z}, {x, 0, z});
}

Part battlements(double lengthM, double heightM) {
  const double w = heightM * 0.62;
  Part merlon{.shape = Extrusion{.outline = {line({0, 0}, {w, 0}), line({w, 0}, {w, heightM * 0.45}),
                                             arc({w - heightM * 0.78, heightM * 0.45},
                                                 {heightM * 0.78, heightM * 0.78}, 0, 0.924),
                                             arc({heightM * 0.78, heightM * 0.45},
                                                 {heightM * 0.78, heightM * 0.78}, kPi - 0.924, kPi),
                                             line({0, heightM * 0.45}, {0, 0})},
                                 .depthM = 0.35},
              .placement = at(w * 0.15, 0, -0.175),
              .repeat = {}};
  const auto count = static_cast<std::uint32_t>(std::max(1.0, std::floor(lengthM / (w * 1.3))));
  return repeated(merlon, count, {lengthM / count, 0, 0});
}

Parts columnGrid(std::uint32_t alongX, std::uint32_t alongZ, double spacingM, double heightM) {
  Parts all;
  for (std::uint32_t k = 0; k < alongZ; ++k) {
    for (Part part : carvedColumn(heightM, heightM * 0.045)) {
      const double x = -spacingM * (alongX - 1) / 2;
      const double z = spacingM * (k - (alongZ - 1) / 2.0);
      if (part.repeat.count == 1) {
        part.placement.positionM += Vec3(x, 0, z);
        all.push_back(exactly(repeated(std::move(part), alongX, {spacingM, 0, 0})));
      }
    }
  }
  return all;
}

void addChhatri(Palace& palace, GroupId parent, const std::string& name, const Placement& placement,
                double radiusM) {
  Model& model = palace.model;
  const double r = radiusM;
  const double columnM = r * 1.5;
  const GroupId chhatri = model.group(parent, name, placement);
  model.leaf(chhatri, "Plinth", palace.stone.redLight, {blockOn({0, 0, 0}, {r * 2.4, r * 0.2, r * 2.4})});
  Parts columns;
  for (Part part : carvedColumn(columnM, r * 0.11)) {
    if (part.repeat.count != 1) continue;
    part.placement.positionM += Vec3(r * 1.18, r * 0.2, 0);
    columns.push_back(exactly(around(std::move(part), 8)));
  }
  model.leaf(chhatri, "Columns", palace.stone.red, std::move(columns));
  model.leaf(chhatri, "Eave", palace.stone.redDark,
             {turned({0, r * 0.2 + columnM, 0}, polyline({{r * 0.9, -0.02},
                                                          {r * 1.9, -r * 0.25},
                                                          {r * 1.95, -r * 0.18},
                                                          {r * 1.3, r * 0.12},
                                                          {r * 1.15, r * 0.12},
                                                          {r * 1.15, r * 0.3},
                                                          {r * 0.9, r * 0.3}}))});
  Parts dome = pointedDome(r * 1.05);
  for (Part& part : dome)
    part.placement.positionM.y() += r * 0.48 + columnM;
  model.leaf(chhatri, "Dome", palace.stone.redLight, std::move(dome));
}

void addArcade(Palace& palace, GroupId parent, const Arcade& spec) {
  Model& model = palace.model;
  const double lengthM = spec.bays * spec.bayM;
  const GroupId arcade = model.group(parent, spec.name, spec.placement);
  ArchBay bay{.widthM = spec.bayM,
              .heightM = spec.heightM,
              .depthM = 0.7,
              .openingWidthM = spec.bayM * 0.72,
              .springM = spec.heightM * 0.5,
              .riseM = spec.heightM * 0.27};
  Part arch{.shape = bay, .placement = at(spec.bayM / 2, 0, 0), .repeat = {}};
  model.leaf(arcade, "Arches", palace.stone.red,
             {exactly(repeated(std::move(arch), spec.bays, {spec.bayM, 0, 0}))});
  Parts columns;
  for (Part part : carvedColumn(spec.heightM * 0.5, 0.2)) {
    if (part.repeat.count != 1) continue;
    part.placement.positionM += Vec3(0, 0, 0.45);
    columns.push_back(exactly(repeated(std::move(part), spec.bays + 1, {spec.bayM, 0, 0})));
  }
  model.leaf(arcade, "Half columns", palace.stone.redLight, std::move(columns));
  model.leaf(arcade, "Back wall", palace.stone.redDark,
             {box({0, 0, -spec.depthM - 0.6}, {lengthM, spec.heightM, -spec.depthM}),
              repeated(box({spec.bayM * 0.25, spec.heightM * 0.2, -spec.depthM},
                           {spec.bayM * 0.75, spec.heightM * 0.7, -spec.depthM + 0.1}),
                       spec.bays, {spec.bayM, 0, 0})});
  model.leaf(arcade, "Roof", palace.stone.paving,
             {box({0, spec.heightM, -spec.depthM - 0.6}, {lengthM, spec.heightM + 0.4, 0.35})});
  model.leaf(arcade, "Eave", palace.stone.redDark,
             {prism({{0.3, -0.1}, {1.5, -0.7}, {1.5, -0.58}, {0.3, 0.05}}, lengthM,
                    at({lengthM, spec.heightM, 0}, turnY(-kPi / 2))),
              repeated(prism({{0.3, -0.9}, {1.1, -0.5}, {0.3, -0.1}}, 0.2,
                             at({0.4, spec.heightM, 0}, turnY(-kPi / 2))),
                       spec.bays * 2, {spec.bayM / 2, 0, 0})});
  Part merlons = battlements(lengthM, 0.9);
  merlons.placement.positionM += Vec3(0, spec.heightM + 0.4, 0);
  model.leaf(arcade, "Battlements", palace.stone.redLight, {merlons});
}

}  // namespace tessera::synthetic
