#include "server/bench/wall_shapes.h"

#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/master/wall_culler.h"

namespace tessera::bench {

namespace {

using Clock = std::chrono::steady_clock;

struct Candidate {
  std::string name;
  std::function<std::uint64_t(const WallView&)> cull;  ///< gives the pairs
  Samples us, pairs;
};

Candidate byGroups(const Scene& scene, const Wall& wall) {
  auto culler =
      std::make_shared<WallCuller>(scene.hierarchy, wall, cull::Options{.algorithm = cull::Algorithm::Auto});
  return {"as the master",
          [culler](const WallView& view) {
            culler->update(view);
            return culler->cull().pairs;
          },
          {},
          {}};
}

Candidate byOneHierarchy(const Scene& scene, const Wall& wall, const char* name, cull::Algorithm algorithm) {
  auto frusta = std::make_shared<WallFrusta>(wall);
  auto culler = std::make_shared<cull::Culler>(scene.hierarchy, cull::Options{.algorithm = algorithm});
  return {name,
          [frusta, culler](const WallView& view) {
            frusta->update(view);
            return culler->cull(frusta->get()).pairs;
          },
          {},
          {}};
}

/// Each eye by a hierarchy of its own.
Candidate eyesApart(const Scene& scene) {
  struct Eye {
    GeneralFrusta frusta;
    cull::Culler culler;
  };
  const cull::Options options{.algorithm = cull::Algorithm::Adaptive};
  auto left = std::make_shared<Eye>(Eye{GeneralFrusta(), cull::Culler(scene.hierarchy, options)});
  auto right = std::make_shared<Eye>(Eye{GeneralFrusta(), cull::Culler(scene.hierarchy, options)});
  return {"each eye apart",
          [left, right](const WallView& view) {
            left->frusta.update(view.left);
            right->frusta.update(view.right);
            return left->culler.cull(left->frusta).pairs + right->culler.cull(right->frusta).pairs;
          },
          {},
          {}};
}

WallView viewAt(const Wall& wall, const Scene& scene, CameraPose pose, std::uint64_t frame,
                double headStepM) {
  if (wall.observer && headStepM > 0) {
    // Within a tenth of a metre, so before every screen that stands farther off.
    const double t = static_cast<double>(frame) * headStepM / 0.1;
    pose.hasHead = true;
    pose.headM =
        wall.observer->eyeM + 0.1 * Vec3(std::sin(t), 0.3 * std::sin(0.7 * t), 0.5 * std::cos(0.9 * t));
    if (screenNotBefore(wall, pose.headM)) pose.hasHead = false;
  }
  return viewOf(wall, pose, scene.sphere().center, scene.sphere().radius);
}

Json shapeOf(const Scene& scene, const Wall& wall, const CameraPath& path, const WallShapesOptions& options) {
  std::vector<Candidate> candidates;
  candidates.push_back(byGroups(scene, wall));
  candidates.push_back(byOneHierarchy(scene, wall, "one hierarchy", cull::Algorithm::Adaptive));
  candidates.push_back(byOneHierarchy(scene, wall, "tile by tile", cull::Algorithm::Oh));
  const Sphere& sphere = scene.sphere();
  const std::vector<double> times = path.sampleTimes(options.frames);
  const bool isStereo =
      !viewOf(wall, path.poseAt(times[0], sphere.center, sphere.radius), sphere.center, sphere.radius)
           .left.empty();
  if (isStereo) candidates.push_back(eyesApart(scene));
  for (std::uint64_t frame = 0; frame < options.frames; ++frame) {
    const WallView view = viewAt(wall, scene, path.poseAt(times[frame], sphere.center, sphere.radius), frame,
                                 options.headStepM);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      Candidate& candidate = candidates[(i + frame) % candidates.size()];
      const auto start = Clock::now();
      const std::uint64_t pairs = candidate.cull(view);
      candidate.us.add(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
      candidate.pairs.add(static_cast<double>(pairs));
    }
  }
  const std::vector<FrustumGroup> groups = frustumGroups(wall, Grouping::Grids);
  Json entries = Json::array();
  for (const Candidate& candidate : candidates) {
    entries.push_back({{"name", candidate.name},
                       {"us", spreadOf(candidate.us)},
                       {"pairs_per_frame", candidate.pairs.percentile(50)},
                       {"time_of_tile_by_tile", ratioOf(candidates[2].us, candidate.us)}});
  }
  return {{"wall", wall.source},
          {"tiles", wall.tiles.size()},
          {"screens", wall.screens.size()},
          {"groups", groups.size()},
          {"first_group_columns", groups[0].columns},
          {"stereo", isStereo},
          {"candidates", std::move(entries)}};
}

}  // namespace

Json wallShapes(const Scene& scene, std::span<const Wall> walls, const CameraPath& path,
                const WallShapesOptions& options) {
  Json shapes = Json::array();
  for (const Wall& wall : walls)
    shapes.push_back(shapeOf(scene, wall, path, options));
  return {{"scene", scene.source},
          {"leaves", scene.leaves.size()},
          {"frames", options.frames},
          {"head_step_m", options.headStepM},
          {"walls", std::move(shapes)}};
}

}  // namespace tessera::bench
