#pragma once

#include <optional>
#include <span>

#include "common/scene/motion/motion.h"

namespace tessera::motion {

// Bounds of what tiles make of a deformed leaf. A tile adds the morph targets with their weights, then takes
// the mean of the joints' maps, both in double from the floats that it was sent, and rounds the result to
// float; weights of a vertex sum to 1 but for their rounding. The bounds hold that result for every vertex.

/// The vertices of a box after morphing, before any skin: the box plus, for each target, its displacements
/// times its weight (Minkowski sum). Padded for the rounding to float.
[[nodiscard]] Aabb morphed(const Aabb& box, std::span<const Aabb> targets, std::span<const float> weights);

/// Of a leaf without a skin, in its own coordinates.
[[nodiscard]] Bounds morphedBounds(const Aabb& box, std::span<const Aabb> targets,
                                   std::span<const float> weights);

/// Of a leaf with a skin whose localToWorld is the translation by `origin`, in world coordinates. A vertex is
/// a mean of the places where the joints that it follows put it, each of which lies in that joint's box.
/// `joints` has 12 floats, by column, for each of the boxes; those of empty boxes do not matter. Nothing
/// where a number is not finite, or no box is left.
[[nodiscard]] std::optional<Bounds> skinnedBounds(const Deformation& deformation,
                                                  std::span<const float> joints,
                                                  std::span<const float> weights, const Vec3& origin);

}  // namespace tessera::motion
