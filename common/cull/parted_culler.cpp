#include "common/cull/parted_culler.h"

namespace tessera::cull {

const Result& PartedCuller::cull(const FrustumHierarchy& fixedFrusta, const FrustumHierarchy& movingFrusta) {
  const Result& fixed = fixed_.cull(fixedFrusta);
  const Result& moving = moving_.cull(movingFrusta);
  result_.lists.resize(fixed.lists.size());
  for (std::size_t tile = 0; tile < fixed.lists.size(); ++tile) {
    VisibleList& list = result_.lists[tile];
    list.assign(fixed.lists[tile].begin(), fixed.lists[tile].end());
    for (const LeafRange range : moving.lists[tile])
      appendRange(list, {offset_ + range.first, offset_ + range.last});
  }
  result_.tests = fixed.tests;
  result_.tests += moving.tests;
  result_.pairs = fixed.pairs + moving.pairs;
  return result_;
}

}  // namespace tessera::cull
