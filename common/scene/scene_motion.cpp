#include "common/scene/scene_motion.h"

#include <utility>
#include <vector>

#include "common/scene/motion/motion_codec.h"

namespace tessera {

namespace {

std::vector<motion::LeafPart> partsOf(const Scene& scene) {
  std::vector<motion::LeafPart> parts;
  parts.reserve(scene.leaves.size());
  for (const SceneLeaf& leaf : scene.leaves)
    parts.push_back({leaf.graphLeaf, leaf.part});
  return parts;
}

}  // namespace

Result<std::unique_ptr<motion::MotionPlayer>> motionPlayerOf(const Scene& scene, bool animates) {
  Result<motion::Motion> motion = motion::decodeMotion({scene.motion.data(), scene.motion.size()});
  if (!motion) return motion.error();
  if (motion->empty() || (!animates && motion->units.empty())) return std::unique_ptr<motion::MotionPlayer>();
  return motion::MotionPlayer::make(std::move(*motion), partsOf(scene), animates);
}

Status hideAsLoaded(Scene& scene) {
  const Result<motion::Motion> motion = motion::decodeMotion({scene.motion.data(), scene.motion.size()});
  if (!motion) return motion.error();
  if (motion->hiddenAsLoaded.empty()) return Done{};
  scene.hierarchy.setAbsentLeaves(motion::leavesOf(motion->hiddenAsLoaded, partsOf(scene)));
  if (motion->shownAsLoaded.radius >= 0) scene.shown = motion->shownAsLoaded;
  return Done{};
}

}  // namespace tessera
