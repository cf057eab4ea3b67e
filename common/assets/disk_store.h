#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/assets/asset_id.h"
#include "common/assets/mapped_entry.h"
#include "common/assets/stored_asset.h"
#include "common/base/result.h"

namespace tessera {

/// Content-addressed assets and named entries in a folder, for days and over restarts. Assets lie in packs
/// (pack_format.h): files that are written whole, appear by an atomic rename and never change. Several
/// processes may use one folder at once, each writing, reading and evicting; what two of them write twice is
/// harmless. A process that dies at any moment leaves nothing half-written that could be seen.
///
/// Nothing read is trusted: sizes are checked against the file and the limits before memory is taken, an
/// asset's bytes against its id, an entry's against its checksum. But whoever may write the folder may
/// replace an entry by one of his own; the folder is therefore made for its owner alone (mode 0700).
///
/// All members may be called by many threads.
class DiskStore {
 public:
  struct Options {
    std::filesystem::path folder;                        ///< made where it is missing
    std::uint64_t budgetBytes = std::uint64_t{8} << 30;  ///< what evict() brings the folder under
    bool mayWrite = true;                                ///< false: nothing in the folder is ever changed
    std::uint64_t packBytes = std::uint64_t{64} << 20;   ///< about how large a pack becomes
    int zstdLevel = 1;
  };

  /// Opens or makes a store. One error says why that cannot be: a file in the way, no right, a read-only
  /// disk.
  static Result<std::unique_ptr<DiskStore>> open(const Options& options);
  ~DiskStore();
  DiskStore(const DiskStore&) = delete;
  DiskStore& operator=(const DiskStore&) = delete;

  /// Where an asset lies: in a published pack of any process, or in the pack that this one is writing. The
  /// first call reads the catalogues of all packs, later ones only those of packs that appeared since.
  [[nodiscard]] std::optional<StoredAsset> find(const AssetId& id) const;

  /// Stores an asset unless it is there already; `id` is that of the bytes. Others see it from the next
  /// publish() on, or earlier where a pack became full. On an error all that was added before is still there,
  /// save where that pack could not be published.
  Result<StoredAsset> add(const AssetId& id, AssetKind kind, std::span<const std::byte> bytes);

  /// Publishes the pack that is being written. On an error nothing of it is visible, what was in it is
  /// forgotten, and the store goes on.
  Status publish();

  /// The bytes of an asset, whole and verified. On an error `problem` (may be null) says whether it is worth
  /// making or fetching the asset again (Missing, Damaged). A damaged asset is forgotten: find() does not
  /// give that place again; dropDamaged() removes its pack. The place may come from a file.
  [[nodiscard]] Result<std::string> read(const AssetId& id, const StoredAsset& place,
                                         ReadProblem* problem = nullptr) const;

  /// Removes the packs that turned out to be damaged; what is still good in them is first written to a new
  /// one, where find() gives it from then on. Processes that use such a pack have it open and read on.
  /// Returns how many were removed. To be called before what was damaged is added again, at the latest.
  Result<std::size_t> dropDamaged();

  /// Writes an entry, in place of one of the same name. Names are 1 to 128 letters, digits, '.', '_', '-'.
  Status putEntry(const std::string& name, std::span<const std::byte> bytes);

  /// A copy of an entry (mapped_entry.h); none where there is none. One that is damaged or of another version
  /// counts as none: it is removed, and the log says so once. An error: the machine refused.
  [[nodiscard]] Result<std::optional<MappedEntry>> mapEntry(const std::string& name) const;

  struct Content {
    AssetId id;
    AssetKind kind = AssetKind::Drawable;
    std::uint32_t bytes = 0;        ///< of the asset itself
    std::uint32_t storedBytes = 0;  ///< on disk
  };
  /// All assets that find() would find, in order of their ids.
  [[nodiscard]] std::vector<Content> contents() const;

  /// Keeps a pack from being evicted by any process while this store lives. An error where it is gone.
  Status uses(const PackId& pack);

  struct Eviction {
    std::uint64_t bytesBefore = 0, bytesAfter = 0;
    std::size_t removed = 0;  ///< packs and entries
    std::size_t inUse = 0;    ///< were due but are used by a living process
  };
  /// Removes packs and entries, the least recently used first, until the folder is under its budget; never
  /// one in use. Files that are not of the store are left alone and do not count.
  Eviction evict();

 private:
  struct State;
  explicit DiskStore(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tessera
