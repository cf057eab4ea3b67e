#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/assets/asset.h"

namespace tessera {

/// Names a pack file: random, never used twice.
struct PackId {
  std::array<std::uint8_t, 16> bytes{};
  friend bool operator==(const PackId&, const PackId&) = default;
  friend auto operator<=>(const PackId&, const PackId&) = default;
  [[nodiscard]] static PackId random();
  /// Of 32 lower-case hex digits.
  [[nodiscard]] static std::optional<PackId> fromHex(std::string_view text);
  [[nodiscard]] std::string hex() const;
};

/// Where an asset lies in a store on disk. Plain data that may be kept in files: DiskStore::read checks all
/// of it again.
struct StoredAsset {
  PackId pack;
  std::uint64_t offset = 0;       ///< of the record in the pack file
  std::uint32_t storedBytes = 0;  ///< in the file, perhaps compressed
  std::uint32_t bytes = 0;        ///< of the asset itself
  AssetKind kind = AssetKind::Drawable;
  friend bool operator==(const StoredAsset&, const StoredAsset&) = default;
};

/// Why an asset could not be read.
enum class ReadProblem {
  Missing,  ///< its pack is not there (any more): somebody evicted it
  Damaged,  ///< its pack is there, but the bytes are not those that the id names
  Failed,   ///< the machine refused (files, memory, the disk): the asset may well be good
};

}  // namespace tessera
