#include <algorithm>
#include <cmath>
#include <string>

#include "common/scene/synthetic/plant.h"

namespace tessera::synthetic {
namespace {

/// Bend radius to pipe radius: the "long radius" elbow of one and a half diameters.
constexpr double kBend = 3;
/// Where valves show their every step.
constexpr double kFineLevel = 1.8;

std::string numbered(const char* what, std::size_t number) {
  return what + (' ' + std::to_string(number));
}

/// A flanged joint of two pipes, or a blind flange that ends one.
Parts flangeParts(double radiusM, bool blind) {
  constexpr double kPairLevel = 2;
  const double outerM = radiusM * 1.45 + 0.03;
  const double innerM = blind ? 0 : radiusM;
  const double thickM = std::max(0.03, radiusM * 0.22);
  const double boltCircleM = (outerM + radiusM) / 2;
  const double boltM = std::max(0.012, radiusM * 0.07);
  const Vec3 y = Vec3::UnitY();
  const Part bolt = rod({boltCircleM, -thickM - boltM, 0}, {boltCircleM, thickM + boltM, 0}, boltM);
  // A pair of discs with a gap; from afar one thick disc.
  return {belowLevel(collar({0, -thickM, 0}, innerM, outerM, thickM * 2, y), kPairLevel),
          fromLevel(collar({0, -thickM, 0}, innerM, outerM, thickM * 0.92, y), kPairLevel),
          fromLevel(collar({0, thickM * 0.08, 0}, innerM, outerM, thickM * 0.92, y), kPairLevel),
          fromLevel(around(bolt, 8), 2.5)};
}

/// Writes the pieces of one run; positions are relative to its first point.
class RunBuilder {
 public:
  RunBuilder(Plant& plant, GroupId parent, const PipeRun& run)
      : plant_(plant), run_(run), group_(plant.model.group(parent, run.name, at(run.path.front()))) {
    // Short legs get tighter bends.
    const std::size_t legs = run.path.size() - 1;
    for (std::size_t i = 0; i < legs; ++i) {
      const double lengthM = (run.path[i + 1] - run.path[i]).norm();
      const bool bendsTwice = i > 0 && i + 1 < legs;
      bendRadiusM_ = std::min(bendRadiusM_, lengthM * (bendsTwice ? 0.48 : 0.96));
    }
    radial_ = legs > 1 ? Vec3(-bendSide(0)) : Vec3(yTo(directionOf(0)) * Vec3::UnitX());
  }

  void build() {
    Vec3 start = Vec3::Zero();
    const std::size_t legs = run_.path.size() - 1;
    for (std::size_t i = 0; i < legs; ++i) {
      const Vec3 direction = directionOf(i);
      const bool last = i + 1 == legs;
      Vec3 end = run_.path[i + 1] - run_.path.front();
      if (!last) end -= direction * cutBack(i);
      if (i == 0 && run_.endFlanges) flange(start, direction, true);
      straight({.start = start,
                .end = end,
                .openStart = i > 0 || run_.endFlanges,
                .openEnd = !last || run_.endFlanges});
      if (std::count(run_.valvesOn.begin(), run_.valvesOn.end(), i) != 0) valve(start, end, direction);
      if (!last) {
        elbow(end, i);
        start = end + (direction + directionOf(i + 1)) * cutBack(i);
      } else if (run_.endFlanges) {
        flange(end, direction, true);
      }
    }
  }

 private:
  struct Straight {
    Vec3 start, end;
    bool openStart = true, openEnd = true;
  };

  [[nodiscard]] Vec3 directionOf(std::size_t i) const {
    return (run_.path[i + 1] - run_.path[i]).normalized();
  }
  [[nodiscard]] double cutBack(std::size_t i) const {
    const Vec3 before = directionOf(i);
    const Vec3 after = directionOf(i + 1);
    return bendRadiusM_ * before.cross(after).norm() / (1 + before.dot(after));
  }
  /// Towards the centre of the bend after straight i.
  [[nodiscard]] Vec3 bendSide(std::size_t i) const {
    const Vec3 before = directionOf(i);
    const Vec3 after = directionOf(i + 1);
    return (after - before * before.dot(after)).normalized();
  }

  void straight(const Straight& piece) {
    const double lengthM = (piece.end - piece.start).norm();
    const Vec3 direction = (piece.end - piece.start) / lengthM;
    const auto spools = static_cast<std::uint32_t>(std::max(1.0, std::ceil(lengthM / run_.spoolM)));
    const double spoolM = lengthM / spools;
    const double r = run_.radiusM;
    for (std::uint32_t s = 0; s < spools; ++s) {
      std::vector<Curve> profile;
      if (s == 0 && !piece.openStart) profile.push_back(line({0, 0}, {r, 0}));
      profile.push_back(line({r, 0}, {r, spoolM}));
      if (s + 1 == spools && !piece.openEnd) profile.push_back(line({r, spoolM}, {0, spoolM}));
      const Vec3 from = piece.start + (piece.end - piece.start) * (static_cast<double>(s) / spools);
      plant_.model.leaf(group_, numbered("Pipe", ++pipeCount_), run_.material,
                        {turned(Vec3::Zero(), std::move(profile))}, at(from, fromAxes(radial_, direction)));
      if (s > 0) flange(from, direction, false);
    }
  }

