#pragma once

#include <optional>

#include "common/geometry/vec.h"
#include "common/hierarchy/enclosing_bounds.h"

namespace tessera {

/// Bounds of the image of `bounds` under the affine map x -> A x + t, whose doubles are taken as exact. Each
/// of the three holds the exact image of its own original (the derivation stands in the .cpp); a flat or
/// singular image gets the thickness of the rounding. The oriented box keeps its axes' images, which need not
/// be perpendicular; with BoxFit::AxisAligned it is the image's axis-aligned box. Under the identity the
/// bounds stay bit for bit. Nothing where the map is not affine or the image not finite (or beyond 1e150,
/// where squares overflow).
[[nodiscard]] std::optional<Bounds> transformed(const Bounds& bounds, const Mat4& map, BoxFit fit);

/// True where no coordinate or size is NaN, infinite or beyond 1e150, and the box is not empty.
[[nodiscard]] bool isUsable(const Bounds& bounds);

}  // namespace tessera
