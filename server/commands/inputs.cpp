#include "server/commands/inputs.h"

#include <array>
#include <chrono>
#include <filesystem>
#include <numbers>

#include <spdlog/spdlog.h>

#include "common/cull/footprint/kernels.h"
#include "common/wall/wall_file.h"
#include "server/commands/progress.h"
#include "server/default_camera.h"

namespace tessera {

void InputFiles::addWall(CLI::App& app) {
  app.add_option("--wall", wall, "Wall file (JSON, see configs/wall.schema.json)")
      ->required()
      ->envname("TESSERA_WALL");
  app.add_option("--fov", fovYDeg, "Vertical field of view in degrees, instead of the wall file's")
      ->check(CLI::Range(kMinFovYDeg, kMaxFovYDeg))
      ->envname("TESSERA_FOV");
  app.add_option("--near", near, "Distance of the near clip plane, instead of the wall file's")
      ->check(CLI::Range(1e-9, 1e15))
      ->envname("TESSERA_NEAR");
  app.add_option("--far", far, "Distance of the far clip plane, instead of the wall file's")
      ->check(CLI::Range(1e-9, 1e15))
      ->envname("TESSERA_FAR");
  app.add_option("--eye", eyeM,
                 "Where the observer stands in the room, x,y,z in metres, instead of the wall file's")
      ->delimiter(',')
      ->expected(3)
      ->check(CLI::Range(-kMaxRoomM, kMaxRoomM))
      ->envname("TESSERA_EYE");
  app.add_option("--scale", scale, "Lengths of the scene for a metre of the room, instead of the wall file's")
      ->check(CLI::Range(1e-9, 1e9))
      ->envname("TESSERA_SCALE");
}

void InputFiles::addScene(CLI::App& app) {
  app.add_option("--scene", scene, "Scene: glTF 2.0 (.gltf, .glb) or any format OpenSceneGraph reads")
      ->required()
      ->envname("TESSERA_SCENE");
  addUp(app);
  addStore(app);
}

void InputFiles::addStore(CLI::App& app) {
  const char* group = "Imported scenes";
  app.add_option("--store", store,
                 "Folder in which imported scenes are kept; default: $XDG_CACHE_HOME/tessera/scenes or "
                 "~/.cache/tessera/scenes")
      ->group(group)
      ->envname("TESSERA_STORE");
  app.add_option("--store-budget", storeBudgetBytes,
                 "Most bytes that the folder may take, such as 4GB; what was not used longest goes first")
      ->group(group)
      ->transform(CLI::AsSizeValue(false))
      ->envname("TESSERA_STORE_BUDGET");
  app.add_option("--import-timeout", importTimeoutS, "Seconds that an import may take")
      ->group(group)
      ->capture_default_str()
      ->check(CLI::Range(0.1, 86400.0))
      ->envname("TESSERA_IMPORT_TIMEOUT");
  app.add_option("--import-memory", importMemoryBytes,
                 "Memory that an import may take, such as 4GB; default: three quarters of the machine's")
      ->group(group)
      ->transform(CLI::AsSizeValue(false))
      ->envname("TESSERA_IMPORT_MEMORY");
}

void InputFiles::addUp(CLI::App& app) {
  app.add_option("--up", up, "Which way is up in a scene that is not glTF: auto, y or z")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "y", "z"}))
      ->envname("TESSERA_UP");
}

void InputFiles::addHierarchy(CLI::App& app) {
  app.add_option(
         "--hierarchy", hierarchy,
         "How leaves are grouped for culling: graph (as in the file), bvh, octree, loose-octree or kd")
      ->capture_default_str()
      ->check(CLI::IsMember({"graph", "bvh", "octree", "loose-octree", "kd"}))
      ->envname("TESSERA_HIERARCHY");
  app.add_option(
         "--mtpl", maxTrianglesPerLeaf,
         "Most triangles of a leaf: larger meshes are cut, and spatial hierarchies group smaller ones; "
         "0: leaves as in the file")
      ->capture_default_str()
      ->envname("TESSERA_MTPL");
}

