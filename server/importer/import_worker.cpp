#include <cstdio>
#include <iostream>
#include <new>
#include <set>

#include <sys/stat.h>

#include "common/assets/store_assets.h"
#include "common/base/sandbox.h"
#include "common/scene/scene_index.h"
#include "server/importer/file_identity.h"
#include "server/importer/import_messages.h"

namespace tessera {

namespace {

using Json = nlohmann::json;

void answer(const Json& line) {
  const std::string text = line.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

/// Whether the file's content or place has changed since then.
bool hasChangedSince(const std::filesystem::path& path, const timespec& then) {
  struct stat facts {};
  if (::stat(path.c_str(), &facts) != 0) return false;
  const auto later = [&](const timespec& time) {
    return time.tv_sec > then.tv_sec || (time.tv_sec == then.tv_sec && time.tv_nsec > then.tv_nsec);
  };
  return later(facts.st_mtim) || later(facts.st_ctim);
}

Error changed(const std::filesystem::path& path) {
  return inputError(path.string(), "was changed while it was imported",
                    "start again once it is written whole");
}

/// Hashes of the files beside the scene; paths in its folder are relative to it, so that the folder may move.
Result<std::vector<SceneDependency>> dependenciesOf(const std::set<std::filesystem::path>& files,
                                                    const std::filesystem::path& folder,
                                                    const timespec& start) {
  std::vector<SceneDependency> dependencies;
  for (const std::filesystem::path& file : files) {
    if (hasChangedSince(file, start)) return changed(file);
    std::error_code ec;
    if (std::filesystem::is_directory(file, ec)) continue;
    const auto hash = hashFile(file);
    if (!hash) return hash.error();
    const std::filesystem::path full = std::filesystem::absolute(file).lexically_normal();
    const std::filesystem::path relative = full.lexically_relative(folder);
    const bool isBelow = !relative.empty() && *relative.begin() != "..";
    dependencies.push_back({isBelow ? relative.string() : full.string(), *hash});
  }
  return dependencies;
}

Status import(const ImportOrder& order) {
  timespec start{};
  ::clock_gettime(CLOCK_REALTIME_COARSE, &start);
  auto opened = DiskStore::open({.folder = order.store});
  if (!opened) return opened.error();
  const std::shared_ptr<DiskStore> store = std::move(*opened);
  const std::filesystem::path folder =
      std::filesystem::absolute(order.job.scene).parent_path().lexically_normal();
  SandboxRules rules{.readable = systemReadable(), .writable = {order.store}};
  rules.readable.push_back(folder);
  if (const auto confined = confine(rules); !confined) return confined.error();

  const auto assets = std::make_shared<StoreAssets>(store);
  auto loaded = loadSceneWithFiles(order.job.scene, {.up = order.job.up,
                                                     .hierarchy = order.job.hierarchy,
                                                     .maxTrianglesPerLeaf = order.job.maxTrianglesPerLeaf,
                                                     .keeper = assets,
                                                     .progress = [last = -1.0](double share) mutable {
                                                       if (share < last + 0.01) return;
                                                       last = share;
                                                       answer({{"progress", share}});
                                                     }});
  if (!loaded) return loaded.error();
  const auto hash = hashFile(order.job.scene);
  if (!hash) return hash.error();
  if (*hash != order.sceneSha256) return changed(order.job.scene);
  const auto dependencies = dependenciesOf(loaded->files, folder, start);
  if (!dependencies) return dependencies.error();
  if (Status status = store->publish(); !status) return status;
  const std::string index = encodeSceneIndex(loaded->scene, assets->places(), *dependencies);
  return store->putEntry(order.entry, std::as_bytes(std::span(index)));
}

}  // namespace

int runImportWorker() {
  std::string text;
  std::getline(std::cin, text);
  const auto order = orderFrom(text);
  if (!order) return 2;
  try {
    const Status status = import(*order);
    answer(status ? Json{{"done", true}} : errorJson(status.error()));
    return status ? 0 : status.error().exitStatus();
  } catch (const std::bad_alloc&) {
    answer({{"memory", true}});
  } catch (const std::exception& e) {
    answer(errorJson(inputError(order->job.scene.string(), std::string("cannot be imported: ") + e.what())));
  }
  return 1;
}

}  // namespace tessera
