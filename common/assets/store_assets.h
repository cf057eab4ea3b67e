#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <unordered_map>

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
  /// What several tiles are sent at about the same time is read once: the last kRecentBytes stay in memory.
  [[nodiscard]] Result<AssetBytes> read(std::uint32_t number, const AssetRow& row) const override;

  [[nodiscard]] const Column<StoredAsset>& places() const { return places_; }

  static constexpr std::uint64_t kRecentBytes = std::uint64_t{16} << 20;

 private:
  [[nodiscard]] AssetBytes recent(std::uint32_t number) const;
  void remember(std::uint32_t number, const AssetBytes& bytes) const;

  std::shared_ptr<DiskStore> store_;
  Column<StoredAsset> places_;
  mutable std::mutex mutex_;
  mutable std::unordered_map<std::uint32_t, AssetBytes> recent_;
  mutable std::deque<std::uint32_t> order_;  ///< of recent_, the oldest first
  mutable std::uint64_t recentBytes_ = 0;
};

}  // namespace tessera
