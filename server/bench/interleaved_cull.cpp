#include "server/bench/interleaved_cull.h"

#include <chrono>

namespace tessera::bench {

InterleavedCull::InterleavedCull(const std::vector<Candidate>& candidates) {
  for (const Candidate& candidate : candidates) {
    cullers_.emplace_back(*candidate.hierarchy, candidate.options);
    measured_.push_back({.name = candidate.name, .us = {}, .classifications = {}, .pairs = {}, .counts = {}});
  }
}

const cull::Result& InterleavedCull::run(std::size_t candidate, const FrustumHierarchy& frusta) {
  const auto start = std::chrono::steady_clock::now();
  const cull::Result& result = cullers_[candidate].cull(frusta);
  const auto end = std::chrono::steady_clock::now();
  Measured& measured = measured_[candidate];
  measured.us.add(std::chrono::duration<double, std::micro>(end - start).count());
  measured.classifications.add(static_cast<double>(result.tests.classifications()));
  measured.pairs.add(static_cast<double>(result.pairs));
  measured.counts += result.tests;
  measured.listHash = cull::hashOf(result.lists, measured.listHash);
  return result;
}

}  // namespace tessera::bench
