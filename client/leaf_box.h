#pragma once

#include <cstdint>

#include "client/tile_cache.h"
#include "proto/messages.h"

namespace tessera {

/// What stands for a leaf while its assets are not here: its box in its mean colour. The geometry is the cube
/// from -1 to 1, and the same from call to call; boxToWorld places it.
[[nodiscard]] osg::Geometry& boxOf(CachedLeaf& leaf);
[[nodiscard]] Mat4 boxToWorld(const CachedLeaf& leaf);

/// An upper bound of the pixels of the tile's picture that a leaf's box covers: those of the rectangle about
/// its corners; of all where a corner is not before the near plane.
[[nodiscard]] std::uint64_t pixelsOf(const CachedLeaf& leaf, const proto::Frame& frame, std::int32_t widthPx,
                                     std::int32_t heightPx);

}  // namespace tessera
