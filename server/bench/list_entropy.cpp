#include "server/bench/list_entropy.h"

#include <cmath>

namespace tessera::bench {

void ListEntropy::add(const VisibleList& toggled) {
  std::uint32_t end = 0;
  for (const LeafRange run : toggled) {
    ++gaps_[run.first - end];
    ++lengths_[run.last - run.first];
    end = run.last;
  }
}

double ListEntropy::bitsOf(const Histogram& histogram) {
  double total = 0, sum = 0;
  for (const auto& [value, count] : histogram) {
    const auto n = static_cast<double>(count);
    total += n;
    sum += n * std::log2(n);
  }
  return total > 0 ? total * std::log2(total) - sum : 0;
}

double ListEntropy::bytes() const {
  return (bitsOf(gaps_) + bitsOf(lengths_)) / 8;
}

}  // namespace tessera::bench
