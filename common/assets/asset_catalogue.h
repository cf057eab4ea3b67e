#pragma once

#include <optional>
#include <set>
#include <unordered_map>

#include "common/assets/stored_asset.h"

namespace tessera {

/// Where each asset lies; an asset that lies in several packs is found as long as one of them is left.
class AssetCatalogue {
 public:
  void add(const AssetId& id, const StoredAsset& place);
  [[nodiscard]] const StoredAsset* find(const AssetId& id) const;
  /// One place turned out to be bad.
  void forget(const AssetId& id, const StoredAsset& place);
  /// These packs are gone.
  void forget(const std::set<PackId>& packs);
  /// Calls `visit(id, place)` for every asset, in no order.
  template <class Visit>
  void forEach(Visit visit) const {
    for (const auto& [id, place] : first_)
      visit(id, place);
  }
  [[nodiscard]] std::size_t size() const { return first_.size(); }

 private:
  void promote(const AssetId& id);

  std::unordered_map<AssetId, StoredAsset, AssetIdHash> first_;
  std::unordered_multimap<AssetId, StoredAsset, AssetIdHash> others_;  ///< further places of the same assets
};

}  // namespace tessera
