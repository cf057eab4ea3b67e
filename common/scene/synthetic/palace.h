#pragma once

#include <cstdint>
#include <string>

#include "common/scene/synthetic/model.h"
#include "common/scene/synthetic/parts.h"
#include "common/scene/synthetic/random.h"

// The palace complex while it is being built; the plan is in fatehpur.cpp. Metres; x runs east, z south,
// ground at y = 0.
namespace tessera::synthetic {

/// Material ids.
struct Stone {
  std::uint32_t red, redDark, redLight, paving, marble, plaster, glazed, water, lawn, earth, gilt, foliage;
};

struct Palace {
  Model model;
  Random random;
  Stone stone;
};

/// Carved column with base and capital, from y = 0.
[[nodiscard]] Parts carvedColumn(double heightM, double radiusM);
/// Dome with a pointed top and a finial, from y = 0.
[[nodiscard]] Parts pointedDome(double radiusM);
/// Projecting stone eave (chajja) over a rectangle centred on the origin; its top is at y = 0.
[[nodiscard]] Part eave(const Vec2& sizeM, double reachM);
/// Row of pointed battlements along +x from the origin.
[[nodiscard]] Part battlements(double lengthM, double heightM);
/// Columns on a grid centred on the origin.
[[nodiscard]] Parts columnGrid(std::uint32_t alongX, std::uint32_t alongZ, double spacingM, double heightM);

/// Domed kiosk of four leaves.
void addChhatri(Palace& palace, GroupId parent, const std::string& name, const Placement& placement,
                double radiusM);
/// An open arcade of `bays` along +x with roof, back wall, eave and battlements.
struct Arcade {
  std::string name;
  Placement placement;
  std::uint32_t bays = 8;
  double bayM = 4;
  double heightM = 6;
  double depthM = 5;
};
void addArcade(Palace& palace, GroupId parent, const Arcade& spec);

void addMosque(Palace& palace, GroupId root);
void addGreatGate(Palace& palace, GroupId root);
void addTomb(Palace& palace, GroupId root);
void addPanchMahal(Palace& palace, GroupId root);
void addAudienceHalls(Palace& palace, GroupId root);
void addPool(Palace& palace, GroupId root);
void addResidences(Palace& palace, GroupId root);
void addMinar(Palace& palace, GroupId root);
void addCityWall(Palace& palace, GroupId root);
/// Shrubs in beds: exactly `leafCount` leaves, 2 or more.
void addGarden(Palace& palace, GroupId root, std::uint32_t leafCount);

}  // namespace tessera::synthetic
