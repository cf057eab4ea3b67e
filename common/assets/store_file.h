#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "common/base/result.h"

namespace tessera {

/// Owns a file descriptor.
class FileHandle {
 public:
  FileHandle() = default;
  explicit FileHandle(int fd) : fd_(fd) {}
  FileHandle(FileHandle&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileHandle& operator=(FileHandle&& other) noexcept;
  ~FileHandle();

  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] bool isOpen() const { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

/// Opens with O_CLOEXEC. Not open on failure, and errno says why.
[[nodiscard]] FileHandle openFile(const std::filesystem::path& path, int flags, unsigned mode = 0600);

/// Fills `out` from the file at `offset`. False where the file ends before (errno is then 0) or on an error.
[[nodiscard]] bool readAt(int fd, std::span<std::byte> out, std::uint64_t offset);

/// False on an error, errno says which; some bytes may have been written.
[[nodiscard]] bool writeAt(int fd, std::span<const std::byte> bytes, std::uint64_t offset);

/// Size of a regular file; errno and false otherwise.
[[nodiscard]] bool sizeOfFile(int fd, std::uint64_t& bytes);

enum class LockKind { Shared, Exclusive };

/// Takes an advisory lock on an open file (flock) without waiting. It ends with the descriptor, and so with
/// its process, however that ends.
[[nodiscard]] bool tryLock(int fd, LockKind kind);

/// True while `path` is the very file that is open: nobody removed or replaced it.
[[nodiscard]] bool isStillAt(int fd, const std::filesystem::path& path);

/// One error for what the file system refuses. A full disk (ENOSPC, EDQUOT, EFBIG) is told so that a user can
/// mend it.
[[nodiscard]] Error storageError(const std::filesystem::path& where, const std::string& what,
                                 int errorNumber);

/// Writes a folder's own names to the disk, so that a rename survives a power cut.
void syncFolder(const std::filesystem::path& folder);

}  // namespace tessera
