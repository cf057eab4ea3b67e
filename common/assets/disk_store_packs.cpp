// Packs of a store on disk: finding, reading, writing and mending them.

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/assets/disk_store_state.h"
#include "common/assets/pack_format.h"
#include "common/assets/pack_reader.h"
#include "common/base/log.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

/// Packs that are held open only because they may be read again soon.
constexpr std::size_t kOpenPacks = 64;
/// How often reading counts as a use.
constexpr std::chrono::seconds kTouchEvery{60};
/// A folder that changed so shortly before it was read may change again without another time of change.
constexpr std::int64_t kSettledNs = 50'000'000;

std::int64_t nanoseconds(const timespec& t) {
  return t.tv_sec * 1'000'000'000 + t.tv_nsec;
}

}  // namespace

void touch(int fd) {
  ::futimens(fd, nullptr);
}

void DiskStore::State::refresh() {
  struct stat status {};
  if (::stat(folder.packs().c_str(), &status) != 0) return;
  const std::int64_t changed = nanoseconds(status.st_mtim);
  if (isLoaded && changed == foundAtNs) return;
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  isLoaded = true;
  foundAtNs = nanoseconds(now) - changed > kSettledNs ? changed : -1;
  std::set<PackId> there;
  std::error_code ec;
  for (fs::directory_iterator it(folder.packs(), ec), end; !ec && it != end; it.increment(ec)) {
    const fs::path& path = it->path();
    if (path.extension() != ".pack") continue;
    if (const auto id = PackId::fromHex(path.stem().string())) there.insert(*id);
  }
  if (ec) return;  // Half a list is no reason to forget the other half.
  std::set<PackId> gone;
  std::set_difference(known.begin(), known.end(), there.begin(), there.end(),
                      std::inserter(gone, gone.end()));
  if (!gone.empty()) forgetPacks(gone);
  for (const PackId& id : there) {
    if (!known.contains(id)) loadPack(id);
  }
}