  void elbow(const Vec3& start, std::size_t i) {
    const Vec3 before = directionOf(i);
    const Vec3 after = directionOf(i + 1);
    const bool isHalf = before.dot(after) > 0.1;
    const Part bend{.shape = Elbow{.pipeRadiusM = run_.radiusM,
                                   .bendRadiusM = bendRadiusM_,
                                   .angleRad = isHalf ? kPi / 4 : kPi / 2},
                    .placement = {},
                    .repeat = {}};
    const Vec3 side = bendSide(i);
    plant_.model.leaf(group_, numbered("Elbow", ++elbowCount_), run_.material, {bend},
                      at(start, fromAxes(side, before)));
    // The next straight continues the elbow's vertices, so that no crack shows between them.
    radial_ = (before - after * after.dot(before)).normalized();
  }

  void flange(const Vec3& where, const Vec3& direction, bool blind) {
    plant_.model.leaf(group_, numbered("Flange", ++flangeCount_), plant_.paint.galvanized,
                      flangeParts(run_.radiusM, blind), at(where, yTo(direction)));
  }

  void valve(const Vec3& start, const Vec3& end, const Vec3& direction) {
    const Vec3 stem = std::abs(direction.y()) > 0.5 ? Vec3::UnitZ() : Vec3::UnitY();
    addValve(plant_, group_,
             {.center = (start + end) / 2, .along = direction, .stem = stem, .radiusM = run_.radiusM});
  }

