#include "common/assets/asset_catalogue.h"

#include <iterator>
#include <vector>

namespace tessera {

void AssetCatalogue::add(const AssetId& id, const StoredAsset& place) {
  const auto [at, isNew] = first_.try_emplace(id, place);
  if (!isNew && at->second != place) others_.emplace(id, place);
}

const StoredAsset* AssetCatalogue::find(const AssetId& id) const {
  const auto found = first_.find(id);
  return found == first_.end() ? nullptr : &found->second;
}

void AssetCatalogue::forget(const AssetId& id, const StoredAsset& place) {
  const auto [begin, end] = others_.equal_range(id);
  for (auto it = begin; it != end;)
    it = it->second == place ? others_.erase(it) : std::next(it);
  const auto found = first_.find(id);
  if (found == first_.end() || found->second != place) return;
  first_.erase(found);
  promote(id);
}

void AssetCatalogue::forget(const std::set<PackId>& packs) {
  std::erase_if(others_, [&](const auto& entry) { return packs.contains(entry.second.pack); });
  std::vector<AssetId> lost;
  for (auto it = first_.begin(); it != first_.end();) {
    if (packs.contains(it->second.pack)) {
      lost.push_back(it->first);
      it = first_.erase(it);
    } else {
      ++it;
    }
  }
  for (const AssetId& id : lost)
    promote(id);
}

void AssetCatalogue::promote(const AssetId& id) {
  const auto other = others_.find(id);
  if (other == others_.end()) return;
  first_.emplace(id, other->second);
  others_.erase(other);
}

}  // namespace tessera
