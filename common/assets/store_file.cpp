#include "common/assets/store_file.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tessera {

namespace fs = std::filesystem;

FileHandle& FileHandle::operator=(FileHandle&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

FileHandle::~FileHandle() {
  if (fd_ >= 0) ::close(fd_);
}

FileHandle openFile(const fs::path& path, int flags, unsigned mode) {
  int fd;
  do {
    fd = ::open(path.c_str(), flags | O_CLOEXEC, mode);
  } while (fd < 0 && errno == EINTR);
  return FileHandle(fd);
}

bool readAt(int fd, std::span<std::byte> out, std::uint64_t offset) {
  while (!out.empty()) {
    const ssize_t n = ::pread(fd, out.data(), out.size(), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n == 0) errno = 0;
    if (n <= 0) return false;
    out = out.subspan(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
  return true;
}

bool writeAt(int fd, std::span<const std::byte> bytes, std::uint64_t offset) {
  while (!bytes.empty()) {
    const ssize_t n = ::pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n == 0) errno = EIO;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
  return true;
}

bool sizeOfFile(int fd, std::uint64_t& bytes) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) return false;
  if (!S_ISREG(status.st_mode)) {
    errno = EINVAL;
    return false;
  }
  bytes = static_cast<std::uint64_t>(status.st_size);
  return true;
}

bool tryLock(int fd, LockKind kind) {
  int result;
  do {
    result = ::flock(fd, (kind == LockKind::Shared ? LOCK_SH : LOCK_EX) | LOCK_NB);
  } while (result != 0 && errno == EINTR);
  return result == 0;
}

bool isStillAt(int fd, const fs::path& path) {
  struct stat open {};
  struct stat named {};
  return ::fstat(fd, &open) == 0 && ::lstat(path.c_str(), &named) == 0 && open.st_dev == named.st_dev &&
         open.st_ino == named.st_ino;
}

Error storageError(const fs::path& where, const std::string& what, int errorNumber) {
  const std::string text = what + ": " + std::strerror(errorNumber);
  switch (errorNumber) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return runtimeError(where.string(), text, "free space there or use a folder on another disk");
    case EACCES:
    case EPERM:
    case EROFS:
      return inputError(where.string(), text, "use a folder that this user may write");
    case EMFILE:
    case ENFILE:
      return runtimeError(where.string(), text, "allow more open files (ulimit -n)");
    default:
      return runtimeError(where.string(), text);
  }
}

void syncFolder(const fs::path& folder) {
  const FileHandle handle = openFile(folder, O_RDONLY | O_DIRECTORY);
  if (handle.isOpen()) ::fsync(handle.fd());  // Some file systems cannot; the rename itself is atomic anyway.
}

}  // namespace tessera
