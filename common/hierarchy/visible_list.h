#pragma once

#include <cstdint>
#include <vector>

namespace tessera {

/// Half-open range [first, last) of leaf ids.
struct LeafRange {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
  friend bool operator==(const LeafRange&, const LeafRange&) = default;
};

/// The leaves a tile must draw: sorted, disjoint, non-adjacent, non-empty ranges of pre-order leaf ids.
/// That form is canonical: equal sets are equal lists.
using VisibleList = std::vector<LeafRange>;

/// Appends a range that starts at or after the end of the list; adjacent ranges are merged.
inline void appendRange(VisibleList& list, LeafRange range) {
  if (range.first == range.last) return;
  if (!list.empty() && list.back().last == range.first) {
    list.back().last = range.last;
  } else {
    list.push_back(range);
  }
}

[[nodiscard]] std::uint64_t leafCount(const VisibleList& list);

/// True for the canonical form with every id below `leafLimit`.
[[nodiscard]] bool isCanonical(const VisibleList& list, std::uint32_t leafLimit);

[[nodiscard]] bool containsLeaf(const VisibleList& list, std::uint32_t leaf);

/// Set operations; the results are canonical.
[[nodiscard]] VisibleList unionOf(const VisibleList& a, const VisibleList& b);
[[nodiscard]] VisibleList differenceOf(const VisibleList& a, const VisibleList& b);

/// The leaves of `a` that are not in `b`, in time that grows with `a` and with what is taken away, not with
/// `b`. `out` is cleared and refilled and must be neither of them.
void differenceInto(const VisibleList& a, const VisibleList& b, VisibleList& out);

/// The leaves in exactly one of the two; `out` is cleared and refilled and must be neither of them.
void symmetricDifferenceInto(const VisibleList& a, const VisibleList& b, VisibleList& out);

/// Calls `visit(leaf)` for every leaf in ascending order.
template <class Visit>
void forEachLeaf(const VisibleList& list, Visit visit) {
  for (const LeafRange range : list) {
    for (std::uint32_t leaf = range.first; leaf != range.last; ++leaf)
      visit(leaf);
  }
}

}  // namespace tessera
