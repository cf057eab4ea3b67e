#pragma once

#include <memory>

#include "common/base/result.h"
#include "common/scene/motion/motion_player.h"
#include "common/scene/scene.h"

namespace tessera {

/// Plays the scene's motion; null where nothing in it can change. Without `animates` only levels of detail
/// choose.
[[nodiscard]] Result<std::unique_ptr<motion::MotionPlayer>> motionPlayerOf(const Scene& scene, bool animates);

/// Makes the leaves absent that the scene does not show as it was loaded: those behind switches and of
/// coarser levels of detail. To be called once the scene's leaves have their final ids.
[[nodiscard]] Status hideAsLoaded(Scene& scene);

}  // namespace tessera
