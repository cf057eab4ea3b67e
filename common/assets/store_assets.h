#pragma once

#include <memory>
#include <mutex>

#include "common/assets/asset_table.h"
#include "common/assets/disk_store.h"

namespace tessera {

/// Keeps the bytes of a scene's assets in a store on disk: nothing of them is in memory.
class StoreAssets : public AssetKeeper {
 public:
  /// For an import: assets are added.
  explicit StoreAssets(std::shared_ptr<DiskStore> store) : store_(std::move(store)) {}
  /// For who reads what an import stored. Fails where a pack is gone; those that are there stay while this
  /// lives.
  [[nodiscard]] static Result<std::shared_ptr<StoreAssets>> open(std::shared_ptr<DiskStore> store,
                                                                 Column<StoredAsset> places);

  [[nodiscard]] Status put(const AssetRow& row, std::string bytes) override;
  /// Looks for another copy in the store where the place is damaged or gone. Where there is none, the damaged
  /// pack is removed, so that open() fails the next time and the scene is imported anew.
  [[nodiscard]] Result<AssetBytes> read(std::uint32_t number, const AssetRow& row) const override;

  [[nodiscard]] const Column<StoredAsset>& places() const { return places_; }

 private:
  std::shared_ptr<DiskStore> store_;
  Column<StoredAsset> places_;
};

}  // namespace tessera
