// Named entries of a store on disk.

#include <cerrno>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "common/assets/disk_store_state.h"
#include "common/base/log.h"

namespace tessera {

namespace fs = std::filesystem;

Status DiskStore::putEntry(const std::string& name, std::span<const std::byte> bytes) {
  const StoreFolder& folder = state_->folder;
  if (!state_->options.mayWrite) {
    return runtimeError(folder.root.string(), "the store was opened for reading alone");
  }
  if (!isEntryName(name)) {
    return inputError(name, "is not a name for an entry", "use letters, digits, '.', '_' and '-'");
  }
  auto file = UnpublishedFile::create(folder);
  if (!file) return file.error();
  const std::vector<std::byte> header = makeEntryHeader(name, bytes);
  if (!writeAt(file->fd(), header, 0) || !writeAt(file->fd(), bytes, header.size())) {
    return storageError(folder.root, "an entry cannot be written", errno);
  }
  return file->publishAs(folder.entries() / name);
}

Result<std::optional<MappedEntry>> DiskStore::mapEntry(const std::string& name) const {
  const StoreFolder& folder = state_->folder;
  if (!isEntryName(name)) return std::optional<MappedEntry>();
  const fs::path path = folder.entries() / name;
  FileHandle file = openFile(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
  if (!file.isOpen()) {
    if (errno == ENOENT || errno == ELOOP) return std::optional<MappedEntry>();
    return storageError(path, "cannot be opened", errno);
  }
  const bool mayWrite = state_->options.mayWrite;
  // Without the lock the entry may be evicted meanwhile, which harms nobody who has it open.
  if (tryLock(file.fd(), LockKind::Shared) && mayWrite) touch(file.fd());
  const FileHandle same(::fcntl(file.fd(), F_DUPFD_CLOEXEC, 0));
  EntryProblem problem{};
  auto entry = copyEntry(folder, name, std::move(file), problem);
  if (entry) return std::optional<MappedEntry>(std::move(*entry));
  if (problem == EntryProblem::Failed) return entry.error();

  // Somebody may have put a good one in its place in the meantime; that one stays.
  if (mayWrite && isStillAt(same.fd(), path)) ::unlink(path.c_str());
  const std::lock_guard lock(state_->mutex);
  if (state_->complained.insert(name).second) {
    spdlog::warn("{}; it is {}", entry.error().text(), mayWrite ? "made anew" : "not used");
  }
  return std::optional<MappedEntry>();
}

}  // namespace tessera