void DiskStore::State::loadPack(const PackId& id) {
  const fs::path path = folder.pack(id);
  const FileHandle file = openFile(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
  if (!file.isOpen()) return;
  const PackContents contents = readContents(file.fd());
  switch (contents.state) {
    case PackContents::State::Failed:
      return;  // It may be better the next time.
    case PackContents::State::Good:
    case PackContents::State::OtherVersion:
      break;
    case PackContents::State::Recovered:
    case PackContents::State::Unreadable:
      spdlog::warn("{}: the pack is damaged; {} of its assets were found", path.string(),
                   contents.entries.size());
      damaged.insert(id);
  }
  known.insert(id);
  for (const PackEntry& e : contents.entries) {
    catalogue.add(e.id, {id, e.offset, e.storedBytes, e.bytes, e.kind});
  }
}

void DiskStore::State::forgetPacks(const std::set<PackId>& packs) {
  catalogue.forget(packs);
  for (const PackId& id : packs) {
    known.erase(id);
    damaged.erase(id);
    // What this process uses it reads on, gone from the folder or not.
    if (const auto open = openPacks.find(id); open != openPacks.end() && !open->second->isUsed) {
      openPacks.erase(open);
    }
  }
}

std::optional<StoredAsset> DiskStore::State::find(const AssetId& id) {
  if (const StoredAsset* found = unpublished.find(id)) return *found;
  if (isLoaded) {
    if (const StoredAsset* found = catalogue.find(id)) return *found;
  }
  refresh();
  const StoredAsset* found = catalogue.find(id);
  return found == nullptr ? std::nullopt : std::optional(*found);
}

Result<StoredAsset> DiskStore::State::append(const AssetId& id, AssetKind kind,
                                             std::span<const std::byte> bytes) {
  if (writer && writer->isFullFor(bytes.size(), options.packBytes)) {
    if (Status done = publish(); !done) return done.error();
  }
  if (!writer) {
    auto created = PackWriter::create(folder);
    if (!created) return created.error();
    writer.emplace(std::move(*created));
  }
  auto place = writer->add(id, kind, bytes, options.zstdLevel);
  if (place) unpublished.add(id, *place);
  return place;
}

Status DiskStore::State::publish() {
  if (!writer) return Done{};
  Status done = writer->entries().empty() ? Status(Done{}) : writer->publish();
  if (done && isLoaded) {
    known.insert(writer->id());
    unpublished.forEach([&](const AssetId& id, const StoredAsset& place) { catalogue.add(id, place); });
  }
  unpublished = {};
  writer.reset();
  return done;
}

std::shared_ptr<OpenPack> DiskStore::State::openPack(const PackId& id, int& errorNumber) {
  if (const auto found = openPacks.find(id); found != openPacks.end()) {
    found->second->lastRead = ++reads;
    return found->second;
  }
  auto pack = std::make_shared<OpenPack>();
  pack->file = openFile(folder.pack(id), O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
  errorNumber = errno;
  if (!pack->file.isOpen()) return nullptr;
  pack->lastRead = ++reads;
  openPacks.emplace(id, pack);
  auto oldest = openPacks.end();
  std::size_t unused = 0;
  for (auto it = openPacks.begin(); it != openPacks.end(); ++it) {
    if (it->second->isUsed) continue;
    ++unused;
    if (oldest == openPacks.end() || it->second->lastRead < oldest->second->lastRead) oldest = it;
  }
  if (unused > kOpenPacks) openPacks.erase(oldest);
  return pack;
}

bool DiskStore::State::noteUse(OpenPack& pack) const {
  const auto now = std::chrono::steady_clock::now();
  if (pack.touched && now - *pack.touched < kTouchEvery) return false;
  pack.touched = now;
  if (options.mayWrite) touch(pack.file.fd());
  return true;
}

std::optional<StoredAsset> DiskStore::State::findAndUse(const AssetId& id) {
  for (;;) {
    const auto place = find(id);
    if (!place || (writer && writer->id() == place->pack)) return place;
    int error = 0;
    const std::shared_ptr<OpenPack> pack = openPack(place->pack, error);
    if (pack && isStillAt(pack->file.fd(), folder.pack(place->pack))) {
      noteUse(*pack);
      return place;
    }
    // Evicted by another process; there may be another copy. That the machine refuses is no reason to look
    // on.
    if (!pack && error != ENOENT) return std::nullopt;
    forgetPacks({place->pack});
  }
}

Result<std::string> DiskStore::State::read(const AssetId& id, const StoredAsset& place,
                                           ReadProblem& problem) {
  const fs::path path = folder.pack(place.pack);
  std::shared_ptr<OpenPack> pack;
  {
    const std::lock_guard lock(mutex);
    if (writer && writer->id() == place.pack) {
      auto bytes = readRecord(writer->fd(), folder.root.string(), id, place, problem);
      if (!bytes && problem == ReadProblem::Damaged) unpublished.forget(id, place);
      return bytes;
    }
    int error = 0;
    pack = openPack(place.pack, error);
    if (!pack && error == ENOENT) {
      forgetPacks({place.pack});
      problem = ReadProblem::Missing;
      return runtimeError(path.string(), "was evicted", "its assets are to be made or fetched again");
    }
    if (!pack) {
      problem = ReadProblem::Failed;
      return storageError(path, "cannot be opened", error);
    }
    // What somebody evicted is read to the end but not held on to, for its space is only then free.
    if (noteUse(*pack) && !isStillAt(pack->file.fd(), path)) forgetPacks({place.pack});
  }
  auto bytes = readRecord(pack->file.fd(), path.string(), id, place, problem);
  if (!bytes && problem == ReadProblem::Damaged) {
    const std::lock_guard lock(mutex);
    refresh();  // A catalogue that is read later would bring the place back.
    catalogue.forget(id, place);
    if (damaged.insert(place.pack).second) spdlog::warn("{}", bytes.error().text());
  }
  return bytes;
}

}  // namespace tessera