void InputFiles::addCamera(CLI::App& app) {
  app.add_option("--camera", camera,
                 "Camera path (JSON, see configs/camera.schema.json); default: once around the scene")
      ->envname("TESSERA_CAMERA");
}

Status InputFiles::override(Wall& read) const {
  if (fovYDeg && read.observer)
    return inputError("--fov", "with an observer the field of view follows from where the eye stands",
                      "move the eye: --eye x,y,z");
  if (fovYDeg) read.fovYRad = *fovYDeg * (std::numbers::pi / 180);
  if (near) read.near = *near;
  if (far) read.far = *far;
  if (read.near && read.far && !(*read.near < *read.far))
    return inputError("--near", "the near clip plane is not before the far one", "choose other distances");
  if ((!eyeM.empty() || scale) && !read.observer)
    return inputError(eyeM.empty() ? "--scale" : "--eye", "the wall has no observer",
                      "add \"observer\": {\"eye_m\": [x, y, z]} to " + wall);
  if (scale) read.observer->scale = *scale;
  if (eyeM.empty()) return Done{};
  read.observer->eyeM = Vec3(eyeM[0], eyeM[1], eyeM[2]);
  if (const auto screen = screenNotBefore(read, read.observer->eyeM))
    return inputError(
        "--eye", "the eye lies in the plane of screen \"" + read.screens[*screen].name + "\" or behind it",
        "stand before every screen");
  return Done{};
}

Result<Wall> InputFiles::readWall() const {
  auto read = readWallFile(wall);
  if (!read) {
    // The walls of other systems are no JSON, or not ours.
    const std::string extension = std::filesystem::path(wall).extension().string();
    if (extension != ".eqc" && extension != ".xml" && extension != ".mpcdi") return read;
    return inputError(wall, "this is another system's wall",
                      "tessera wall import " + wall + " --out wall.json");
  }
  if (read) {
    if (Status status = override(*read); !status) return status.error();
    for (const std::string& warning : read->warnings)
      spdlog::warn("{}: {}", wall, warning);
  }
  return read;
}

UpAxis InputFiles::upAxis() const {
  return up == "y" ? UpAxis::Y : up == "z" ? UpAxis::Z : UpAxis::Auto;
}

Result<OpenedScene> InputFiles::openScene() const {
  constexpr std::uint64_t kPercent = 100;
  Progress progress("% imported", kPercent);
  const auto start = std::chrono::steady_clock::now();
  SceneStoreOptions options;
  options.folder = store;
  options.budgetBytes = storeBudgetBytes;
  options.limits = {.time = std::chrono::milliseconds(static_cast<long long>(importTimeoutS * 1000)),
                    .memoryBytes = importMemoryBytes};
  options.progress = [&](double share) {
    // Most imports are done before anybody has read a line.
    if (std::chrono::steady_clock::now() - start < std::chrono::seconds(2)) return;
    progress.update(static_cast<std::uint64_t>(share * kPercent));
  };
  auto opened = tessera::openScene({.scene = scene,
                                    .up = upAxis(),
                                    .hierarchy = *hierarchyFromName(hierarchy),
                                    .maxTrianglesPerLeaf = maxTrianglesPerLeaf},
                                   options);
  progress.finish();
  if (opened) {
    for (const std::string& warning : opened->scene.warnings)
      spdlog::warn("{}: {}", scene, warning);
  }
  return opened;
}

Result<Scene> InputFiles::readScene() const {
  auto opened = openScene();
  if (!opened) return opened.error();
  return std::move(opened->scene);
}

Result<CameraPath> InputFiles::readCamera() const {
  return camera.empty() ? parseCameraPath(kDefaultCamera, "configs/orbit.camera.json")
                        : readCameraPath(camera);
}

