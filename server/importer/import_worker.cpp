#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <new>
#include <set>

#include <sys/stat.h>
#include <unistd.h>

#include "common/assets/store_assets.h"
#include "common/base/sandbox.h"
#include "common/scene/scene_index.h"
#include "server/importer/file_identity.h"
#include "server/importer/import_messages.h"

namespace tessera {

namespace {

using Json = nlohmann::json;

/// What an import needs at least beside the program itself. With less not even a reader can be loaded, and
/// the file would be said to be of an unknown kind.
constexpr std::uint64_t kLeastRoomBytes = 64 << 20;

void answer(const Json& line) {
  const std::string text = line.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

/// Said without memory of its own, as there is none left.
void answerMemory() {
  static constexpr char line[] = "{\"memory\": true}\n";
  (void)!::write(STDOUT_FILENO, line, sizeof line - 1);
}

/// A moment by the clock of files that has passed: whatever changes from now on has a later time.
timespec passedMoment() {
  timespec start{}, now{};
  ::clock_gettime(CLOCK_REALTIME_COARSE, &start);
  now = start;
  for (int tries = 0; tries < 100 && now.tv_sec == start.tv_sec && now.tv_nsec == start.tv_nsec; ++tries) {
    ::usleep(500);
    ::clock_gettime(CLOCK_REALTIME_COARSE, &now);
  }
  return start;
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

/// What the reader may touch. The scene or its folder may be links: what they stand for is readable, too.
SandboxRules rulesOf(const ImportOrder& order) {
  SandboxRules rules{.readable = systemReadable(), .writable = {order.store}};
  const std::filesystem::path folder = std::filesystem::absolute(order.job.scene).parent_path();
  rules.readable.push_back(folder);
  for (const std::filesystem::path& path : {folder, order.job.scene}) {
    std::error_code ec;
    const std::filesystem::path real = std::filesystem::canonical(path, ec);
    if (!ec) rules.readable.push_back(real);
  }
  return rules;
}

Status import(const ImportOrder& order) {
  if (Status limited = limitProcess({.addressSpaceBytes = order.memoryBytes}); !limited) return limited;
  const timespec start = passedMoment();
  auto opened = DiskStore::open({.folder = order.store});
  if (!opened) return opened.error();
  const std::shared_ptr<DiskStore> store = std::move(*opened);
  const std::filesystem::path folder =
      std::filesystem::absolute(order.job.scene).parent_path().lexically_normal();
  const auto confined = confine(rulesOf(order));
  if (!confined) return confined.error();
  if (!confined->missing.empty()) answer({{"confined", confined->missing}});

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

bool hasRoom(std::uint64_t memoryBytes) {
  unsigned long long pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const auto taken = pages * static_cast<unsigned long long>(::sysconf(_SC_PAGESIZE));
  return memoryBytes == 0 || taken + kLeastRoomBytes <= memoryBytes;
}

}  // namespace

int runImportWorker() {
  std::string text;
  std::getline(std::cin, text);
  const auto order = orderFrom(text);
  if (!order) return 2;
  if (!hasRoom(order->memoryBytes)) {
    answerMemory();
    return 1;
  }
  try {
    const Status status = import(*order);
    answer(status ? Json{{"done", true}} : errorJson(status.error()));
    return status ? 0 : status.error().exitStatus();
  } catch (const std::bad_alloc&) {
    answerMemory();
  } catch (const std::exception& e) {
    answer(errorJson(inputError(order->job.scene.string(), std::string("cannot be imported: ") + e.what())));
  }
  return 1;
}

}  // namespace tessera
