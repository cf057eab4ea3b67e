#include "common/assets/leaf_cache.h"

namespace tessera {

void LeafCache::clear() {
  leaves_.clear();
  assets_.clear();
  loose_.clear();
  bytes_ = shownBytes_ = 0;
  presentAssets_ = 0;
  ends_.before = ends_.after = &ends_;
}

LeafCache::AssetEntry& LeafCache::entryOf(const AssetId& id) {
  AssetEntry& entry = assets_[id];
  entry.id = id;
  return entry;
}

void LeafCache::release(AssetEntry& asset) {
  if (--asset.users > 0) return;
  for (AssetEntry* needed : asset.needs) {
    --needed->owners;
    release(*needed);
  }
  if (asset.isPresent) {
    bytes_ -= asset.bytes;
    --presentAssets_;
    dropped_.assets.push_back(asset.id);
  }
  assets_.erase(AssetId(asset.id));
}

/// For use outside of trim(), where nothing is dropped.
void LeafCache::releaseLater(AssetEntry& asset) {
  if (--asset.users == 0) loose_.push_back(asset.id);
}

void LeafCache::showAsset(AssetEntry& asset) {
  if (++asset.shownUsers > 1) return;
  if (asset.isPresent) shownBytes_ += asset.bytes;
  for (AssetEntry* needed : asset.needs)
    showAsset(*needed);
}

void LeafCache::hideAsset(AssetEntry& asset) {
  if (--asset.shownUsers > 0) return;
  if (asset.isPresent) shownBytes_ -= asset.bytes;
  for (AssetEntry* needed : asset.needs)
    hideAsset(*needed);
}

void LeafCache::chain(LeafEntry& leaf) {
  leaf.before = ends_.before;
  leaf.after = &ends_;
  leaf.before->after = &leaf;
  ends_.before = &leaf;
}

void LeafCache::unchain(LeafEntry& leaf) {
  leaf.before->after = leaf.after;
  leaf.after->before = leaf.before;
}

void LeafCache::setShown(LeafEntry& leaf, bool isShown) {
  leaf.isShown = isShown;
  if (isShown) {
    unchain(leaf);
    shownBytes_ += kRecordBytes;
    showAsset(*leaf.drawable);
    showAsset(*leaf.state);
  } else {
    chain(leaf);
    shownBytes_ -= kRecordBytes;
    hideAsset(*leaf.drawable);
    hideAsset(*leaf.state);
  }
}

void LeafCache::addLeaf(std::uint32_t leaf, const AssetId& drawable, const AssetId& state) {
  AssetEntry &newDrawable = entryOf(drawable), &newState = entryOf(state);
  // The new ones first: what the old record needs, too, is in use all the time.
  use(newDrawable);
  use(newState);
  const auto [place, isNew] = leaves_.try_emplace(leaf);
  LeafEntry& entry = place->second;
  bool wasShown = false;
  if (isNew) {
    entry.leaf = leaf;
    bytes_ += kRecordBytes;
  } else {
    wasShown = entry.isShown;
    if (wasShown) setShown(entry, false);
    unchain(entry);
    releaseLater(*entry.drawable);
    releaseLater(*entry.state);
  }
  entry.drawable = &newDrawable;
  entry.state = &newState;
  chain(entry);
  if (wasShown) setShown(entry, true);
}

bool LeafCache::isComplete(std::uint32_t leaf) const {
  const auto found = leaves_.find(leaf);
  if (found == leaves_.end()) return false;
  const LeafEntry& entry = found->second;
  if (!entry.drawable->isPresent || !entry.state->isPresent) return false;
  for (const AssetEntry* needed : entry.state->needs) {
    if (!needed->isPresent) return false;
  }
  return true;
}

bool LeafCache::hasAsset(const AssetId& id) const {
  const auto found = assets_.find(id);
  return found != assets_.end() && found->second.isPresent;
}

void LeafCache::addAsset(const AssetId& id, std::uint32_t bytes, std::span<const AssetId> needs) {
  AssetEntry& asset = entryOf(id);
  if (asset.isPresent) return;
  asset.isPresent = true;
  asset.bytes = bytes;
  bytes_ += bytes;
  ++presentAssets_;
  if (asset.shownUsers > 0) shownBytes_ += bytes;
  for (const AssetId& needed : needs) {
    if (asset.owners > 0) break;
    AssetEntry& entry = entryOf(needed);
    if (&entry == &asset || !entry.needs.empty()) continue;
    use(entry);
    ++entry.owners;
    asset.needs.push_back(&entry);
    if (asset.shownUsers > 0) showAsset(entry);
  }
  if (asset.users == 0) loose_.push_back(id);
}

void LeafCache::keep(std::uint32_t leaf) {
  const auto found = leaves_.find(leaf);
  if (found == leaves_.end() || found->second.isShown) return;
  unchain(found->second);
  chain(found->second);
}

void LeafCache::show(const VisibleList& toggled) {
  forEachLeaf(toggled, [this](std::uint32_t leaf) {
    const auto found = leaves_.find(leaf);
    if (found != leaves_.end()) setShown(found->second, !found->second.isShown);
  });
}

void LeafCache::drop(LeafEntry& leaf) {
  unchain(leaf);
  bytes_ -= kRecordBytes;
  dropped_.leaves.push_back(leaf.leaf);
  release(*leaf.drawable);
  release(*leaf.state);
  leaves_.erase(std::uint32_t{leaf.leaf});
}

const LeafCache::Dropped& LeafCache::trim() {
  dropped_.leaves.clear();
  dropped_.assets.clear();
  for (const AssetId& id : loose_) {
    const auto found = assets_.find(id);
    if (found == assets_.end() || found->second.users > 0) continue;
    use(found->second);
    release(found->second);
  }
  loose_.clear();
  while (bytes_ > budgetBytes_ && ends_.after != &ends_)
    drop(*ends_.after);
  return dropped_;
}

}  // namespace tessera