void StreamFlags::add(CLI::App& app) {
  const char* group = "Streaming";
  app.add_option(
         "--on-miss", onMiss,
         "When geometry that a tile sees is not there yet: wait (the wall waits for it), box (its box in "
         "its mean colour stands for it) or skip (it is left out)")
      ->group(group)
      ->capture_default_str()
      ->check(CLI::IsMember({"wait", "box", "skip"}))
      ->envname("TESSERA_ON_MISS");
  app.add_option(
         "--upload-budget", options.uploadBytes,
         "Most bytes of geometry that a tile is sent in a frame, such as 2MB; with --on-miss wait, of what "
         "is sent ahead")
      ->group(group)
      ->transform(CLI::AsSizeValue(false))
      ->envname("TESSERA_UPLOAD_BUDGET");
  app.add_option(
         "--upload-ms", options.uploadMs,
         "With --on-miss box or skip: most milliseconds of a frame that a tile spends on making geometry "
         "and textures drawable; 0: as long as it takes")
      ->group(group)
      ->capture_default_str()
      ->check(CLI::Range(0.0F, 10'000.0F))
      ->envname("TESSERA_UPLOAD_MS");
  app.add_option("--predict", options.predictFrames,
                 "Send geometry ahead, for so many frames of the camera's motion; 0: none")
      ->group(group)
      ->capture_default_str()
      ->check(CLI::Range(0U, 10'000U))
      ->envname("TESSERA_PREDICT");
}

StreamOptions StreamFlags::stream() const {
  StreamOptions stream = options;
  stream.onMiss = onMiss == "box"    ? proto::OnMiss::Box
                  : onMiss == "skip" ? proto::OnMiss::Skip
                                     : proto::OnMiss::Wait;
  // The wall waits for what is seen, however long that takes.
  if (stream.onMiss == proto::OnMiss::Wait) stream.uploadMs = 0;
  return stream;
}

namespace {

struct SwitchFlag {
  const char* name;
  bool cull::Switches::*value;
  bool byDefault;
  const char* what;
};

// A switch that is on by default is turned off by --no-NAME.
constexpr std::array kSwitches = {
    SwitchFlag{"first-level", &cull::Switches::firstLevel, true,
               "do not cull to the primary frustum before the tiles"},
    SwitchFlag{"plane-masking", &cull::Switches::planeMasking, true,
               "test planes again below nodes that are inside of them"},
    SwitchFlag{"plane-coherency", &cull::Switches::planeCoherency, false,
               "test the plane first that rejected last time"},
    SwitchFlag{"octant-test", &cull::Switches::octantTest, false,
               "of two opposite planes test the nearer one alone"},
    SwitchFlag{"sign-table", &cull::Switches::signTable, false,
               "p- and n-vertex by a table of signs (--bounds aabb)"},
    SwitchFlag{"sphere-first", &cull::Switches::sphereFirst, false,
               "a sphere first, then the box where the sphere is cut"},
    SwitchFlag{"motion-coherence", &cull::Switches::motionCoherence, false,
               "remember distances to rejecting planes from frame to frame"},
    SwitchFlag{"regroup", &cull::Switches::regroup, false,
               "adaptive: regroup children on one side of a bisection"},
    SwitchFlag{"refine", &cull::Switches::refine, true,
               "footprint, table: list leaves in their whole rectangle of tiles, not row by row"},
};

}  // namespace

void CullFlags::add(CLI::App& app) {
  app.add_option(
         "--algorithm", algorithm,
         "How to cull: auto (chooses), footprint, table, adaptive, adaptive-listing, fh, oh, naive or none")
      ->capture_default_str()
      ->envname("TESSERA_ALGORITHM");
  app.add_option("--bounds", bounds, "What to cull by: sphere, aabb, obb, hybrid or aabb-then-obb")
      ->capture_default_str()
      ->envname("TESSERA_BOUNDS");
  app.add_option("--planes", planes,
                 "Culling: the tiles' sides from their corners, or from the view-projection matrix")
      ->capture_default_str()
      ->check(CLI::IsMember({"corners", "matrix"}))
      ->group("Switches of the cullers");
  app.add_option("--coherent", coherent,
                 "Culling: table: keep footprints while they certainly hold: never, always, measured (while "
                 "it spares more than it costs)")
      ->capture_default_str()
      ->check(CLI::IsMember({"never", "always", "measured"}))
      ->group("Switches of the cullers");
  app.add_option("--cull-threads", threads,
                 "Culling: footprint, table: at most so many threads; 0: one for each core")
      ->capture_default_str()
      ->check(CLI::Range(0u, 1024u))
      ->envname("TESSERA_CULL_THREADS")
      ->group("Switches of the cullers");
  for (const SwitchFlag& flag : kSwitches) {
    const std::string name = std::string("--") + (flag.byDefault ? "no-" : "") + flag.name;
    app.add_flag_callback(
           name, [this, &flag] { switches.*flag.value = !flag.byDefault; },
           std::string("Culling: ") + flag.what)
        ->group("Switches of the cullers");
  }
  app.add_option("--regroup-from", switches.regroupFrom, "Culling: the fewest children that --regroup groups")
      ->capture_default_str()
      ->check(CLI::Range(2u, 1u << 30))
      ->group("Switches of the cullers");
}

std::vector<std::string> CullFlags::changedSwitches() const {
  std::vector<std::string> changed;
  for (const SwitchFlag& flag : kSwitches) {
    if (switches.*flag.value != flag.byDefault)
      changed.push_back(std::string(flag.byDefault ? "no-" : "") + flag.name);
  }
  if (planes != "corners") changed.push_back("planes " + planes);
  if (coherent != "measured") changed.push_back("coherent " + coherent);
  return changed;
}

std::string CullFlags::text() const {
  std::string text = algorithm + " " + bounds;
  for (const std::string& name : changedSwitches())
    text += " " + name;
  return text;
}

void MotionFlags::add(CLI::App& app) {
  app.add_flag("--animate", options.animate,
               "Play the scene's animations, skins, morph targets, sequences and update callbacks; else it "
               "stands as it was loaded");
  app.add_option("--animation-fps", options.framesPerSecond,
                 "Frames to a second of the scene's own time, whose second 0 is frame 1")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 1e6));
  app.add_option("--quantize-motion", options.quantizeBoundM,
                 "Send moving leaves less exactly: no point of a leaf farther than this from its place, in "
                 "metres; 0: exactly")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e6));
}

