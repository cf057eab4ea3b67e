#pragma once

#include <array>
#include <span>

#include "common/scene/motion/motion.h"

namespace tessera::motion {

/// The channel's value at a time, in seconds from the start of the scene's play, as glTF 2.0 defines it
/// (appendix C): constant before the first key and after the last, rotations along the shorter arc and of
/// length 1. The animation starts anew after its period. `out` has room for Channel::width numbers.
void sample(const Channel& channel, double timeS, std::span<double> out);

/// Scale, rotation and translation as one map; the rotation need not be of length 1.
[[nodiscard]] Mat4 matrixOf(const Trs& trs);

}  // namespace tessera::motion
