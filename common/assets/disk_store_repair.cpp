// Damaged packs of a store on disk: what is good in them is kept, the rest removed.

#include <cerrno>

#include <fcntl.h>
#include <unistd.h>

#include "common/assets/disk_store_state.h"
#include "common/assets/pack_format.h"
#include "common/assets/pack_reader.h"

namespace tessera {

/// Writes what is good in a pack to the one being written, as far as it lies nowhere else. True where the
/// pack can go, false where it is whole after all or cannot be judged now; `status` tells of a full disk.
bool DiskStore::State::salvage(const PackId& id, Status& status) {
  const std::filesystem::path path = folder.pack(id);
  const FileHandle file = openFile(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
  if (!file.isOpen()) {
    if (errno == ENOENT) damaged.erase(id);
    return false;
  }
  const PackContents contents = readContents(file.fd());
  if (contents.state == PackContents::State::Failed) return false;
  bool isWhole = contents.state == PackContents::State::Good;
  std::vector<std::pair<AssetId, StoredAsset>> good;
  for (const PackEntry& e : contents.entries) {
    const StoredAsset place{id, e.offset, e.storedBytes, e.bytes, e.kind};
    ReadProblem problem{};
    if (readRecord(file.fd(), path.string(), e.id, place, problem)) {
      good.emplace_back(e.id, place);
    } else if (problem == ReadProblem::Failed) {
      return false;
    } else {
      isWhole = false;
    }
  }
  if (isWhole) {  // A place from outside was wrong, not the pack.
    damaged.erase(id);
    return false;
  }
  for (const auto& [asset, place] : good) {
    const StoredAsset* other = catalogue.find(asset);
    if ((other != nullptr && other->pack != id) || unpublished.find(asset) != nullptr) continue;
    ReadProblem problem{};
    const auto bytes = readRecord(file.fd(), path.string(), asset, place, problem);
    if (!bytes) continue;
    if (auto added = append(asset, place.kind, std::as_bytes(std::span(*bytes))); !added) {
      status = added.error();
      return false;
    }
  }
  return true;
}

Result<std::size_t> DiskStore::dropDamaged() {
  State& state = *state_;
  if (!state.options.mayWrite) return std::size_t{0};
  const std::lock_guard lock(state.mutex);
  state.refresh();
  std::set<PackId> removed;
  for (const PackId& id : std::set<PackId>(state.damaged)) {
    Status status = Done{};
    if (!state.salvage(id, status)) {
      if (!status) return status.error();
      continue;
    }
    // What was good must be safe in its new place before the old one goes.
    if (Status done = state.publish(); !done) return done.error();
    ::unlink(state.folder.pack(id).c_str());
    removed.insert(id);
    state.forgetPacks({id});
  }
  return removed.size();
}

}  // namespace tessera
