#pragma once

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <vector>

#include "common/assets/leaf_cache.h"

namespace tessera::test {

inline AssetId idOf(std::uint32_t number) {
  AssetId id;
  std::memcpy(id.bytes.data(), &number, sizeof number);
  return id;
}

/// What a LeafCache should have: no counts, only facts; all else is computed from them.
class LeafCacheModel {
 public:
  struct Asset {
    std::uint32_t bytes = 0;
    std::vector<AssetId> needs;
  };
  struct Leaf {
    AssetId drawable, state;
    bool isShown = false;
  };
  /// What one step of a trim drops: at most one leaf, and the assets that go with it in any order.
  struct Step {
    std::vector<std::uint32_t> leaf;
    std::set<AssetId> assets;
  };

  void addLeaf(std::uint32_t leaf, const AssetId& drawable, const AssetId& state) {
    const bool wasShown = leaves.contains(leaf) && leaves[leaf].isShown;
    leaves[leaf] = {drawable, state, wasShown};
    std::erase(unshown, leaf);
    if (!wasShown) unshown.push_back(leaf);
  }
  /// Needs are one level deep: what has some is needed by none.
  void addAsset(const AssetId& id, std::uint32_t bytes, const std::vector<AssetId>& needs) {
    if (assets.contains(id)) return;
    const bool isNeeded = std::any_of(assets.begin(), assets.end(), [&](const auto& other) {
      return std::ranges::count(other.second.needs, id) > 0;
    });
    Asset asset{bytes, {}};
    for (const AssetId& needed : needs) {
      const auto found = assets.find(needed);
      const bool hasNeeds = found != assets.end() && !found->second.needs.empty();
      if (!isNeeded && needed != id && !hasNeeds) asset.needs.push_back(needed);
    }
    assets[id] = asset;
  }
  void keep(std::uint32_t leaf) {
    if (std::erase(unshown, leaf) > 0) unshown.push_back(leaf);
  }
  void toggle(std::uint32_t leaf) {
    const auto found = leaves.find(leaf);
    if (found == leaves.end()) return;
    found->second.isShown = !found->second.isShown;
    std::erase(unshown, leaf);
    if (!found->second.isShown) unshown.push_back(leaf);
  }
  [[nodiscard]] std::set<AssetId> neededBy(bool shownOnly) const {
    std::set<AssetId> needed;
    for (const auto& [number, leaf] : leaves) {
      if (shownOnly && !leaf.isShown) continue;
      for (const AssetId& id : {leaf.drawable, leaf.state}) {
        needed.insert(id);
        const auto found = assets.find(id);
        if (found != assets.end()) needed.insert(found->second.needs.begin(), found->second.needs.end());
      }
    }
    return needed;
  }
  [[nodiscard]] std::uint64_t bytes() const {
    std::uint64_t sum = leaves.size() * LeafCache::kRecordBytes;
    for (const auto& [id, asset] : assets)
      sum += asset.bytes;
    return sum;
  }
  [[nodiscard]] std::uint64_t shownBytes() const {
    std::uint64_t sum = (leaves.size() - unshown.size()) * LeafCache::kRecordBytes;
    for (const AssetId& id : neededBy(true)) {
      const auto found = assets.find(id);
      if (found != assets.end()) sum += found->second.bytes;
    }
    return sum;
  }
  [[nodiscard]] bool isComplete(std::uint32_t leaf) const {
    const auto found = leaves.find(leaf);
    if (found == leaves.end()) return false;
    const auto state = assets.find(found->second.state);
    return assets.contains(found->second.drawable) && state != assets.end() &&
           std::ranges::all_of(state->second.needs,
                               [this](const AssetId& id) { return assets.contains(id); });
  }
  std::vector<Step> trim(std::uint64_t budget) {
    std::vector<Step> steps{{{}, dropUnneeded()}};
    while (bytes() > budget && !unshown.empty()) {
      const std::uint32_t leaf = unshown.front();
      unshown.erase(unshown.begin());
      leaves.erase(leaf);
      steps.push_back({{leaf}, dropUnneeded()});
    }
    return steps;
  }
  void clear() { *this = {}; }

  std::map<AssetId, Asset> assets;
  std::map<std::uint32_t, Leaf> leaves;
  std::vector<std::uint32_t> unshown;  ///< the one used longest ago first

 private:
  std::set<AssetId> dropUnneeded() {
    const std::set<AssetId> needed = neededBy(false);
    std::set<AssetId> dropped;
    for (const auto& [id, asset] : assets) {
      if (!needed.contains(id)) dropped.insert(id);
    }
    for (const AssetId& id : dropped)
      assets.erase(id);
    return dropped;
  }
};

}  // namespace tessera::test