  Plant& plant_;
  const PipeRun& run_;
  GroupId group_;
  double bendRadiusM_ = kBend * run_.radiusM;
  Vec3 radial_;  ///< where the first vertex of the current straight's circle lies
  std::size_t pipeCount_ = 0, elbowCount_ = 0, flangeCount_ = 0;
};

}  // namespace

void addPipeRun(Plant& plant, GroupId parent, const PipeRun& run) {
  RunBuilder(plant, parent, run).build();
}

void addValve(Plant& plant, GroupId parent, const ValveSite& site) {
  Model& model = plant.model;
  const double r = site.radiusM;
  // Local frame: pipe along x, stem along y.
  const GroupId group = model.group(parent, "Valve", at(site.center, fromAxes(site.along, site.stem)));
  const double halfM = 2.4 * r + 0.05;
  const double flangeM = r * 1.45 + 0.03;
  const double thickM = std::max(0.03, r * 0.3);
  const Part fineBody = turned({-halfM, 0, 0},
                               polyline({{r, 0},
                                         {flangeM, 0},
                                         {flangeM, thickM},
                                         {r * 1.1, thickM},
                                         {r * 1.7, halfM},
                                         {r * 1.1, 2 * halfM - thickM},
                                         {flangeM, 2 * halfM - thickM},
                                         {flangeM, 2 * halfM},
                                         {r, 2 * halfM}}),
                               Vec3::UnitX());
  const Part coarseBody =
      turned({-halfM, 0, 0},
             polyline({{r, 0}, {flangeM, 0}, {r * 1.3, halfM}, {flangeM, 2 * halfM}, {r, 2 * halfM}}),
             Vec3::UnitX());
  const Part fineBonnet = turned({0, r, 0}, polyline({{r * 1.05, 0},
                                                      {r * 1.05, r},
                                                      {r * 1.4, r},
                                                      {r * 1.4, r * 1.4},
                                                      {r * 0.5, r * 1.4},
                                                      {r * 0.35, r * 3},
                                                      {0, r * 3}}));
  const Part coarseBonnet =
      turned({0, r, 0}, polyline({{r * 1.1, 0}, {r * 1.1, r * 1.2}, {r * 0.35, r * 3}}));
  model.leaf(group, "Body", plant.paint.machineBlue,
             {belowLevel(coarseBody, kFineLevel), belowLevel(coarseBonnet, kFineLevel),
              fromLevel(fineBody, kFineLevel), fromLevel(fineBonnet, kFineLevel)});
  const double wheelM = r * 1.6 + 0.08;
  const double barM = 0.012 + r * 0.07;
  const double wheelY = r * 4.6;
  const Part spoke = bar({0, wheelY, 0}, {wheelM, wheelY, 0}, barM * 1.4);
  const Part rim =
      exactly(around(bar(onCircle(wheelM, 0, wheelY), onCircle(wheelM, kPi / 4, wheelY), barM * 1.6), 8));
  model.leaf(group, "Handwheel", plant.paint.red,
             {belowLevel(rod({0, wheelY - barM, 0}, {0, wheelY + barM, 0}, wheelM), 0.5),
              belowLevel(fromLevel(rim, 0.5), kFineLevel),
              fromLevel(ring({0, wheelY, 0}, wheelM, barM, Vec3::UnitY()), kFineLevel),
              fromLevel(around(spoke, 4), 0.5), tube({0, r * 3, 0}, {0, r * 5.2, 0}, barM * 1.3)});
}

void addPump(Plant& plant, GroupId parent, const std::string& name, const Placement& placement,
             double sizeM) {
  Model& model = plant.model;
  const double s = sizeM;
  const GroupId group = model.group(parent, name, placement);
  model.leaf(group, "Plinth", plant.paint.concrete, {blockOn({1.2 * s, 0, 0}, {2.9 * s, 0.25 * s, 1.1 * s})});
  model.leaf(group, "Base frame", plant.paint.steelDark,
             {blockOn({1.2 * s, 0.25 * s, 0.3 * s}, {2.6 * s, 0.12 * s, 0.12 * s}),
              blockOn({1.2 * s, 0.25 * s, -0.3 * s}, {2.6 * s, 0.12 * s, 0.12 * s}),
              repeated(blockOn({0.2 * s, 0.25 * s, 0}, {0.2 * s, 0.3 * s, 0.5 * s}), 3, {0.9 * s, 0, 0})});
  const double axisY = 0.75 * s;
  model.leaf(
      group, "Casing", plant.paint.machineBlue,
      {turned({0.1 * s, axisY, 0},
              {line({0, 0}, {0.3 * s, 0}), line({0.3 * s, 0}, {0.42 * s, 0.1 * s}),
               arc({0.32 * s, 0.25 * s}, {0.16 * s, 0.16 * s}, -kPi / 2, kPi / 2),
               line({0.32 * s, 0.41 * s}, {0.16 * s, 0.6 * s}), line({0.16 * s, 0.6 * s}, {0, 0.6 * s})},
              Vec3::UnitX()),
       tube({0.35 * s, axisY, 0}, {0.35 * s, 1.5 * s, 0}, 0.16 * s),
       collar({0.35 * s, 1.44 * s, 0}, 0.0, 0.27 * s, 0.06 * s, Vec3::UnitY()),
       tube({0.1 * s, axisY, 0}, {-0.25 * s, axisY, 0}, 0.2 * s),
       collar({-0.25 * s, axisY, 0}, 0.0, 0.32 * s, 0.06 * s, Vec3::UnitX())});
  model.leaf(group, "Coupling guard", plant.paint.railing,
             {rod({0.68 * s, axisY, 0}, {1.15 * s, axisY, 0}, 0.14 * s)});
  model.leaf(group, "Motor", plant.paint.machine,
             {vessel({1.2 * s, axisY, 0}, {2.3 * s, axisY, 0}, 0.36 * s, 0.12 * s),
              repeated(box({1.25 * s, axisY + 0.3 * s, -0.2 * s}, {1.28 * s, axisY + 0.42 * s, 0.2 * s}), 8,
                       {0.13 * s, 0, 0}),
              box({1.6 * s, axisY, 0.3 * s}, {1.9 * s, axisY + 0.25 * s, 0.52 * s})});
}

void addCabinets(Plant& plant, GroupId parent, const Placement& placement, std::uint32_t cabinetCount) {
  const GroupId group = plant.model.group(parent, "Cabinets", placement);
  for (std::uint32_t i = 0; i < cabinetCount; ++i) {
    const double heightM = plant.random.between(1.8, 2.2);
    plant.model.leaf(group, numbered("Cabinet", i + 1), plant.paint.cabinet,
                     {blockOn({0, 0, 0}, {0.9, 0.1, 0.55}), blockOn({0, 0.1, 0}, {0.96, heightM - 0.1, 0.6}),
                      fromLevel(box({-0.42, 0.2, 0.3}, {0.42, heightM - 0.1, 0.33}), 0.25),
                      fromLevel(box({0.3, heightM / 2, 0.33}, {0.35, heightM / 2 + 0.2, 0.37}), 0.8)},
                     at(1.0 * i, 0, 0));
  }
}

void addPlatform(Plant& plant, GroupId parent, const std::string& name, const Placement& placement,
                 const Platform& platform) {
  const GroupId group = plant.model.group(parent, name, placement);
  const double x = platform.sizeM.x();
  const double z = platform.sizeM.y();
  plant.model.leaf(group, "Grating", plant.paint.grating, grating(platform.sizeM));
  Parts rails;
  if (platform.north) append(rails, railing({0, 0, 0.05}, {x, 0, 0.05}));
  if (platform.south) append(rails, railing({0, 0, z - 0.05}, {x, 0, z - 0.05}));
  if (platform.west) append(rails, railing({0.05, 0, 0}, {0.05, 0, z}));
  if (platform.east) append(rails, railing({x - 0.05, 0, 0}, {x - 0.05, 0, z}));
  if (!rails.empty()) plant.model.leaf(group, "Railing", plant.paint.railing, std::move(rails));
  plant.model.leaf(group, "Joists", plant.paint.steel,
                   {beam({0, -0.25, 0.1}, {x, -0.25, 0.1}, 0.2, 0.12),
                    beam({0, -0.25, z - 0.1}, {x, -0.25, z - 0.1}, 0.2, 0.12)});
}

}  // namespace tessera::synthetic
