#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "common/assets/disk_store.h"
#include "common/base/result.h"
#include "common/scene/scene.h"
#include "common/scene/scene_index.h"
#include "server/importer/import_process.h"

namespace tessera {

struct SceneStoreOptions {
  std::filesystem::path folder;  ///< empty: by the platform's convention
  std::uint64_t budgetBytes = std::uint64_t{16} << 30;
  ImportLimits limits = {};
  /// Told the share of an import that is done; may be empty.
  std::function<void(double)> progress = {};
};

/// A scene and how it was had.
struct OpenedScene {
  Scene scene;
  bool wasImported = false;                       ///< else it was in the store
  std::uint64_t indexBytes = 0, storedBytes = 0;  ///< of the index; of the assets on disk
  std::filesystem::path folder;
};

/// A scene from the store, imported before where it is not there or has changed since: its file's content,
/// that of every file beside it that was looked for, and how it is imported are what it is known by. The
/// scene's arrays are mapped, its assets are read when they are asked for. Where the folder cannot be written
/// a temporary one is used, which is said once.
[[nodiscard]] Result<OpenedScene> openScene(const ImportJob& job, const SceneStoreOptions& options);

}  // namespace tessera
