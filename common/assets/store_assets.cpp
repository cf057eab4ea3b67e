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
  auto bytes = store_->read(row.id, places_[number]);
  if (!bytes) {
    const auto other = store_->find(row.id);
    if (!other) return bytes.error();
    auto again = store_->read(row.id, *other);
    if (!again) return again.error();
    bytes = std::move(again);
  }
  return std::make_shared<const std::string>(std::move(*bytes));
}

}  // namespace tessera
