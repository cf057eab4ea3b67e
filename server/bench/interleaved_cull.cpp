#include "server/bench/interleaved_cull.h"

#include <chrono>

namespace tessera::bench {

namespace {

using Clock = std::chrono::steady_clock;

double usSince(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

}  // namespace

std::string_view nameOf(Output output) {
  constexpr std::array<std::string_view, 4> kNames = {"ranges", "ids", "diff", "count"};
  return kNames[static_cast<std::size_t>(output)];
}

InterleavedCull::InterleavedCull(const std::vector<Candidate>& candidates) {
  for (const Candidate& candidate : candidates) {
    Runner runner;
    if (candidate.baseline) {
      runner.baseline = candidate.baseline;
    } else {
      runner.culler.emplace(*candidate.hierarchy, candidate.options);
    }
    runners_.push_back(std::move(runner));
    Measured measured;
    measured.name = candidate.name;
    measured.output = candidate.output;
    order_.push_back(measured_.size());
    measured_.push_back(std::move(measured));
  }
}

double InterleavedCull::cullOnce(Runner& runner, const FrustumHierarchy& frusta, Measured& measured) {
  const auto start = Clock::now();
  if (measured.output == Output::Diff) {
    const cull::Changes& changes = runner.culler->cullChanges(frusta);
    const double us = usSince(start);
    measured.classifications.add(static_cast<double>(changes.tests.classifications()));
    measured.pairs.add(static_cast<double>(changes.pairs));
    measured.counts += changes.tests;
    return us;
  }
  const cull::Result& result = runner.culler->cull(frusta);
  double us = usSince(start);
  if (measured.output == Output::Ids) {
    ids_.reserve(result.pairs);  // a buffer that is there already costs nothing
    const auto writeStart = Clock::now();
    ids_.write(result.lists);
    us += usSince(writeStart);
  }
  measured.classifications.add(static_cast<double>(result.tests.classifications()));
  measured.pairs.add(static_cast<double>(result.pairs));
  measured.counts += result.tests;
  measured.listHash = cull::hashOf(result.lists, measured.listHash);
  return us;
}

void InterleavedCull::run(std::size_t candidate, const FrustumHierarchy& frusta) {
  Runner& runner = runners_[candidate];
  Measured& measured = measured_[candidate];
  runner.tiles = frusta.tileCount();
  if (runner.baseline) {
    const auto start = Clock::now();
    runner.baseline->run();
    measured.us.add(usSince(start));
    measured.pairs.add(static_cast<double>(runner.baseline->pairs()));
    return;
  }
  measured.us.add(cullOnce(runner, frusta, measured));
  ++measured.picked[static_cast<std::size_t>(runner.culler->picked())];
}

void InterleavedCull::listsOf(std::size_t candidate, std::vector<VisibleList>& out) const {
  const Runner& runner = runners_[candidate];
  out.resize(runner.tiles);
  for (std::uint32_t tile = 0; tile < runner.tiles; ++tile)
    runner.culler->listOf(tile, out[tile]);
}

}  // namespace tessera::bench
