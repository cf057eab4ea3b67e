#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "common/assets/asset_catalogue.h"
#include "common/assets/disk_store.h"
#include "common/assets/pack_writer.h"
#include "common/assets/store_folder.h"

namespace tessera {

/// A pack file that is open for reading.
struct OpenPack {
  FileHandle file;
  bool isUsed = false;  ///< locked against eviction
  std::optional<std::chrono::steady_clock::time_point> touched;
  std::uint64_t lastRead = 0;
};

/// What is behind a DiskStore. The mutex guards all but the options and the folder.
struct DiskStore::State {
  Options options;
  StoreFolder folder;

  std::mutex mutex;
  bool isLoaded = false;
  std::int64_t foundAtNs = -1;  ///< time of change of the pack folder when it was last read, -1: unknown
  std::set<PackId> known;       ///< packs whose catalogues were read
  std::set<PackId> damaged;
  AssetCatalogue catalogue;
  std::map<PackId, std::shared_ptr<OpenPack>> openPacks;
  std::uint64_t reads = 0;
  std::optional<PackWriter> writer;
  AssetCatalogue unpublished;
  std::set<std::string> complained;  ///< entries

  // To be called with the mutex held.
  void refresh();
  void loadPack(const PackId& id);
  void forgetPacks(const std::set<PackId>& packs);
  Status publish();
  bool salvage(const PackId& id, Status& status);
  Result<StoredAsset> append(const AssetId& id, AssetKind kind, std::span<const std::byte> bytes);
  std::shared_ptr<OpenPack> openPack(const PackId& id, int& errorNumber);
  std::optional<StoredAsset> find(const AssetId& id);
  std::optional<StoredAsset> findAndUse(const AssetId& id);
  bool noteUse(OpenPack& pack) const;

  // To be called without it.
  Result<std::string> read(const AssetId& id, const StoredAsset& place, ReadProblem& problem);
};

/// Marks a file as used now, for the order of eviction. Not an error where that is forbidden.
void touch(int fd);

}  // namespace tessera
