#include "common/assets/store_assets.h"

#include <set>
#include <utility>

namespace tessera {

Result<std::shared_ptr<StoreAssets>> StoreAssets::open(std::shared_ptr<DiskStore> store,
                                                       Column<StoredAsset> places) {
  std::set<std::array<std::uint8_t, 16>> packs;
  for (const StoredAsset& place : places) {
    if (!packs.insert(place.pack.bytes).second) continue;
    if (Status status = store->uses(place.pack); !status) return status.error();
  }
  auto assets = std::make_shared<StoreAssets>(std::move(store));
  assets->places_ = std::move(places);
  return assets;
}

Status StoreAssets::put(const AssetRow& row, std::string bytes) {
  const auto place = store_->add(row.id, row.kind, std::as_bytes(std::span(bytes)));
  if (!place) return place.error();
  places_.push_back(*place);
  return Done{};
}

Result<AssetBytes> StoreAssets::read(std::uint32_t number, const AssetRow& row) const {
  if (AssetBytes known = recent(number)) return known;
  ReadProblem problem = ReadProblem::Failed;
  auto bytes = store_->read(row.id, places_[number], &problem);
  if (!bytes && problem != ReadProblem::Failed) {
    if (const auto other = store_->find(row.id)) bytes = store_->read(row.id, *other, &problem);
  }
  if (!bytes) {
    // Without the damaged pack the next opening finds that something is missing, and imports the scene anew;
    // with it, the loss would stay for good. What is good in the pack is kept.
    if (problem == ReadProblem::Damaged) static_cast<void>(store_->dropDamaged());
    return bytes.error();
  }
  const AssetBytes shared = std::make_shared<const std::string>(std::move(*bytes));
  remember(number, shared);
  return shared;
}

AssetBytes StoreAssets::recent(std::uint32_t number) const {
  const std::lock_guard lock(mutex_);
  const auto found = recent_.find(number);
  return found == recent_.end() ? nullptr : found->second;
}

void StoreAssets::remember(std::uint32_t number, const AssetBytes& bytes) const {
  const std::lock_guard lock(mutex_);
  if (!recent_.emplace(number, bytes).second) return;
  order_.push_back(number);
  recentBytes_ += bytes->size();
  while (recentBytes_ > kRecentBytes) {
    const auto oldest = recent_.find(order_.front());
    recentBytes_ -= oldest->second->size();
    recent_.erase(oldest);
    order_.pop_front();
  }
}

}  // namespace tessera
