#include "common/hierarchy/visible_list.h"

#include <algorithm>

namespace tessera {

namespace {

/// Sweeps both lists' boundaries in order and keeps the ids where `keep(inA, inB)`.
template <class Keep>
void combineInto(const VisibleList& a, const VisibleList& b, Keep keep, VisibleList& out) {
  out.clear();
  std::size_t i = 0, j = 0;
  const auto boundary = [](const VisibleList& list, std::size_t k) {
    return k % 2 == 0 ? list[k / 2].first : list[k / 2].last;
  };
  bool open = false;
  std::uint32_t first = 0;
  while (i < 2 * a.size() || j < 2 * b.size()) {
    const std::uint32_t nextA = i < 2 * a.size() ? boundary(a, i) : UINT32_MAX;
    const std::uint32_t nextB = j < 2 * b.size() ? boundary(b, j) : UINT32_MAX;
    const std::uint32_t at = std::min(nextA, nextB);
    if (nextA == at && i < 2 * a.size()) ++i;
    if (nextB == at && j < 2 * b.size()) ++j;
    const bool kept = keep(i % 2 == 1, j % 2 == 1);
    if (kept && !open) first = at;
    if (!kept && open) appendRange(out, {first, at});
    open = kept;
  }
}

template <class Keep>
VisibleList combine(const VisibleList& a, const VisibleList& b, Keep keep) {
  VisibleList out;
  combineInto(a, b, keep, out);
  return out;
}

}  // namespace

std::uint64_t leafCount(const VisibleList& list) {
  std::uint64_t count = 0;
  for (const LeafRange range : list)
    count += range.last - range.first;
  return count;
}

bool isCanonical(const VisibleList& list, std::uint32_t leafLimit) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].first >= list[i].last || list[i].last > leafLimit) return false;
    if (i > 0 && list[i - 1].last >= list[i].first) return false;
  }
  return true;
}

bool containsLeaf(const VisibleList& list, std::uint32_t leaf) {
  const auto after = std::upper_bound(list.begin(), list.end(), leaf,
                                      [](std::uint32_t id, const LeafRange& r) { return id < r.first; });
  return after != list.begin() && leaf < std::prev(after)->last;
}

VisibleList unionOf(const VisibleList& a, const VisibleList& b) {
  return combine(a, b, [](bool inA, bool inB) { return inA || inB; });
}

VisibleList differenceOf(const VisibleList& a, const VisibleList& b) {
  return combine(a, b, [](bool inA, bool inB) { return inA && !inB; });
}

void differenceInto(const VisibleList& a, const VisibleList& b, VisibleList& out) {
  out.clear();
  auto next = b.begin();
  for (LeafRange range : a) {
    next = std::upper_bound(next, b.end(), range.first,
                            [](std::uint32_t id, const LeafRange& r) { return id < r.last; });
    for (auto gone = next; gone != b.end() && gone->first < range.last; ++gone) {
      if (gone->first > range.first) appendRange(out, {range.first, gone->first});
      range.first = std::min(gone->last, range.last);
    }
    appendRange(out, range);
  }
}

void symmetricDifferenceInto(const VisibleList& a, const VisibleList& b, VisibleList& out) {
  combineInto(
      a, b, [](bool inA, bool inB) { return inA != inB; }, out);
}

}  // namespace tessera
