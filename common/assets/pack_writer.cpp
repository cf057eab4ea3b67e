#include "common/assets/pack_writer.h"

#include <cerrno>
#include <optional>

#include <unistd.h>

namespace tessera {

Result<PackWriter> PackWriter::create(const StoreFolder& folder) {
  auto file = UnpublishedFile::create(folder);
  if (!file) return file.error();
  const PackHeader header;
  if (!writeAt(file->fd(), std::as_bytes(std::span(&header, 1)), 0)) {
    return storageError(folder.root, "a pack cannot be written", errno);
  }
  return PackWriter(folder, std::move(*file));
}

Result<StoredAsset> PackWriter::add(const AssetId& id, AssetKind kind, std::span<const std::byte> bytes,
                                    int zstdLevel) {
  const std::optional<std::vector<std::byte>> packed = compressAsset(bytes, zstdLevel);
  const std::span<const std::byte> stored = packed ? std::span<const std::byte>(*packed) : bytes;
  const RecordHeader header =
      makeRecordHeader(id, kind, packed ? AssetCodec::Zstd : AssetCodec::Raw,
                       static_cast<std::uint32_t>(stored.size()), static_cast<std::uint32_t>(bytes.size()));
  if (!writeAt(file_.fd(), std::as_bytes(std::span(&header, 1)), end_) ||
      !writeAt(file_.fd(), stored, end_ + sizeof header)) {
    const int error = errno;
    // What was written of it would be overwritten by the next, but its space is needed now.
    [[maybe_unused]] const int ignored = ::ftruncate(file_.fd(), static_cast<off_t>(end_));
    return storageError(folder_.root, "an asset cannot be written", error);
  }
  entries_.push_back(
      {.id = id, .offset = end_, .storedBytes = header.storedBytes, .bytes = header.bytes, .kind = kind});
  const StoredAsset place{id_, end_, header.storedBytes, header.bytes, kind};
  end_ += sizeof header + stored.size();
  return place;
}

bool PackWriter::isFullFor(std::size_t bytes, std::uint64_t packBytes) const {
  const std::uint64_t after =
      end_ + sizeof(RecordHeader) + bytes + (entries_.size() + 1) * sizeof(PackEntry) + sizeof(PackTrailer);
  return !entries_.empty() &&
         (after > packBytes || after > kMaxPackBytes || entries_.size() >= kMaxPackRecords);
}

Status PackWriter::publish() {
  const std::vector<std::byte> catalogue = makeCatalogue(entries_, end_);
  if (!writeAt(file_.fd(), catalogue, end_)) {
    return storageError(folder_.root, "a pack cannot be finished", errno);
  }
  return file_.publishAs(folder_.pack(id_));
}

}  // namespace tessera
