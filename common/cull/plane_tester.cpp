#include "common/cull/plane_tester.h"

namespace tessera::cull {

void PlaneTester::beginFrame(const ObjectHierarchy& oh, const FrustumHierarchy& frusta,
                             const Switches& switches, bool testsTiles) {
  switches_ = switches;
  if (switches.octantTest) {
    octants_.assign(1, middlesOf(frusta.primary()));
    for (std::uint32_t tile = 0; tile < frusta.tileCount(); ++tile)
      octants_.push_back(middlesOf(frusta.tile(tile)));
  }
  if (!switches.planeCoherency && !switches.motionCoherence) {
    slots_ = 0;
    return;
  }
  const std::uint64_t entryBytes = switches.motionCoherence ? 48 : 1;
  std::uint32_t slots = testsTiles ? 1 + frusta.tileCount() : 1;
  if (slots * entryBytes * oh.nodeCount() > kMostCacheBytes) slots = 1;
  const bool isNew = slots_ != slots || nodes_ != oh.nodeCount();
  slots_ = slots;
  nodes_ = oh.nodeCount();
  if (switches.planeCoherency && isNew) lastPlane_.assign(std::size_t{slots} * nodes_, UINT8_MAX);
  if (!switches.motionCoherence) return;
  if (!motion_.fits(slots, nodes_) || revision_ != oh.revision()) motion_.reset(slots, nodes_);
  revision_ = oh.revision();
  motion_.advance(0, frusta.primary(), frusta.eye());
  for (std::uint32_t tile = 0; tile + 1 < slots; ++tile)
    motion_.advance(1 + tile, frusta.tile(tile), frusta.eye());
}

std::array<PlaneTester::Middle, 3> PlaneTester::middlesOf(const FrustumPlanes& planes) {
  std::array<Middle, 3> middles;
  constexpr std::array<std::array<std::uint32_t, 2>, 3> kOpposite = {{{0, 2}, {1, 3}, {4, 5}}};
  for (std::size_t i = 0; i < kOpposite.size(); ++i) {
    const auto [a, b] = kOpposite[i];
    if (a >= planes.count || b >= planes.count) continue;
    const BoundedPlane &first = planes.planes[a], &second = planes.planes[b];
    Middle& middle = middles[i];
    const double firstLength = first.normal.norm(), secondLength = second.normal.norm();
    middle.unitNormals = {first.normal / firstLength, second.normal / secondLength};
    middle.distances = {first.distance / firstLength, second.distance / secondLength};
    middle.normal = middle.unitNormals[0] - middle.unitNormals[1];
    middle.distance = middle.distances[0] - middle.distances[1];
    middle.first = 1u << a;
    middle.second = 1u << b;
  }
  return middles;
}

}  // namespace tessera::cull
