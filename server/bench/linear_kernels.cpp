// Compiled with -O3: both stand for code that somebody would have tuned.
#include "server/bench/linear_kernels.h"

namespace tessera::bench {

namespace {

/// Ids are written so many at a time, beyond the end of a range, where the next one overwrites them.
constexpr std::uint32_t kStride = 8;

}  // namespace

void LeafIds::reserve(std::uint64_t pairs) {
  if (ids_.size() < pairs + kStride) ids_.resize(pairs + kStride);
}

void LeafIds::write(const std::vector<VisibleList>& lists) {
  std::uint32_t* out = ids_.data();
  for (const VisibleList& list : lists) {
    for (const LeafRange range : list) {
      const std::uint32_t length = range.last - range.first;
      for (std::uint32_t done = 0; done < length; done += kStride) {
        for (std::uint32_t i = 0; i < kStride; ++i)
          out[done + i] = range.first + done + i;
      }
      out += length;
    }
  }
  count_ = static_cast<std::uint64_t>(out - ids_.data());
}

double sumOfObbs(const ObjectHierarchy& oh) {
  Obb sum;  // twelve sums that do not wait for each other
  for (std::uint32_t node = 0; node < oh.nodeCount(); ++node) {
    const Obb& box = oh.obb(node);
    sum.center += box.center;
    for (std::size_t axis = 0; axis < 3; ++axis)
      sum.halfAxes[axis] += box.halfAxes[axis];
  }
  return sum.center.sum() + sum.halfAxes[0].sum() + sum.halfAxes[1].sum() + sum.halfAxes[2].sum();
}

}  // namespace tessera::bench
