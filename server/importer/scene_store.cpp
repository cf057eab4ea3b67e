#include "server/importer/scene_store.h"

#include <cstdlib>
#include <optional>
#include <set>
#include <utility>

#include <spdlog/spdlog.h>
#include <unistd.h>

#include "common/assets/store_assets.h"
#include "common/assets/store_folder.h"
#include "server/importer/file_identity.h"

namespace tessera {

namespace {

/// A scene whose file or neighbours are just being written may be whole a moment later.
constexpr int kTries = 2;

std::string entryNameOf(const ImportJob& job, const std::string& sceneHash) {
  // The extension says which reader is used.
  const std::string facts = std::to_string(kSceneIndexVersion) + " " + sceneHash + " " +
                            job.scene.extension().string() + " " + std::to_string(static_cast<int>(job.up)) +
                            " " + std::to_string(static_cast<int>(job.hierarchy)) + " " +
                            std::to_string(job.maxTrianglesPerLeaf);
  return "scene-" + hashText(facts);
}

/// A folder that goes with the process.
class TemporaryFolder {
 public:
  static Result<std::shared_ptr<TemporaryFolder>> make() {
    std::string path = (std::filesystem::temp_directory_path() / "tessera-store-XXXXXX").string();
    if (!::mkdtemp(path.data())) return runtimeError(path, "cannot be made", "name a folder with --store");
    return std::make_shared<TemporaryFolder>(path);
  }
  explicit TemporaryFolder(std::filesystem::path path) : path_(std::move(path)) {}
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  const std::filesystem::path path_;
};

struct Store {
  // In this order: the folder goes last.
  std::shared_ptr<TemporaryFolder> temporary;
  std::shared_ptr<DiskStore> disk;
  std::filesystem::path folder;
};

Result<Store> openStore(const std::filesystem::path& folder, const SceneStoreOptions& options,
                        bool mayWrite) {
  auto disk = DiskStore::open({.folder = folder, .budgetBytes = options.budgetBytes, .mayWrite = mayWrite});
  if (!disk) return disk.error();
  return Store{nullptr, std::move(*disk), folder};
}

bool areUnchanged(const std::vector<SceneDependency>& files, const std::filesystem::path& folder,
                  DiskStore& memory) {
  for (const SceneDependency& file : files) {
    const auto hash = hashFile(folder / file.path, memory);
    if (!hash || *hash != file.sha256) return false;
  }
  return true;
}

/// None: it is not in the store as it is now.
Result<std::optional<OpenedScene>> find(const Store& store, const ImportJob& job, const std::string& entry) {
  auto mapped = store.disk->mapEntry(entry);
  if (!mapped) return mapped.error();
  if (!*mapped) return std::optional<OpenedScene>();
  const auto keeper = std::make_shared<std::pair<std::shared_ptr<TemporaryFolder>, MappedEntry>>(
      store.temporary, std::move(**mapped));
  const std::span<std::byte> bytes = keeper->second.bytes();
  auto index = openSceneIndex(bytes, keeper);
  if (!index) return std::optional<OpenedScene>();
  const auto folder = std::filesystem::absolute(job.scene).parent_path();
  if (!areUnchanged(index->dependencies, folder, *store.disk)) return std::optional<OpenedScene>();
  OpenedScene opened;
  opened.scene = std::move(index->scene);
  opened.scene.source = job.scene.string();
  opened.indexBytes = bytes.size();
  opened.folder = store.folder;
  for (const StoredAsset& place : index->places)
    opened.storedBytes += place.storedBytes;
  auto assets = StoreAssets::open(store.disk, std::move(index->places));
  if (!assets) return std::optional<OpenedScene>();  // a pack was evicted: make it anew
  opened.scene.assets.keepIn(std::move(*assets));
  return std::optional(std::move(opened));
}

Result<OpenedScene> importInto(const Store& store, const ImportJob& job, const std::string& entry,
                               const std::string& hash, const SceneStoreOptions& options) {
  const ImportOrder order{.job = job, .store = store.folder, .entry = entry, .sceneSha256 = hash};
  if (Status status = runImportProcess(order, options.limits, options.progress); !status)
    return status.error();
  auto found = find(store, job, entry);
  if (!found) return found.error();
  if (!*found) {
    // The worker has seen it whole; since then something is another.
    return inputError(
        job.scene.string(), "it or a file beside it was changed while it was imported",
        "start again once all is written, and let no other program clear " + store.folder.string());
  }
  (*found)->wasImported = true;
  store.disk->evict();
  return std::move(**found);
}

}  // namespace

Result<OpenedScene> openScene(const ImportJob& job, const SceneStoreOptions& options) {
  std::error_code ec;
  if (!std::filesystem::exists(job.scene, ec))
    return inputError(job.scene.string(), "no such file", "check the path");
  if (!std::filesystem::is_regular_file(job.scene, ec))
    return inputError(job.scene.string(), "is not a file");
  auto folder = options.folder.empty() ? defaultCacheFolder("scenes") : Result(options.folder);
  auto store = folder ? openStore(*folder, options, true) : Result<Store>(folder.error());
  const std::optional<Error> readOnly = store ? std::optional<Error>() : store.error();
  if (readOnly && folder) store = openStore(*folder, options, false);
  for (int tries = 0;; ++tries) {
    const auto hash = store ? hashFile(job.scene, *store->disk) : hashFile(job.scene);
    if (!hash) return hash.error();
    const std::string entry = entryNameOf(job, *hash);
    if (store) {
      auto found = find(*store, job, entry);
      if (!found) return found.error();
      if (*found) return std::move(**found);
    }
    if (readOnly) {
      spdlog::warn("{}; a temporary folder is used, and the scene is imported at every start",
                   readOnly->text());
      auto temporary = TemporaryFolder::make();
      if (!temporary) return temporary.error();
      auto made = openStore((*temporary)->path(), options, true);
      if (!made) return made.error();
      made->temporary = std::move(*temporary);
      return importInto(*made, job, entry, *hash, options);
    }
    auto imported = importInto(*store, job, entry, *hash, options);
    if (imported || tries + 1 == kTries) return imported;
    const auto now = hashFile(job.scene, *store->disk);
    if (!now || *now == *hash) return imported;
  }
}

}  // namespace tessera
