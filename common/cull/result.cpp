#include "common/cull/result.h"

namespace tessera::cull {

TestCounts& TestCounts::operator+=(const TestCounts& other) {
  sphere += other.sphere, aabb += other.aabb, obb += other.obb;
  primary += other.primary, bisection += other.bisection, tile += other.tile;
  nodes += other.nodes;
  remembered += other.remembered;
  octantSpared += other.octantSpared;
  groups += other.groups;
  return *this;
}

std::uint64_t hashOf(const std::vector<VisibleList>& lists, std::uint64_t seed) {
  std::uint64_t hash = seed ^ 0xcbf29ce484222325u;  // FNV-1a, a word at a time
  const auto mix = [&hash](std::uint64_t word) {
    hash = (hash ^ word) * 0x100000001b3u;
    hash ^= hash >> 29;
  };
  for (const VisibleList& list : lists) {
    mix(list.size());
    for (const LeafRange range : list)
      mix(std::uint64_t{range.first} << 32 | range.last);
  }
  return hash;
}

}  // namespace tessera::cull
