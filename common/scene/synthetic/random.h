#pragma once

#include <bit>
#include <cstdint>

namespace tessera::synthetic {

/// Mixes 64 bits (splitmix64's finalizer); a hash for values that are not hostile.
[[nodiscard]] constexpr std::uint64_t mix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

/// xoshiro256** by Blackman and Vigna. The standard library's distributions differ between libraries, so
/// the distributions are here too: the same seed gives the same scene everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) {
    for (auto& word : state_)
      word = seed = mix64(seed);
  }

  std::uint64_t bits() {
    const std::uint64_t result = std::rotl(state_[1] * 5, 7) * 9;
    const std::uint64_t t = state_[1] << 17U;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= t;
    state_[3] = std::rotl(state_[3], 45);
    return result;
  }

  /// Uniform in [0, 1).
  double unit() { return static_cast<double>(bits() >> 11U) * 0x1p-53; }
  /// Uniform in [low, high).
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Uniform in [0, count); `count` > 0. The bias is below 2^-32 for the counts used here.
  std::uint32_t index(std::uint32_t count) {
    return static_cast<std::uint32_t>(((bits() >> 32U) * count) >> 32U);
  }
  bool chance(double probability) { return unit() < probability; }

 private:
  std::uint64_t state_[4] = {};
};

}  // namespace tessera::synthetic
