// Keeping a store on disk under its budget.

#include <algorithm>
#include <cerrno>
#include <optional>
#include <tuple>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/assets/disk_store_state.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

struct Candidate {
  fs::path path;
  std::optional<PackId> pack;  ///< none: an entry
  std::uint64_t bytes = 0;
  std::int64_t usedS = 0;
  std::int64_t usedNs = 0;
};

/// Files of the store in one of its folders.
template <class PackOf>
void collect(const fs::path& folder, PackOf packOf, std::vector<Candidate>& all) {
  std::error_code ec;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec)) {
    Candidate candidate;
    candidate.path = it->path();
    struct stat status {};
    if (!packOf(candidate) || ::lstat(candidate.path.c_str(), &status) != 0 || !S_ISREG(status.st_mode))
      continue;
    candidate.bytes = static_cast<std::uint64_t>(status.st_size);
    candidate.usedS = status.st_mtim.tv_sec;
    candidate.usedNs = status.st_mtim.tv_nsec;
    all.push_back(std::move(candidate));
  }
}

enum class Removal { Done, InUse, Refused };

Removal removeUnlessUsed(const fs::path& path) {
  const FileHandle file = openFile(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
  if (!file.isOpen()) return errno == ENOENT ? Removal::Done : Removal::Refused;
  if (!tryLock(file.fd(), LockKind::Exclusive)) return Removal::InUse;
  // Another evictor was quicker, and an entry may have been written anew since.
  if (!isStillAt(file.fd(), path)) return Removal::Done;
  return ::unlink(path.c_str()) == 0 ? Removal::Done : Removal::Refused;
}

}  // namespace

DiskStore::Eviction DiskStore::evict() {
  State& state = *state_;
  std::vector<Candidate> all;
  collect(
      state.folder.packs(),
      [](Candidate& c) {
        if (c.path.extension() == ".pack") c.pack = PackId::fromHex(c.path.stem().string());
        return c.pack.has_value();
      },
      all);
  collect(
      state.folder.entries(), [](const Candidate& c) { return isEntryName(c.path.filename().string()); },
      all);
  std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.usedS, a.usedNs, a.path) < std::tie(b.usedS, b.usedNs, b.path);
  });
  Eviction result;
  for (const Candidate& c : all)
    result.bytesBefore += c.bytes;
  result.bytesAfter = result.bytesBefore;
  if (!state.options.mayWrite) return result;

  std::set<PackId> gone;
  for (const Candidate& c : all) {
    if (result.bytesAfter <= state.options.budgetBytes) break;
    const Removal removal = removeUnlessUsed(c.path);
    if (removal == Removal::InUse) ++result.inUse;
    if (removal != Removal::Done) continue;
    result.bytesAfter -= c.bytes;
    ++result.removed;
    if (c.pack) gone.insert(*c.pack);
  }
  const std::lock_guard lock(state.mutex);
  if (!gone.empty()) state.forgetPacks(gone);
  return result;
}

}  // namespace tessera
