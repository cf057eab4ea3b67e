#include "common/assets/disk_store.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "common/assets/disk_store_state.h"

namespace tessera {

namespace {

constexpr int kLockTries = 50;
constexpr std::chrono::milliseconds kLockPause{2};

}  // namespace

DiskStore::DiskStore(std::unique_ptr<State> state) : state_(std::move(state)) {}
DiskStore::~DiskStore() = default;

Result<std::unique_ptr<DiskStore>> DiskStore::open(const Options& options) {
  if (options.folder.empty()) return inputError("", "a store on disk needs a folder", "name one");
  auto state = std::make_unique<State>();
  state->options = options;
  state->folder.root = options.folder;
  if (Status done = prepareFolder(state->folder, options.mayWrite); !done) return done.error();
  if (options.mayWrite) removeLeftovers(state->folder);
  return std::unique_ptr<DiskStore>(new DiskStore(std::move(state)));
}

std::optional<StoredAsset> DiskStore::find(const AssetId& id) const {
  const std::lock_guard lock(state_->mutex);
  return state_->find(id);
}

Result<StoredAsset> DiskStore::add(const AssetId& id, AssetKind kind, std::span<const std::byte> bytes) {
  if (!state_->options.mayWrite) {
    return runtimeError(state_->folder.root.string(), "the store was opened for reading alone");
  }
  if (bytes.size() > kMaxAssetBytes) {
    return inputError(id.hex().substr(0, 16),
                      "the asset has more than " + std::to_string(kMaxAssetBytes) + " bytes",
                      "cut it into smaller ones");
  }
  const std::lock_guard lock(state_->mutex);
  // One that is there counts as used: it must not be the next that is evicted.
  if (const auto there = state_->findAndUse(id)) return *there;
  return state_->append(id, kind, bytes);
}

Status DiskStore::publish() {
  const std::lock_guard lock(state_->mutex);
  return state_->publish();
}

Result<std::string> DiskStore::read(const AssetId& id, const StoredAsset& place, ReadProblem* problem) const {
  ReadProblem found = ReadProblem::Failed;
  auto bytes = state_->read(id, place, found);
  if (!bytes && problem != nullptr) *problem = found;
  return bytes;
}

std::vector<DiskStore::Content> DiskStore::contents() const {
  std::vector<Content> all;
  {
    const std::lock_guard lock(state_->mutex);
    state_->refresh();
    const auto take = [&](const AssetId& id, const StoredAsset& place) {
      all.push_back({id, place.kind, place.bytes, place.storedBytes});
    };
    all.reserve(state_->catalogue.size() + state_->unpublished.size());
    state_->catalogue.forEach(take);
    state_->unpublished.forEach(take);
  }
  std::sort(all.begin(), all.end(), [](const Content& a, const Content& b) { return a.id < b.id; });
  // Another process may have published what this one is writing.
  all.erase(
      std::unique(all.begin(), all.end(), [](const Content& a, const Content& b) { return a.id == b.id; }),
      all.end());
  return all;
}

Status DiskStore::uses(const PackId& id) {
  const std::lock_guard lock(state_->mutex);
  int error = 0;
  const std::shared_ptr<OpenPack> pack = state_->openPack(id, error);
  const std::filesystem::path path = state_->folder.pack(id);
  if (!pack) return storageError(path, "cannot be used", error);
  const int fd = pack->file.fd();
  // Who evicts or mends holds the lock for a moment; mostly the pack is gone after that.
  for (int tries = 0; !pack->isUsed && tries < kLockTries; ++tries) {
    if (tries > 0) std::this_thread::sleep_for(kLockPause);
    if (!isStillAt(fd, path)) break;
    pack->isUsed = tryLock(fd, LockKind::Shared) && isStillAt(fd, path);
  }
  if (!pack->isUsed || !isStillAt(fd, path)) {
    if (!pack->isUsed) state_->openPacks.erase(id);
    return runtimeError(path.string(), "was evicted", "its assets are to be made or fetched again");
  }
  if (state_->options.mayWrite) touch(fd);
  return Done{};
}

}  // namespace tessera
