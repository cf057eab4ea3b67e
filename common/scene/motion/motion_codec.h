#pragma once

#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/scene/motion/motion.h"

namespace tessera::motion {

/// The motion as bytes, little-endian; none where nothing moves.
[[nodiscard]] std::string encodeMotion(const Motion& motion);

/// What encodeMotion wrote; no bytes give an empty motion. Any bytes are safe: every count is checked against
/// the bytes that are left, every number against its range, every reference against what it refers to. Only
/// the skeleton's own bytes are taken as they are.
[[nodiscard]] Result<Motion> decodeMotion(std::string_view bytes);

}  // namespace tessera::motion
