#include "common/assets/store_folder.h"

#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tessera {

namespace fs = std::filesystem;

namespace {

/// A folder of mode 0700 and those above it. False and errno where that fails.
bool makeFolders(const fs::path& path) {
  if (::mkdir(path.c_str(), 0700) == 0 || errno == EEXIST) return true;
  if (errno != ENOENT || !path.has_parent_path() || path.parent_path() == path) return false;
  return makeFolders(path.parent_path()) && (::mkdir(path.c_str(), 0700) == 0 || errno == EEXIST);
}

Status prepareOne(const fs::path& path, bool mayWrite) {
  if (mayWrite && !makeFolders(path)) return storageError(path, "cannot be created", errno);
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return storageError(path, "cannot be opened", errno);
  if (!S_ISDIR(status.st_mode)) {
    return inputError(path.string(), "is not a folder", "remove the file or use another folder");
  }
  if ((status.st_mode & S_IWOTH) != 0) {
    return inputError(path.string(), "everybody may write this folder", "chmod 700 it or use another folder");
  }
  if (::access(path.c_str(), mayWrite ? R_OK | W_OK | X_OK : R_OK | X_OK) != 0) {
    return storageError(path, mayWrite ? "cannot be written" : "cannot be read", errno);
  }
  return Done{};
}

}  // namespace

Result<fs::path> defaultCacheFolder(std::string_view sub) {
  fs::path base;
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if (cache != nullptr && cache[0] == '/') {  // A relative one is to be ignored, says the convention.
    base = cache;
  } else if (home != nullptr && home[0] == '/') {
    base = fs::path(home) / ".cache";
  } else {
    passwd entry{};
    passwd* found = nullptr;
    std::vector<char> buffer(16384);
    ::getpwuid_r(::getuid(), &entry, buffer.data(), buffer.size(), &found);
    if (found == nullptr || found->pw_dir == nullptr || found->pw_dir[0] != '/') {
      return inputError("XDG_CACHE_HOME", "there is no home folder to keep a cache in", "set it to a folder");
    }
    base = fs::path(found->pw_dir) / ".cache";
  }
  return base / "tessera" / sub;
}

Status prepareFolder(const StoreFolder& folder, bool mayWrite) {
  for (const fs::path& path : {folder.root, folder.packs(), folder.entries(), folder.unpublished()}) {
    if (Status done = prepareOne(path, mayWrite); !done) return done;
  }
  return Done{};
}

void removeLeftovers(const StoreFolder& folder) {
  std::error_code ec;
  for (fs::directory_iterator it(folder.unpublished(), ec), end; !ec && it != end; it.increment(ec)) {
    if (it->path().extension() != ".tmp") continue;
    const FileHandle file = openFile(it->path(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
    if (file.isOpen() && tryLock(file.fd(), LockKind::Exclusive)) ::unlink(it->path().c_str());
  }
}

Result<UnpublishedFile> UnpublishedFile::create(const StoreFolder& folder) {
  constexpr int kTries = 100;
  for (int i = 0; i < kTries; ++i) {
    const fs::path path = folder.unpublished() / (PackId::random().hex() + ".tmp");
    FileHandle file = openFile(path, O_RDWR | O_CREAT | O_EXCL);
    if (!file.isOpen()) return storageError(folder.root, "a file cannot be created", errno);
    // Another process may take a file for a left-over one before it is locked.
    if (tryLock(file.fd(), LockKind::Exclusive) && isStillAt(file.fd(), path)) {
      return UnpublishedFile(std::move(file), path);
    }
    ::unlink(path.c_str());
  }
  return runtimeError(folder.root.string(), "a new file was removed again and again",
                      "see who else cleans this folder");
}

UnpublishedFile::UnpublishedFile(UnpublishedFile&& other) noexcept
    : file_(std::move(other.file_)), path_(std::exchange(other.path_, {})) {}

UnpublishedFile::~UnpublishedFile() {
  if (!path_.empty()) ::unlink(path_.c_str());
}

Status UnpublishedFile::publishAs(const fs::path& path) {
  if (::fsync(file_.fd()) != 0) return storageError(path.parent_path(), "cannot be written to disk", errno);
  if (::rename(path_.c_str(), path.c_str()) != 0) return storageError(path, "cannot be put in place", errno);
  path_.clear();
  syncFolder(path.parent_path());
  return Done{};
}

}  // namespace tessera
