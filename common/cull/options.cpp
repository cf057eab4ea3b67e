#include "common/cull/options.h"

#include <array>
#include <string>
#include <utility>

namespace tessera::cull {

namespace {

constexpr std::array kAlgorithms = {std::pair{Algorithm::None, "none"},
                                    std::pair{Algorithm::Naive, "naive"},
                                    std::pair{Algorithm::Oh, "oh"},
                                    std::pair{Algorithm::Fh, "fh"},
                                    std::pair{Algorithm::Adaptive, "adaptive"},
                                    std::pair{Algorithm::AdaptiveListing, "adaptive-listing"},
                                    std::pair{Algorithm::Footprint, "footprint"},
                                    std::pair{Algorithm::Table, "table"},
                                    std::pair{Algorithm::Auto, "auto"}};
constexpr std::array kBounds = {std::pair{BoundsKind::Sphere, "sphere"}, std::pair{BoundsKind::Aabb, "aabb"},
                                std::pair{BoundsKind::Obb, "obb"}, std::pair{BoundsKind::Hybrid, "hybrid"},
                                std::pair{BoundsKind::AabbThenObb, "aabb-then-obb"}};
constexpr std::array kReuses = {std::pair{Reuse::Never, "never"}, std::pair{Reuse::Always, "always"},
                                std::pair{Reuse::Measured, "measured"}};

template <class Table>
auto findByName(const Table& table, std::string_view name) {
  std::optional<typename Table::value_type::first_type> found;
  for (const auto& [value, text] : table) {
    if (name == text) found = value;
  }
  return found;
}

template <class Table>
std::string_view findName(const Table& table, typename Table::value_type::first_type value) {
  for (const auto& [known, text] : table) {
    if (known == value) return text;
  }
  return "?";
}

}  // namespace

std::optional<Algorithm> algorithmFromName(std::string_view name) {
  return findByName(kAlgorithms, name);
}
std::optional<BoundsKind> boundsFromName(std::string_view name) {
  return findByName(kBounds, name);
}
std::string_view nameOf(Algorithm algorithm) {
  return findName(kAlgorithms, algorithm);
}
std::string_view nameOf(BoundsKind bounds) {
  return findName(kBounds, bounds);
}
std::optional<Reuse> reuseFromName(std::string_view name) {
  return findByName(kReuses, name);
}
std::string_view nameOf(Reuse reuse) {
  return findName(kReuses, reuse);
}

bool concernsPlanes(const Switches& s) {
  return !s.firstLevel || !s.planeMasking || s.planeCoherency || s.octantTest || s.octantPitfall ||
         s.signTable || s.sphereFirst || s.motionCoherence || s.regroup;
}

Status check(const Options& options) {
  const Switches& s = options.switches;
  if (s.signTable && options.bounds != BoundsKind::Aabb) {
    return inputError("--sign-table", "works on axis-aligned boxes alone", "add --bounds aabb");
  }
  if (s.signTable && s.sphereFirst) {
    return inputError("--sphere-first", "does not go with --sign-table", "choose one of them");
  }
  if (s.sphereFirst && (options.bounds == BoundsKind::Sphere || options.bounds == BoundsKind::AabbThenObb)) {
    return inputError("--sphere-first", "needs a box behind the sphere",
                      "choose --bounds aabb, obb or hybrid");
  }
  if (s.regroup && options.algorithm != Algorithm::Adaptive) {
    return inputError("--regroup", "is a variant of the adaptive algorithm", "add --algorithm adaptive");
  }
  const bool isFootprint = options.algorithm == Algorithm::Footprint || options.algorithm == Algorithm::Table;
  if (isFootprint && (options.bounds == BoundsKind::Sphere || options.bounds == BoundsKind::AabbThenObb)) {
    return inputError("--bounds", "footprints are of boxes", "choose --bounds aabb, obb or hybrid");
  }
  if (isFootprint && concernsPlanes(s)) {
    return inputError("--algorithm",
                      "footprints are found without planes, so switches of plane tests do nothing",
                      "leave them out, or choose --algorithm adaptive");
  }
  return Done{};
}

}  // namespace tessera::cull
