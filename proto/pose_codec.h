#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/geometry/box.h"
#include "proto/messages.h"

namespace tessera::proto {

// The bytes of Poses.poses; PROTOCOL.md has the format. Ids ascend, varints are shortest, so that every set
// of poses has one encoding.

/// `out` is cleared and refilled. The poses' ids must ascend.
void encodePoseBytes(std::span<const Pose> poses, std::vector<std::byte>& out);

/// Safe for untrusted bytes. Refused are also numbers that are not finite and more of anything than the
/// limits of messages.h allow. Whether the ids exist is left to the caller.
[[nodiscard]] Result<std::vector<Pose>> decodePoseBytes(std::span<const std::byte> bytes);

/// `now` as whole steps from `base`, so that no point of `box` (local coordinates) lies farther than `boundM`
/// from where `now` puts it, checked with the very numbers that fromSteps() will make. Nothing where no steps
/// are fine enough (coordinates too large for their doubles, no finite numbers): send the matrix then.
/// Both matrices must be affine; boundM > 0.
[[nodiscard]] std::optional<PoseSteps> toSteps(const Mat4& base, const Mat4& now, const Aabb& box,
                                               double boundM);

/// The matrix that the steps lead to; the same doubles everywhere. Not finite where they lead too far.
[[nodiscard]] Mat4 fromSteps(const Mat4& base, const PoseSteps& steps);

}  // namespace tessera::proto
