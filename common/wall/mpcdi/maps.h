#pragma once

#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/wall/mpcdi/mpcdi.h"

namespace tessera {

/// A "PF" portable float map of either byte order; its rows come from the bottom. `place` stands for it in
/// errors. The warp's xyz are as they stand in the file.
[[nodiscard]] Result<MpcdiWarp> parsePfm(std::string_view bytes, const std::string& place);

/// A PNG with 1 to 16 bits a channel as grey: the mean of red, green and blue; transparency is not looked at.
[[nodiscard]] Result<MpcdiMap> parsePngMap(std::string_view bytes, const std::string& place);

}  // namespace tessera
