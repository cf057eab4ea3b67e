#include "common/assets/mapped_entry.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/mman.h>
#include <unistd.h>

namespace tessera {

namespace {

static_assert(std::endian::native == std::endian::little, "entries are written as they lie in memory");

constexpr std::uint32_t kEntryVersion = 1;
constexpr std::size_t kMaxNameBytes = 128;
constexpr std::size_t kCopyBytes = std::size_t{1} << 20;

struct EntryHeader {
  std::array<char, 8> magic{'T', 'E', 'S', 'S', 'N', 'T', 'R', 'Y'};
  std::uint32_t version = kEntryVersion;
  std::uint32_t reserved = 0;
  std::uint64_t payloadBytes = 0;
  AssetId check;  ///< SHA-256 of the header with this field zero, and of the payload
  std::array<char, kMaxNameBytes> name{};
  std::array<char, 8> padding{};
};
static_assert(sizeof(EntryHeader) == 192);

/// SHA-256 and not a short checksum, for what an entry says is used as it is: no damage may pass by chance.
/// It costs a quarter of a second for 100 MB on a processor without instructions for it.
class Sha256 {
 public:
  Sha256() { EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr); }
  void update(std::span<const std::byte> bytes) {
    EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size());
  }
  AssetId finish() {
    AssetId digest;
    EVP_DigestFinal_ex(context_.get(), digest.bytes.data(), nullptr);
    return digest;
  }

 private:
  struct Free {
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
  };
  std::unique_ptr<EVP_MD_CTX, Free> context_{EVP_MD_CTX_new()};
};

EntryHeader unchecked(const std::string& name, std::uint64_t payloadBytes) {
  EntryHeader header;
  header.payloadBytes = payloadBytes;
  std::copy_n(name.begin(), std::min(name.size(), kMaxNameBytes), header.name.begin());
  return header;
}

/// A file of `bytes` that has no name and ends with its descriptor; not open where there is no room for it.
FileHandle privateFile(const StoreFolder& folder, std::uint64_t bytes) {
  FileHandle file = openFile(folder.unpublished(), O_TMPFILE | O_RDWR | O_EXCL);
  if (!file.isOpen()) {
    auto named = UnpublishedFile::create(folder);  // Its name goes away at the end of this block.
    if (named) file = openFile("/proc/self/fd/" + std::to_string(named->fd()), O_RDWR);
  }
  if (file.isOpen() && ::posix_fallocate(file.fd(), 0, static_cast<off_t>(bytes)) != 0) return FileHandle();
  return file;
}

}  // namespace

MappedEntry::MappedEntry(MappedEntry&& other) noexcept
    : base_(std::exchange(other.base_, nullptr)),
      size_(std::exchange(other.size_, 0)),
      file_(std::move(other.file_)) {}

MappedEntry& MappedEntry::operator=(MappedEntry&& other) noexcept {
  std::swap(base_, other.base_);
  std::swap(size_, other.size_);
  std::swap(file_, other.file_);
  return *this;
}

MappedEntry::~MappedEntry() {
  if (base_ != nullptr) ::munmap(base_, size_);
}

bool isEntryName(const std::string& name) {
  return !name.empty() && name.size() <= kMaxNameBytes && name[0] != '.' &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
                  c == '_' || c == '-';
         });
}

std::vector<std::byte> makeEntryHeader(const std::string& name, std::span<const std::byte> bytes) {
  EntryHeader header = unchecked(name, bytes.size());
  Sha256 sha;
  sha.update(std::as_bytes(std::span(&header, 1)));
  sha.update(bytes);
  header.check = sha.finish();
  const auto raw = std::as_bytes(std::span(&header, 1));
  return {raw.begin(), raw.end()};
}

/// Makes a MappedEntry step by step.
struct EntryCopier {
  FileHandle source;
  MappedEntry entry{};

  /// Memory for the payload; false where there is none.
  bool map(int fd, std::size_t bytes) {
    if (bytes == 0) return true;
    void* base = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                        fd < 0 ? MAP_PRIVATE | MAP_ANONYMOUS : MAP_PRIVATE, fd, 0);
    if (base == MAP_FAILED) return false;
    entry.base_ = base;
    entry.size_ = bytes;
    return true;
  }

  /// Copies into a private file and maps it, or into plain memory where `copy` is not open; digests what is
  /// handed out. False: errno says why, 0 that the source became shorter.
  bool copy(const FileHandle& copy, std::size_t bytes, Sha256& sha) {
    if (!copy.isOpen() && !map(-1, bytes)) return false;
    std::vector<std::byte> block(copy.isOpen() ? std::min(bytes, kCopyBytes) : 0);
    for (std::size_t done = 0; done < bytes;) {
      const std::size_t n = std::min(bytes - done, kCopyBytes);
      const std::span<std::byte> to =
          copy.isOpen() ? std::span(block).first(n) : entry.bytes().subspan(done, n);
      if (!readAt(source.fd(), to, sizeof(EntryHeader) + done)) return false;
      if (copy.isOpen() && !writeAt(copy.fd(), to, done)) return false;
      sha.update(to);
      done += n;
    }
    return !copy.isOpen() || map(copy.fd(), bytes);
  }

  MappedEntry finish() {
    entry.file_ = std::move(source);
    return std::move(entry);
  }
};

Result<MappedEntry> copyEntry(const StoreFolder& folder, const std::string& name, FileHandle file,
                              EntryProblem& problem) {
  const std::string where = (folder.entries() / name).string();
  const auto damaged = [&](const char* what) -> Error {
    problem = EntryProblem::Damaged;
    return runtimeError(where, what);
  };
  const auto failed = [&]() -> Error {
    const int error = errno;
    if (error == 0 || error == EIO) return damaged("cannot be read whole");
    problem = EntryProblem::Failed;
    return storageError(where, "cannot be read", error);
  };
  std::uint64_t fileBytes = 0;
  errno = 0;
  if (!sizeOfFile(file.fd(), fileBytes)) return failed();
  EntryHeader header;
  if (!readAt(file.fd(), std::as_writable_bytes(std::span(&header, 1)), 0)) return failed();
  EntryHeader expected = unchecked(name, header.payloadBytes);
  if (header.magic != expected.magic || header.version != expected.version) {
    return damaged("is of another format or version");
  }
  if (header.payloadBytes != fileBytes - sizeof header) return damaged("is not as long as it says");
  const AssetId check = std::exchange(header.check, {});
  if (std::memcmp(&header, &expected, sizeof header) != 0) return damaged("has another name");

  Sha256 sha;
  sha.update(std::as_bytes(std::span(&header, 1)));
  EntryCopier copier{std::move(file)};
  if (!copier.copy(privateFile(folder, header.payloadBytes), header.payloadBytes, sha)) return failed();
  if (sha.finish() != check) return damaged("has another checksum");
  return copier.finish();
}

}  // namespace tessera
