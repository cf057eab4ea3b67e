#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/assets/asset_id.h"
#include "common/hierarchy/visible_list.h"

namespace tessera {

/// The books of one tile's cache: which leaf records and assets it has, what they count for, and what goes
/// when the budget is spent. The tile and the master's mirror of it keep one each and tell it the same in the
/// same order; then both arrive at the same state without asking.
///
/// Least recently used goes first, counted by leaves: what is in the list is never dropped, and of the rest
/// the leaf that has been out of it, or has been kept, longest ago. An asset goes with the last leaf that
/// needs it. Dropping happens in trim() alone, once a frame, so a tile holds its budget plus what one frame
/// needs.
class LeafCache {
 public:
  /// A leaf's record is counted as this.
  static constexpr std::uint64_t kRecordBytes = 512;
  static constexpr std::uint64_t kNoBudget = UINT64_MAX;

  explicit LeafCache(std::uint64_t budgetBytes = kNoBudget) : budgetBytes_(budgetBytes) { clear(); }
  LeafCache(const LeafCache&) = delete;
  LeafCache& operator=(const LeafCache&) = delete;

  void clear();
  void setBudget(std::uint64_t budgetBytes) { budgetBytes_ = budgetBytes; }

  [[nodiscard]] bool hasLeaf(std::uint32_t leaf) const { return leaves_.contains(leaf); }
  /// Adds a record, as the one used last. Replaces one that is there.
  void addLeaf(std::uint32_t leaf, const AssetId& drawable, const AssetId& state);
  /// Whether all that the leaf needs is here; false where there is no record.
  [[nodiscard]] bool isComplete(std::uint32_t leaf) const;

  [[nodiscard]] bool hasAsset(const AssetId& id) const;
  /// Adds an asset unless it is here. One that nothing needs by the next trim() is dropped then. Needs are
  /// one level deep, a state's images: an asset that another one needs has none itself, and what has some is
  /// needed by leaves alone. So a peer can make neither a circle, which would never be dropped, nor a long
  /// chain.
  void addAsset(const AssetId& id, std::uint32_t bytes, std::span<const AssetId> needs);

  /// The leaf counts as used now. Nothing where it has no record or is in the list.
  void keep(std::uint32_t leaf);
  /// Leaves that come into the list or leave it; those without a record are passed over.
  void show(const VisibleList& toggled);

  struct Dropped {
    std::vector<std::uint32_t> leaves;
    std::vector<AssetId> assets;
  };
  /// Brings the cache under its budget as far as the list allows. The result lives until the next call.
  const Dropped& trim();

  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  /// Of what the list needs: what cannot be dropped.
  [[nodiscard]] std::uint64_t shownBytes() const { return shownBytes_; }
  [[nodiscard]] std::uint64_t budgetBytes() const { return budgetBytes_; }
  [[nodiscard]] std::size_t leafCount() const { return leaves_.size(); }
  [[nodiscard]] std::size_t assetCount() const { return presentAssets_; }

 private:
  struct AssetEntry {
    AssetId id;
    std::uint32_t bytes = 0;
    std::uint32_t users = 0;       ///< leaves, or states whose image this is
    std::uint32_t shownUsers = 0;  ///< of these, how many are in the list
    std::uint32_t owners = 0;      ///< of the users, how many are assets
    bool isPresent = false;
    std::vector<AssetEntry*> needs = {};
  };
  struct LeafEntry {
    std::uint32_t leaf = 0;
    AssetEntry* drawable = nullptr;
    AssetEntry* state = nullptr;
    bool isShown = false;
    // The unshown ones are chained, the one used longest ago first.
    LeafEntry* before = nullptr;
    LeafEntry* after = nullptr;
  };

  AssetEntry& entryOf(const AssetId& id);
  void use(AssetEntry& asset) { ++asset.users; }
  void release(AssetEntry& asset);
  void releaseLater(AssetEntry& asset);
  void showAsset(AssetEntry& asset);
  void hideAsset(AssetEntry& asset);
  void chain(LeafEntry& leaf);
  void unchain(LeafEntry& leaf);
  void setShown(LeafEntry& leaf, bool isShown);
  void drop(LeafEntry& leaf);

  std::uint64_t budgetBytes_;
  std::uint64_t bytes_ = 0, shownBytes_ = 0;
  std::size_t presentAssets_ = 0;
  std::unordered_map<AssetId, AssetEntry, AssetIdHash> assets_;
  std::unordered_map<std::uint32_t, LeafEntry> leaves_;
  LeafEntry ends_;              ///< before the first and after the last of the chain
  std::vector<AssetId> loose_;  ///< may be needed by nothing since the last trim()
  Dropped dropped_;
};

}  // namespace tessera
