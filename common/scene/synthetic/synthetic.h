#pragma once

#include <cstdint>
#include <string>

#include "common/base/result.h"

/// Synthetic scenes as bytes of a .glb (binary glTF 2.0): metres, y up, ground at y = 0, one root node, one
/// primitive per leaf. The same options give the same bytes on every machine. Options out of range are
/// an input error that tells the range.
namespace tessera {

/// A coal-fired power plant of 300 x 80 x 200 m: 5,037 nodes of which 3,919 are leaves, as in the UNC power
/// plant of the literature.
struct PowerPlantOptions {
  std::uint64_t seed = 1;
  std::uint64_t triangles = 200'000;  ///< hit within 1 %; the nodes stay the same
};

/// A palace complex after Fatehpur Sikri: 770 nodes of which 482 are leaves.
struct FatehpurOptions {
  std::uint64_t seed = 1;
  std::uint64_t triangles = 1'600'000;  ///< hit within 1 %; the nodes stay the same
};

/// A city of 10 m lots whose leaves share a few meshes: a million leaves are 10 km of city.
struct CityOptions {
  std::uint64_t seed = 1;
  std::uint64_t leaves = 100'000;  ///< exact
};

[[nodiscard]] Result<std::string> makePowerPlantGlb(const PowerPlantOptions& options);
[[nodiscard]] Result<std::string> makeFatehpurGlb(const FatehpurOptions& options);
[[nodiscard]] Result<std::string> makeCityGlb(const CityOptions& options);

}  // namespace tessera
