#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/assets/store_file.h"
#include "common/assets/stored_asset.h"
#include "common/base/result.h"

namespace tessera {

/// Where a store lies if the user names no place: $XDG_CACHE_HOME/tessera/SUB or ~/.cache/tessera/SUB.
/// The error says that there is no home folder.
[[nodiscard]] Result<std::filesystem::path> defaultCacheFolder(std::string_view sub);

/// The folders of a store on disk.
struct StoreFolder {
  std::filesystem::path root;
  [[nodiscard]] std::filesystem::path packs() const { return root / "packs"; }
  [[nodiscard]] std::filesystem::path entries() const { return root / "entries"; }
  [[nodiscard]] std::filesystem::path unpublished() const { return root / "tmp"; }
  [[nodiscard]] std::filesystem::path pack(const PackId& id) const { return packs() / (id.hex() + ".pack"); }
};

/// Makes the folders that are missing (mode 0700) or says in one error why the store cannot be there:
/// a file in the way, no right, a read-only disk, a folder that everybody may write. Where `mayWrite` is
/// false nothing is made, and a missing folder is an error.
[[nodiscard]] Status prepareFolder(const StoreFolder& folder, bool mayWrite);

/// Removes what processes that ended before publishing left; files of living ones are locked and stay.
void removeLeftovers(const StoreFolder& folder);

/// A new file in the folder of unpublished ones, locked by this process, so that removeLeftovers of another
/// one lets it be. Removed when this goes away unless it was published.
class UnpublishedFile {
 public:
  static Result<UnpublishedFile> create(const StoreFolder& folder);
  UnpublishedFile(UnpublishedFile&& other) noexcept;
  UnpublishedFile& operator=(UnpublishedFile&&) = delete;
  ~UnpublishedFile();

  [[nodiscard]] int fd() const { return file_.fd(); }
  /// Writes all to the disk and gives the file its name, in place of one that is there. On an error the file
  /// stays unpublished, and is to be thrown away: what a failed write left behind is not known.
  Status publishAs(const std::filesystem::path& path);

 private:
  UnpublishedFile(FileHandle file, std::filesystem::path path)
      : file_(std::move(file)), path_(std::move(path)) {}
  FileHandle file_;
  std::filesystem::path path_;  ///< empty once published
};

}  // namespace tessera
