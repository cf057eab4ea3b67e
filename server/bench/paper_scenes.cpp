#include <algorithm>
#include <cmath>

#include "common/base/file.h"
#include "common/scene/synthetic/synthetic.h"
#include "server/bench/paper_figures.h"
#include "server/default_camera.h"

namespace tessera::bench {

namespace {

CameraPath shipped(const char* text, const std::string& name) {
  auto path = parseCameraPath(text, name);
  if (!path) std::abort();  // the shipped files are tested
  return *path;
}

}  // namespace

const CameraPath& orbitPath() {
  static const CameraPath path = shipped(kDefaultCamera, "configs/orbit.camera.json");
  return path;
}

const CameraPath& flyPath() {
  static const CameraPath path = shipped(kFlyCamera, "configs/fly.camera.json");
  return path;
}

const CameraPath& divePath() {
  static const CameraPath path = shipped(kDiveCamera, "configs/dive.camera.json");
  return path;
}

std::uint64_t PaperScenes::frames(std::uint64_t wanted) const {
  const double scaled = std::ceil(frameScale_ * static_cast<double>(wanted));
  return std::max<std::uint64_t>(4, static_cast<std::uint64_t>(scaled));
}

Result<std::filesystem::path> PaperScenes::file(const std::string& name,
                                                const std::function<Result<std::string>()>& make) {
  const std::filesystem::path path = folder_ / name;
  if (std::filesystem::exists(path)) return path;
  const auto bytes = make();
  if (!bytes) return bytes.error();
  if (Status status = writeFileAtomically(path, *bytes); !status) return status.error();
  return path;
}

namespace {

Result<const Scene*> loadOnce(std::unique_ptr<Scene>& kept, const Result<std::filesystem::path>& path) {
  if (kept) return kept.get();
  if (!path) return path.error();
  auto scene = loadScene(*path);
  if (!scene) return scene.error();
  kept = std::make_unique<Scene>(std::move(*scene));
  return kept.get();
}

}  // namespace

Result<const Scene*> PaperScenes::powerPlant() {
  return loadOnce(powerPlant_, file("powerplant.glb", [] { return makePowerPlantGlb({}); }));
}

Result<const Scene*> PaperScenes::fatehpur() {
  return loadOnce(fatehpur_, file("fatehpur.glb", [] { return makeFatehpurGlb({}); }));
}

Result<Scene> PaperScenes::powerPlantOf(std::uint64_t maxTrianglesPerLeaf) {
  const auto path = file("powerplant-1m.glb", [] { return makePowerPlantGlb({.triangles = 1'000'000}); });
  if (!path) return path.error();
  return loadScene(*path, LoadOptions{.up = UpAxis::Auto,
                                      .hierarchy = HierarchyKind::Bvh,
                                      .maxTrianglesPerLeaf = maxTrianglesPerLeaf});
}

Result<Scene> PaperScenes::city(std::uint64_t leaves) {
  const auto path =
      file("city-" + std::to_string(leaves) + ".glb", [leaves] { return makeCityGlb({.leaves = leaves}); });
  if (!path) return path.error();
  return loadScene(*path);
}

}  // namespace tessera::bench
