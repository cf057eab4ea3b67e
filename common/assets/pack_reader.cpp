#include "common/assets/pack_reader.h"

#include <cerrno>
#include <utility>
#include <vector>

#include "common/assets/pack_format.h"
#include "common/assets/store_file.h"

namespace tessera {

namespace {

constexpr const char* kMend = "the asset is to be made or fetched again";

Error damage(const std::string& name, const AssetId& id, const std::string& what, ReadProblem& problem) {
  problem = ReadProblem::Damaged;
  return runtimeError(name, "asset " + id.hex().substr(0, 16) + " " + what, kMend);
}

/// Of a read that failed: a file that ends too soon and a bad block are damage, all else is the machine's.
Error unread(const std::string& name, const AssetId& id, ReadProblem& problem) {
  const int error = errno;
  if (error == 0 || error == EIO) return damage(name, id, "cannot be read whole", problem);
  problem = ReadProblem::Failed;
  return storageError(name, "cannot be read", error);
}

}  // namespace

Result<std::string> readRecord(int fd, const std::string& name, const AssetId& id, const StoredAsset& place,
                               ReadProblem& problem) {
  std::uint64_t fileBytes = 0;
  errno = 0;
  if (!sizeOfFile(fd, fileBytes)) return unread(name, id, problem);
  if (!isGood(place, fileBytes)) return damage(name, id, "lies outside of the file", problem);
  RecordHeader header;
  if (!readAt(fd, std::as_writable_bytes(std::span(&header, 1)), place.offset))
    return unread(name, id, problem);
  if (!isGood(header) || header.id != id || header.storedBytes != place.storedBytes ||
      header.bytes != place.bytes || header.kind != place.kind) {
    return damage(name, id, "is not where it should be", problem);
  }
  std::string bytes;
  const std::uint64_t start = place.offset + sizeof header;
  if (header.codec == AssetCodec::Raw) {
    bytes.resize(header.bytes);
    if (!readAt(fd, std::as_writable_bytes(std::span(bytes)), start)) return unread(name, id, problem);
  } else {
    std::vector<std::byte> stored(header.storedBytes);
    if (!readAt(fd, stored, start)) return unread(name, id, problem);
    auto unpacked = decompressAsset(stored, header.bytes);
    if (!unpacked) return damage(name, id, "does not unpack", problem);
    bytes = std::move(*unpacked);
  }
  if (assetIdOf(std::as_bytes(std::span(bytes))) != id) return damage(name, id, "has other bytes", problem);
  return bytes;
}

}  // namespace tessera