void nameMode(RunReport& report, const InputFiles& files, const CullFlags& cull) {
  report.hierarchy = files.hierarchy;
  report.maxTrianglesPerLeaf = files.maxTrianglesPerLeaf;
  report.switches = cull.changedSwitches();
}

Result<cull::Options> CullFlags::options() const {
  const auto chosenAlgorithm = cull::algorithmFromName(algorithm);
  if (!chosenAlgorithm) {
    return inputError("--algorithm", "there is no algorithm named \"" + algorithm + "\"",
                      "choose auto, footprint, table, adaptive, adaptive-listing, fh, oh, naive or none");
  }
  const auto chosenBounds = cull::boundsFromName(bounds);
  if (!chosenBounds) {
    return inputError("--bounds", "there are no bounds named \"" + bounds + "\"",
                      "choose sphere, aabb, obb, hybrid or aabb-then-obb");
  }
  cull::Options options{
      .algorithm = *chosenAlgorithm, .bounds = *chosenBounds, .switches = switches, .threads = threads};
  if (planes == "matrix") {
    if (options.algorithm == cull::Algorithm::Auto) options.algorithm = cull::Algorithm::Adaptive;
    if (options.algorithm == cull::Algorithm::Footprint || options.algorithm == cull::Algorithm::Table) {
      return inputError("--planes", "footprints are found without planes",
                        "leave it out, or choose --algorithm adaptive");
    }
  }
  options.switches.coherent = *cull::reuseFromName(coherent);
  if (Status status = cull::check(options); !status) return status.error();
  if (Status status = cull::checkInstructionSetWish(); !status) return status.error();
  return options;
}

}  // namespace tessera
