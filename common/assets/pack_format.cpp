#include "common/assets/pack_format.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "common/assets/store_file.h"

namespace tessera {

namespace {

std::array<std::uint8_t, 8> checkOf(const RecordHeader& header) {
  std::array<std::uint8_t, 8> check;
  const AssetId digest = assetIdOf(std::as_bytes(std::span(&header, 1)).first(offsetof(RecordHeader, check)));
  std::copy_n(digest.bytes.begin(), check.size(), check.begin());
  return check;
}

bool isKnown(AssetKind kind) {
  return kind <= AssetKind::Image;
}

/// The catalogue at the end of the file; false unless it is whole and its checksum good.
bool readCatalogue(int fd, std::uint64_t fileBytes, std::vector<PackEntry>& entries) {
  if (fileBytes < sizeof(PackHeader) + sizeof(PackTrailer)) return false;
  PackTrailer trailer;
  if (!readAt(fd, std::as_writable_bytes(std::span(&trailer, 1)), fileBytes - sizeof trailer)) return false;
  if (trailer.magic != PackTrailer{}.magic || trailer.version != kPackVersion) return false;
  const std::uint64_t catalogueBytes = std::uint64_t{trailer.recordCount} * sizeof(PackEntry);
  if (trailer.recordCount > kMaxPackRecords || trailer.catalogueOffset < sizeof(PackHeader) ||
      trailer.catalogueOffset > fileBytes ||
      fileBytes - trailer.catalogueOffset != catalogueBytes + sizeof trailer) {
    return false;
  }
  std::vector<std::byte> bytes(catalogueBytes + sizeof trailer);
  if (!readAt(fd, bytes, trailer.catalogueOffset)) return false;
  std::memset(bytes.data() + catalogueBytes + offsetof(PackTrailer, check), 0, sizeof trailer.check);
  if (assetIdOf(bytes) != trailer.check) return false;
  entries.resize(trailer.recordCount);
  if (!entries.empty()) std::memcpy(entries.data(), bytes.data(), catalogueBytes);
  return std::all_of(entries.begin(), entries.end(), [&](const PackEntry& e) {
    return isGood(
        StoredAsset{
            .pack = {}, .offset = e.offset, .storedBytes = e.storedBytes, .bytes = e.bytes, .kind = e.kind},
        trailer.catalogueOffset);
  });
}

/// The records that can be found from the start on.
std::vector<PackEntry> scanRecords(int fd, std::uint64_t fileBytes) {
  std::vector<PackEntry> entries;
  std::uint64_t offset = sizeof(PackHeader);
  RecordHeader header;
  while (entries.size() < kMaxPackRecords && offset + sizeof header <= fileBytes &&
         readAt(fd, std::as_writable_bytes(std::span(&header, 1)), offset) && isGood(header)) {
    const PackEntry entry{.id = header.id,
                          .offset = offset,
                          .storedBytes = header.storedBytes,
                          .bytes = header.bytes,
                          .kind = header.kind};
    offset += sizeof header + header.storedBytes;
    if (offset > fileBytes) break;
    entries.push_back(entry);
  }
  return entries;
}

}  // namespace

RecordHeader makeRecordHeader(const AssetId& id, AssetKind kind, AssetCodec codec, std::uint32_t storedBytes,
                              std::uint32_t bytes) {
  RecordHeader header;
  header.kind = kind;
  header.codec = codec;
  header.id = id;
  header.storedBytes = storedBytes;
  header.bytes = bytes;
  header.check = checkOf(header);
  return header;
}

bool isGood(const RecordHeader& header) {
  return header.magic == RecordHeader{}.magic && header.check == checkOf(header) && isKnown(header.kind) &&
         header.bytes <= kMaxAssetBytes && header.storedBytes <= header.bytes &&
         (header.codec == AssetCodec::Zstd ||
          (header.codec == AssetCodec::Raw && header.storedBytes == header.bytes));
}

bool isGood(const StoredAsset& place, std::uint64_t fileBytes) {
  return isKnown(place.kind) && place.bytes <= kMaxAssetBytes && place.storedBytes <= place.bytes &&
         place.offset >= sizeof(PackHeader) && place.offset <= fileBytes &&
         sizeof(RecordHeader) + place.storedBytes <= fileBytes - place.offset;
}

std::vector<std::byte> makeCatalogue(std::span<const PackEntry> entries, std::uint64_t catalogueOffset) {
  PackTrailer trailer;
  trailer.catalogueOffset = catalogueOffset;
  trailer.recordCount = static_cast<std::uint32_t>(entries.size());
  std::vector<std::byte> bytes(entries.size_bytes() + sizeof trailer);
  if (!entries.empty()) std::memcpy(bytes.data(), entries.data(), entries.size_bytes());
  std::byte* end = bytes.data() + entries.size_bytes();
  std::memcpy(end, &trailer, sizeof trailer);
  trailer.check = assetIdOf(bytes);
  std::memcpy(end, &trailer, sizeof trailer);
  return bytes;
}

PackContents readContents(int fd) {
  using State = PackContents::State;
  PackContents contents;
  std::uint64_t fileBytes = 0;
  errno = 0;
  if (!sizeOfFile(fd, fileBytes)) return {State::Failed, {}};
  if (fileBytes > kMaxPackBytes) return contents;
  if (readCatalogue(fd, fileBytes, contents.entries)) {
    contents.state = State::Good;
    return contents;
  }
  PackHeader header;
  header.magic = {};
  errno = 0;
  if (!readAt(fd, std::as_writable_bytes(std::span(&header, 1)), 0) && errno != 0) return {State::Failed, {}};
  if (header.magic != PackHeader{}.magic) return {State::Unreadable, {}};
  if (header.version != kPackVersion) return {State::OtherVersion, {}};
  return {State::Recovered, scanRecords(fd, fileBytes)};
}

}  // namespace tessera
