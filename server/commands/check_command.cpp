#include <cstdio>
#include <memory>

#include "common/base/file.h"
#include "common/wall/wall_svg.h"
#include "common/wall/wall_writer.h"
#include "server/commands/commands.h"
#include "server/commands/inputs.h"
#include "server/master/tile_setup.h"

namespace tessera {

namespace {

struct CheckFlags {
  InputFiles files;
  std::string svg;
  bool printsConfig = false;
};

Status check(const CheckFlags& flags) {
  const auto wall = flags.files.readWall();
  if (!wall) return wall.error();
  if (flags.printsConfig) {
    std::fputs(writeWall(*wall).c_str(), stdout);
    return Done{};
  }
  const auto setups = TileSetups::make(*wall);
  if (!setups) return setups.error();
  std::printf("wall:   %s\n", summaryOf(*wall).c_str());
  if (setups->warpErrorPx() > 0) std::printf("warps:  exact to %.3f pixels\n", setups->warpErrorPx());
  if (!flags.svg.empty()) {
    if (Status status = writeFileAtomically(flags.svg, wallSvg(*wall)); !status) return status;
    std::printf("drawn:  %s\n", flags.svg.c_str());
  }
  if (!flags.files.camera.empty()) {
    const auto camera = flags.files.readCamera();
    if (!camera) return camera.error();
    std::printf("camera: %zu keyframes over %.1f s\n", camera->keyframes().size(),
                camera->keyframes().back().timeS - camera->keyframes().front().timeS);
  }
  if (!flags.files.scene.empty()) {
    const auto scene = flags.files.readScene();
    if (!scene) return scene.error();
    std::printf("scene:  %zu leaves, %llu triangles\n", scene->leaves.size(),
                static_cast<unsigned long long>(scene->triangleCount()));
  }
  return Done{};
}

}  // namespace

void addCheckCommand(CLI::App& tessera, std::vector<Command>& commands) {
  CLI::App* app = tessera.add_subcommand("check", "Says whether the files are good, and draws the wall");
  auto flags = std::make_shared<CheckFlags>();
  flags->files.addWall(*app);
  app->add_option("--scene", flags->files.scene, "Scene to check as well");
  flags->files.addUp(*app);
  flags->files.addStore(*app);
  app->add_option("--camera", flags->files.camera, "Camera path to check as well");
  app->add_option("--svg", flags->svg, "Draw the wall into this file");
  app->add_flag("--print-config", flags->printsConfig,
                "Print the wall file as it is understood, with every default and every flag, and do no more");
  commands.push_back({app, [flags] { return check(*flags); }});
}

}  // namespace tessera
