#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include <nlohmann/json.hpp>

#include "common/base/file.h"
#include "server/commands/commands.h"
#include "server/commands/inputs.h"

namespace tessera {

namespace {

struct ImportFlags {
  InputFiles files;
  std::string json;
};

Status importScene(const ImportFlags& flags) {
  const auto start = std::chrono::steady_clock::now();
  const auto opened = flags.files.openScene();
  if (!opened) return opened.error();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const Scene& scene = opened->scene;
  std::printf("%s: %zu leaves, %llu triangles; %zu assets of %.1f MB (%.1f MB stored), index %.1f MB\n",
              opened->wasImported ? "imported" : "in the store", scene.leaves.size(),
              static_cast<unsigned long long>(scene.triangleCount()), scene.assets.size(),
              static_cast<double>(scene.assets.bytes()) / 1e6, static_cast<double>(opened->storedBytes) / 1e6,
              static_cast<double>(opened->indexBytes) / 1e6);
  std::printf("%.2f s, %s\n", seconds, opened->folder.c_str());
  if (flags.json.empty()) return Done{};
  const nlohmann::ordered_json report = {{"format", "tessera-import"},
                                         {"version", 1},
                                         {"scene", scene.source},
                                         {"store", opened->folder.string()},
                                         {"was_imported", opened->wasImported},
                                         {"seconds", seconds},
                                         {"leaves", scene.leaves.size()},
                                         {"triangles", scene.triangleCount()},
                                         {"assets", scene.assets.size()},
                                         {"asset_bytes", scene.assets.bytes()},
                                         {"stored_bytes", opened->storedBytes},
                                         {"index_bytes", opened->indexBytes},
                                         {"warnings", scene.warnings}};
  return writeFileAtomically(flags.json, report.dump(1) + "\n");
}

}  // namespace

void addImportCommand(CLI::App& tessera, std::vector<Command>& commands) {
  CLI::App* app = tessera.add_subcommand(
      "import", "Reads a scene into the store, in a process of its own; run and serve do it by themselves");
  auto flags = std::make_shared<ImportFlags>();
  app->add_option("SCENE", flags->files.scene,
                  "Scene: glTF 2.0 (.gltf, .glb) or any format OpenSceneGraph reads")
      ->required();
  flags->files.addUp(*app);
  flags->files.addHierarchy(*app);
  flags->files.addStore(*app);
  app->add_option("--json", flags->json, "Write what was found to this file");
  commands.push_back({app, [flags] { return importScene(*flags); }});
}

}  // namespace tessera
