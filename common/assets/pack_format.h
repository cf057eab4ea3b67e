#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/assets/asset_codec.h"
#include "common/assets/asset_id.h"
#include "common/assets/stored_asset.h"

// A pack on disk, little-endian, written once:
//   PackHeader, then records (RecordHeader and the stored bytes), then the catalogue (a PackEntry for each
//   record), then PackTrailer, which ends the file.
// The trailer's checksum covers catalogue and trailer, so opening needs no scan; where they are damaged the
// records can still be found one by one. An asset's bytes need no checksum, its id is one.
namespace tessera {

static_assert(std::endian::native == std::endian::little, "packs are written as they lie in memory");

inline constexpr std::uint32_t kPackVersion = 1;
/// No pack is larger or holds more; a writer begins the next one.
inline constexpr std::uint64_t kMaxPackBytes = std::uint64_t{1} << 31;
inline constexpr std::uint32_t kMaxPackRecords = 1u << 20;

struct PackHeader {
  std::array<char, 8> magic{'T', 'E', 'S', 'S', 'P', 'A', 'C', 'K'};
  std::uint32_t version = kPackVersion;
  std::uint32_t reserved = 0;
};
static_assert(sizeof(PackHeader) == 16);

struct RecordHeader {
  std::array<char, 4> magic{'T', 'R', 'E', 'C'};
  AssetKind kind{};
  AssetCodec codec{};
  std::uint16_t reserved = 0;
  AssetId id;
  std::uint32_t storedBytes = 0;
  std::uint32_t bytes = 0;
  std::array<std::uint8_t, 8> check{};  ///< the first bytes of the SHA-256 of what stands before
};
static_assert(sizeof(RecordHeader) == 56);

struct PackEntry {
  AssetId id;
  std::uint64_t offset = 0;  ///< of the RecordHeader
  std::uint32_t storedBytes = 0;
  std::uint32_t bytes = 0;
  AssetKind kind{};
  std::array<std::uint8_t, 7> reserved{};
};
static_assert(sizeof(PackEntry) == 56);

struct PackTrailer {
  std::uint64_t catalogueOffset = 0;
  std::uint32_t recordCount = 0;
  std::uint32_t version = kPackVersion;
  AssetId check;  ///< SHA-256 of the catalogue and of the trailer with this field zero
  std::array<char, 8> magic{'T', 'E', 'S', 'S', 'P', 'E', 'N', 'D'};
};
static_assert(sizeof(PackTrailer) == 56);

[[nodiscard]] RecordHeader makeRecordHeader(const AssetId& id, AssetKind kind, AssetCodec codec,
                                            std::uint32_t storedBytes, std::uint32_t bytes);
/// Magic, check, kind, codec and sizes are good; whether the file is long enough is for the caller to see.
[[nodiscard]] bool isGood(const RecordHeader& header);
/// A place that may be read in a file of `fileBytes`.
[[nodiscard]] bool isGood(const StoredAsset& place, std::uint64_t fileBytes);

/// Catalogue and trailer for the end of a pack.
[[nodiscard]] std::vector<std::byte> makeCatalogue(std::span<const PackEntry> entries,
                                                   std::uint64_t catalogueOffset);

/// What stands in a pack file.
struct PackContents {
  enum class State {
    Good,
    Recovered,     ///< the catalogue is damaged, these records were found one by one
    OtherVersion,  ///< written by another version of this program: none of our business
    Unreadable,    ///< not a pack, or none of it can be found
    Failed,        ///< the machine refused, errno says why
  };
  State state = State::Unreadable;
  std::vector<PackEntry> entries;
};

/// Reads the catalogue of untrusted bytes; each place lies in the file, whether it holds what it says is
/// seen when it is read.
[[nodiscard]] PackContents readContents(int fd);

}  // namespace tessera
