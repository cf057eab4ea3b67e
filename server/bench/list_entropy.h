#pragma once

#include <cstdint>
#include <unordered_map>

#include "common/hierarchy/visible_list.h"

namespace tessera::bench {

/// The zeroth-order entropy of what list deltas are made of: the gaps before the runs of changed leaves and
/// the lengths of the runs, each kind a source of its own, over a whole walk and all tiles.
class ListEntropy {
 public:
  /// `toggled`: the leaves that a frame changes in one tile's list.
  void add(const VisibleList& toggled);
  /// Of everything added.
  [[nodiscard]] double bytes() const;

 private:
  using Histogram = std::unordered_map<std::uint32_t, std::uint64_t>;
  static double bitsOf(const Histogram& histogram);
  Histogram gaps_, lengths_;
};

}  // namespace tessera::bench
