#pragma once

#include <string>

#include "common/wall/wall.h"

namespace tessera {

/// A picture of the wall for people, as one standalone SVG document: from the front, true to scale, every
/// tile with its name, pixels and host; then size, eye, clip distances and warnings; then from above, with
/// the eye and the tiles' frusta.
[[nodiscard]] std::string wallSvg(const Wall& wall);

}  // namespace tessera
