#pragma once

#include <string>

#include "common/wall/wall.h"

namespace tessera {

/// A picture of the wall for people, as one standalone SVG document: every tile with its name and size in
/// pixels, then the whole size, the fields of view, the clip distances and the warnings.
[[nodiscard]] std::string wallSvg(const Wall& wall);

}  // namespace tessera
