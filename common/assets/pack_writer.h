#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/assets/pack_format.h"
#include "common/assets/store_folder.h"

namespace tessera {

/// A pack that is being written, in a file of its own that nobody else reads. Used by one thread at a time;
/// what was added may be read through fd() meanwhile.
class PackWriter {
 public:
  static Result<PackWriter> create(const StoreFolder& folder);

  /// Appends an asset, compressed where that pays. On an error the pack is as it was before.
  Result<StoredAsset> add(const AssetId& id, AssetKind kind, std::span<const std::byte> bytes, int zstdLevel);

  /// True where another asset of that size would make the pack larger than `packBytes` or than any may be;
  /// never for the first one.
  [[nodiscard]] bool isFullFor(std::size_t bytes, std::uint64_t packBytes) const;

  /// Writes the catalogue and publishes the pack, once. After an error nothing is visible, and this is to be
  /// thrown away: what a failed write to disk left behind is not known.
  Status publish();

  [[nodiscard]] const PackId& id() const { return id_; }
  [[nodiscard]] int fd() const { return file_.fd(); }
  [[nodiscard]] std::span<const PackEntry> entries() const { return entries_; }

 private:
  PackWriter(const StoreFolder& folder, UnpublishedFile file) : folder_(folder), file_(std::move(file)) {}

  StoreFolder folder_;
  UnpublishedFile file_;
  PackId id_ = PackId::random();
  std::uint64_t end_ = sizeof(PackHeader);
  std::vector<PackEntry> entries_;
};

}  // namespace tessera
