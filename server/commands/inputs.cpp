#include "server/commands/inputs.h"

#include <spdlog/spdlog.h>

#include "common/scene/load_scene.h"
#include "common/wall/wall_file.h"
#include "server/default_camera.h"

namespace tessera {

void InputFiles::addWall(CLI::App& app) {
  app.add_option("--wall", wall, "Wall file (JSON, see configs/wall.schema.json)")
      ->required()
      ->envname("TESSERA_WALL");
}

void InputFiles::addScene(CLI::App& app) {
  app.add_option("--scene", scene, "Scene: glTF 2.0 (.gltf, .glb) or any format OpenSceneGraph reads")
      ->required()
      ->envname("TESSERA_SCENE");
  addUp(app);
}

void InputFiles::addUp(CLI::App& app) {
  app.add_option("--up", up, "Which way is up in a scene that is not glTF: auto, y or z")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "y", "z"}))
      ->envname("TESSERA_UP");
}

void InputFiles::addCamera(CLI::App& app) {
  app.add_option("--camera", camera,
                 "Camera path (JSON, see configs/camera.schema.json); default: once around the scene")
      ->envname("TESSERA_CAMERA");
}

Result<Wall> InputFiles::readWall() const {
  auto read = readWallFile(wall);
  if (read) {
    for (const std::string& warning : read->warnings)
      spdlog::warn("{}: {}", wall, warning);
  }
  return read;
}

Result<Scene> InputFiles::readScene() const {
  auto read = loadScene(scene, up == "y" ? UpAxis::Y : up == "z" ? UpAxis::Z : UpAxis::Auto);
  if (read) {
    for (const std::string& warning : read->warnings)
      spdlog::warn("{}: {}", scene, warning);
  }
  return read;
}

Result<CameraPath> InputFiles::readCamera() const {
  return camera.empty() ? parseCameraPath(kDefaultCamera, "configs/orbit.camera.json")
                        : readCameraPath(camera);
}

void CullFlags::add(CLI::App& app) {
  app.add_option("--algorithm", algorithm, "How to cull: none, naive, oh or adaptive")
      ->capture_default_str()
      ->envname("TESSERA_ALGORITHM");
  app.add_option("--bounds", bounds, "What to cull by: sphere, aabb or obb")
      ->capture_default_str()
      ->envname("TESSERA_BOUNDS");
}

Result<cull::Options> CullFlags::options() const {
  const auto chosenAlgorithm = cull::algorithmFromName(algorithm);
  if (!chosenAlgorithm) {
    return inputError("--algorithm", "there is no algorithm named \"" + algorithm + "\"",
                      "choose none, naive, oh or adaptive");
  }
  const auto chosenBounds = cull::boundsFromName(bounds);
  if (!chosenBounds) {
    return inputError("--bounds", "there are no bounds named \"" + bounds + "\"",
                      "choose sphere, aabb or obb");
  }
  return cull::Options{.algorithm = *chosenAlgorithm, .bounds = *chosenBounds};
}

}  // namespace tessera
