#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "common/base/result.h"
#include "common/scene/load_scene.h"
#include "common/wall/camera_path.h"
#include "server/bench/report.h"

namespace tessera::bench {

/// What the figures need: the scenes in the papers' shapes, made and read once, and the walks.
class PaperScenes {
 public:
  /// Scene files go to `folder`, which must exist. `frameScale` (0, 1] shortens the walks.
  PaperScenes(std::filesystem::path folder, double frameScale)
      : folder_(std::move(folder)), frameScale_(frameScale) {}

  /// 3,919 leaves, branching 4.5; 200,000 triangles.
  [[nodiscard]] Result<const Scene*> powerPlant();
  /// 482 leaves, branching 2.67.
  [[nodiscard]] Result<const Scene*> fatehpur();
  /// The power plant with a million triangles, cut and grouped to leaves of at most so many triangles.
  [[nodiscard]] Result<Scene> powerPlantOf(std::uint64_t maxTrianglesPerLeaf);

  /// A city of so many leaves. Not kept in memory: a million leaves take gigabytes.
  [[nodiscard]] Result<Scene> city(std::uint64_t leaves);

  [[nodiscard]] std::uint64_t frames(std::uint64_t wanted) const;

 private:
  Result<std::filesystem::path> file(const std::string& name,
                                     const std::function<Result<std::string>()>& make);
  std::filesystem::path folder_;
  double frameScale_;
  std::unique_ptr<Scene> powerPlant_, fatehpur_;
};

/// Once around the scene, all in view; inside the scene; and from outside through the scene until nothing is
/// in view any more.
[[nodiscard]] const CameraPath& orbitPath();
[[nodiscard]] const CameraPath& flyPath();
[[nodiscard]] const CameraPath& divePath();

// One figure each, as JSON; sources: N = Nirnimesh, Harish, Narayanan 2006; K = Koblizek's term project.

/// N, figure 4: culling time along a walk with the whole scene in view, by method.
[[nodiscard]] Result<Json> methodsFigure(PaperScenes& scenes);
/// N, figure 5: culling time along a walk and on average, by configuration of tiles.
[[nodiscard]] Result<Json> tilesFigure(PaperScenes& scenes);
/// N, figure 6: update and culling time by the share of moving objects, with OBBs, AABBs and both.
[[nodiscard]] Result<Json> dynamicFigure(PaperScenes& scenes);
/// A million leaves of which one in a hundred moves: moving, refitting and culling.
[[nodiscard]] Result<Json> millionFigure(PaperScenes& scenes);
/// N, section 4.2: what regrouping costs or saves, by the branching of the hierarchy.
[[nodiscard]] Result<Json> regroupFigure(PaperScenes& scenes);
/// K, figure 1: culling and what is left to draw, by the most triangles of a leaf.
[[nodiscard]] Result<Json> mtplFigure(PaperScenes& scenes);
/// K, figure 2: the optimizations alone and together along a walk.
[[nodiscard]] Result<Json> optimizationsFigure(PaperScenes& scenes);
/// Time and excess of every method, bound and hierarchy, both walks, 4x4 to 16x16.
[[nodiscard]] Result<Json> excessFigure(PaperScenes& scenes);
/// The cost of the error bound: classifications with and without it.
[[nodiscard]] Result<Json> boundFigure(PaperScenes& scenes);

}  // namespace tessera::bench
