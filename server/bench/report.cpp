#include "server/bench/report.h"

#include <algorithm>

namespace tessera::bench {

Json spreadOf(const Samples& samples) {
  return {{"p25", samples.percentile(25)},
          {"p50", samples.percentile(50)},
          {"p75", samples.percentile(75)},
          {"p99", samples.percentile(99)}};
}

std::vector<double> smoothed(const Samples& samples, std::size_t window) {
  std::vector<double> curve;
  for (std::size_t start = 0; start < samples.values.size(); start += window) {
    Samples part;
    const std::size_t end = std::min(samples.values.size(), start + window);
    part.values.assign(samples.values.begin() + static_cast<std::ptrdiff_t>(start),
                       samples.values.begin() + static_cast<std::ptrdiff_t>(end));
    curve.push_back(part.percentile(50));
  }
  return curve;
}

Json ratioOf(const Samples& numerator, const Samples& denominator) {
  Samples ratios;
  for (std::size_t i = 0; i < std::min(numerator.values.size(), denominator.values.size()); ++i)
    ratios.add(numerator.values[i] / denominator.values[i]);
  return spreadOf(ratios);
}

Json stepOf(const Walk& walk) {
  const Walk::Step step = walk.step();
  return {{"degrees_per_frame", step.degrees}, {"scene_radii_per_frame", step.sceneRadii}};
}

Json summaryOf(const InterleavedCull::Measured& measured, const Samples* base) {
  Json summary = {{"name", measured.name},
                  {"output", nameOf(measured.output)},
                  {"us", spreadOf(measured.us)},
                  {"tests_per_frame", measured.classifications.percentile(50)},
                  {"pairs_per_frame", measured.pairs.percentile(50)}};
  if (measured.output == Output::Ranges || measured.output == Output::Ids)
    summary["lists_hash"] = measured.listHash;
  if (base) summary["time_ratio"] = ratioOf(measured.us, *base);
  return summary;
}

}  // namespace tessera::bench
