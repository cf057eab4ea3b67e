#include <cmath>
#include <string>

#include "common/scene/synthetic/plant.h"

namespace tessera::synthetic {
namespace {

std::string named(const char* what, std::size_t number) {
  return what + (' ' + std::to_string(number));
}

/// A conveyor gallery between two points: trestles, truss sections and a cover.
void addGallery(Plant& plant, GroupId parent, const std::string& name, const Vec3& from, const Vec3& to,
                std::uint32_t sections) {
  Model& model = plant.model;
  const GroupId gallery = model.group(parent, name, at(from));
  const Vec3 step = (to - from) / sections;
  const Vec3 along = step.normalized();
  const Vec3 side = Vec3::UnitY().cross(along).normalized();
  const Quat turn = fromAxes(side, along.cross(side));
  const double lengthM = step.norm();
  for (std::uint32_t i = 0; i < sections; ++i) {
    const GroupId section = model.group(gallery, named("Section", i + 1), at(step * i, turn));
    model.leaf(section, "Housing", plant.paint.claddingBlue,
               {prism({{-1.7, 0.9}, {1.7, 0.9}, {1.7, 2.4}, {1.0, 3.0}, {-1.0, 3.0}, {-1.7, 2.4}}, lengthM),
                repeated(box({-1.8, 0.9, 0.2}, {1.8, 1.0, 0.4}), static_cast<std::uint32_t>(lengthM / 2),
                         {0, 0, 2})});
    Parts truss;
    for (const double x : {-1.7, 1.7}) {
      truss.push_back(bar({x, 0.85, 0}, {x, 0.85, lengthM}, 0.2));
      truss.push_back(bar({x, -0.9, 0}, {x, -0.9, lengthM}, 0.2));
      for (std::uint32_t k = 0; k < 4; ++k) {
        const double z0 = lengthM * k / 4;
        const double z1 = lengthM * (k + 1) / 4;
        truss.push_back(bar({x, k % 2 == 0 ? -0.9 : 0.85, z0}, {x, k % 2 == 0 ? 0.85 : -0.9, z1}, 0.14));
      }
    }
    model.leaf(section, "Truss", plant.paint.steel, std::move(truss));
    const double heightM = from.y() + step.y() * i - 0.9;
    if (heightM > 1.5) {
      const Vec3 foot = from + step * i;
      const GroupId trestle = model.group(gallery, named("Trestle", i + 1),
                                          at(step * i - Vec3(0, foot.y(), 0), fromAxes(side, Vec3::UnitY())));
      const double spread = 1.7 + heightM * 0.08;
      model.leaf(trestle, "Posts", plant.paint.steel,
                 {beam({-spread, 0, 0}, {-1.7, heightM, 0}, 0.4, 0.4),
                  beam({spread, 0, 0}, {1.7, heightM, 0}, 0.4, 0.4)});
      const auto braces = static_cast<std::uint32_t>(std::max(1.0, std::floor(heightM / 5)));
      Parts cross;
      for (std::uint32_t k = 0; k < braces; ++k) {
        const double t0 = static_cast<double>(k) / braces;
        const double t1 = (k + 1.0) / braces;
        const auto leg = [&](double t) { return spread + (1.7 - spread) * t; };
        cross.push_back(bar({-leg(t0), heightM * t0 + 0.1, 0}, {leg(t1), heightM * t1, 0}, 0.16));
        cross.push_back(bar({-leg(t1), heightM * t1, 0}, {leg(t1), heightM * t1, 0}, 0.2));
      }
      model.leaf(trestle, "Bracing", plant.paint.steel, std::move(cross));
    }
  }
}

void addTransferTower(Plant& plant, GroupId area, const std::string& name, const Vec3& where,
                      double heightM) {
  Model& model = plant.model;
  const GroupId tower = model.group(area, name, at(where));
  const double floorM = 6;
  const auto floors = static_cast<std::uint32_t>(heightM / floorM);
  const GroupId frame = model.group(tower, "Frame");
  for (std::uint32_t i = 0; i < 4; ++i) {
    model.leaf(frame, named("Column", i + 1), plant.paint.steel, {beam({0, 0, 0}, {0, heightM, 0}, 0.6, 0.6)},
               at(i % 2 == 0 ? -4 : 4, 0, i < 2 ? -4 : 4));
  }
  for (std::uint32_t i = 1; i <= floors; ++i) {
    const GroupId floor = model.group(tower, named("Floor", i), at(0, floorM * i, 0));
    model.leaf(floor, "Beams", plant.paint.steel,
               {beam({-4, -0.3, -4}, {4, -0.3, -4}, 0.5, 0.3), beam({-4, -0.3, 4}, {4, -0.3, 4}, 0.5, 0.3),
                beam({-4, -0.3, -4}, {-4, -0.3, 4}, 0.5, 0.3), beam({4, -0.3, -4}, {4, -0.3, 4}, 0.5, 0.3)});
    model.leaf(floor, "Deck", plant.paint.grating, {box({-4, -0.1, -4}, {4, 0, 4})});
    model.leaf(floor, "Railing", plant.paint.railing,
               joined({railing({-4, 0, -4}, {4, 0, -4}), railing({-4, 0, 4}, {4, 0, 4}),
                       railing({-4, 0, -4}, {-4, 0, 4})}));
    model.leaf(floor, "Stairs", plant.paint.galvanized, steelStairs(6, floorM, 0.9),
               at({i % 2 == 0 ? 3.0 : -3.0, -floorM, 4.8}, turnY(i % 2 == 0 ? kPi : 0)));
  }
  model.leaf(tower, "Cabin", plant.paint.claddingBlue,
             {box({-4.4, heightM, -4.4}, {4.4, heightM + 5, 4.4}),
              repeated(box({-4.2, heightM, -4.5}, {-4.0, heightM + 5, 4.5}), 11, {0.82, 0, 0})});
  model.leaf(tower, "Roof", plant.paint.roof,
             {prism({{-4.7, 0}, {4.7, 0}, {0, 1.4}}, 9.4, at(0, heightM + 5, -4.7))});
}

void addPile(Plant& plant, GroupId yard, std::uint32_t number, const Vec3& from, double lengthM,
             double radiusM) {
  const double heightM = radiusM * 0.72;
  const GroupId pile = plant.model.group(yard, named("Coal pile", number), at(from));
  Part ridge = prism({{-radiusM, 0}, {radiusM, 0}, {0, heightM}}, lengthM, at({0, 0, 0}, turnY(kPi / 2)));
  plant.model.leaf(pile, "Ridge", plant.paint.coal, {ridge});
  plant.model.leaf(pile, "West end", plant.paint.coal,
                   {turned({0, 0, 0}, polyline({{radiusM, 0}, {0, heightM}}))});
  plant.model.leaf(pile, "East end", plant.paint.coal,
                   {turned({lengthM, 0, 0}, polyline({{radiusM, 0}, {0, heightM}}))});
}

void addStacker(Plant& plant, GroupId yard) {
  Model& model = plant.model;
  const GroupId stacker = model.group(yard, "Stacker", at(104, 0, -67));
  model.leaf(stacker, "Rails", plant.paint.steelDark,
             {box({-40, 0, -2.6}, {40, 0.25, -2.4}), box({-40, 0, 2.4}, {40, 0.25, 2.6})});
  model.leaf(stacker, "Portal", plant.paint.railing,
             {beam({-3, 0.8, -2.5}, {-1.5, 6, -1.5}, 0.6, 0.5),
              beam({3, 0.8, -2.5}, {1.5, 6, -1.5}, 0.6, 0.5), beam({-3, 0.8, 2.5}, {-1.5, 6, 1.5}, 0.6, 0.5),
              beam({3, 0.8, 2.5}, {1.5, 6, 1.5}, 0.6, 0.5), blockOn({0, 6, 0}, {4, 1, 4})});
  model.leaf(stacker, "Bogies", plant.paint.steelDark,
             {repeated(rod({-3.4, 0.6, -2.7}, {-3.4, 0.6, -2.3}, 0.4), 2, {6.8, 0, 0}),
              repeated(rod({-3.4, 0.6, 2.3}, {-3.4, 0.6, 2.7}, 0.4), 2, {6.8, 0, 0})});
  model.leaf(stacker, "Slew ring", plant.paint.steelDark, {rod({0, 7, 0}, {0, 7.8, 0}, 1.9)});
  const Quat turn = turnY(-1.2);
  model.leaf(stacker, "Boom", plant.paint.railing,
             {beam({-8, 8.5, -0.9}, {22, 12, -0.9}, 0.7, 0.3), beam({-8, 8.5, 0.9}, {22, 12, 0.9}, 0.7, 0.3),
              repeated(bar({-7, 8.6, -0.9}, {-7, 8.6, 0.9}, 0.2), 15, {2.0, 0.233, 0})},
             at({0, 0, 0}, turn));
  model.leaf(stacker, "Mast and stays", plant.paint.railing,
             {bar({0, 7.8, 0}, {0, 17, 0}, 0.5), tube({0, 16.8, 0}, {20, 12, 0.9}, 0.06),
              tube({0, 16.8, 0}, {20, 12, -0.9}, 0.06), tube({0, 16.8, 0}, {-8, 9, 0}, 0.08)},
             at({0, 0, 0}, turn));
  model.leaf(stacker, "Counterweight", plant.paint.concrete, {box({-10, 7.6, -1.5}, {-7, 10, 1.5})},
             at({0, 0, 0}, turn));
  model.leaf(stacker, "Cabin", plant.paint.white, {box({2, 8.2, 1.6}, {4, 10.4, 3.2})}, at({0, 0, 0}, turn));
  model.leaf(stacker, "Wheel", plant.paint.rust,
             {ring({22.4, 12, 0}, 2, 0.3, Vec3::UnitZ()), rod({22.4, 12, -0.5}, {22.4, 12, 0.5}, 0.6)},
             at({0, 0, 0}, turn));
}

}  // namespace

void addCoalYard(Plant& plant, GroupId root) {
  const GroupId area = plant.model.group(root, "Coal handling");
  const GroupId yard = plant.model.group(area, "Coal yard");
  plant.model.leaf(yard, "Yard slab", plant.paint.asphalt, {box({52, 0, -98}, {148, 0.1, -38})});
  addPile(plant, yard, 1, {78, 0.1, -84}, 52, 11);
  addPile(plant, yard, 2, {76, 0.1, -51}, 48, 10);
  addStacker(plant, yard);
  const GroupId conveyors = plant.model.group(area, "Conveyors");
  addGallery(plant, conveyors, "Yard conveyor", {142, 2.2, -67.01}, {56, 2.2, -67}, 8);
  addGallery(plant, conveyors, "Inclined conveyor", {54, 4, -66}, {30, 44, -58}, 4);
  addTransferTower(plant, area, "Transfer tower 1", {54, 0, -67}, 6);
  addTransferTower(plant, area, "Transfer tower 2", {30, 0, -59}, 42);
  const GroupId ash = plant.model.group(area, "Ash silos");
  for (std::uint32_t i = 0; i < 3; ++i) {
    const GroupId silo = plant.model.group(ash, named("Ash silo", i + 1), at(-8.0 + 9 * i, 0, -86));
    plant.model.leaf(silo, "Shell", plant.paint.tankGrey,
                     {turned({0, 5, 0}, polyline({{0.6, 0}, {3.6, 3.4}, {3.6, 15}, {1, 16.4}, {0, 16.4}}))});
    plant.model.leaf(silo, "Skirt", plant.paint.steel,
                     {around(beam({3.5, 0, 0}, {3.5, 8.6, 0}, 0.35, 0.35), 6)});
    plant.model.leaf(silo, "Roof railing", plant.paint.railing, roundRailing(3.4, 20.1));
    plant.model.leaf(silo, "Ladder", plant.paint.galvanized, cagedLadder(20), at(0, 0, 3.8));
    plant.model.leaf(silo, "Filter", plant.paint.aluminium, {blockOn({0.4, 21.3, 0}, {1.5, 2.2, 1.5})});
  }
}

}  // namespace tessera::synthetic
