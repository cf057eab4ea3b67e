#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

namespace tessera {

/// A wall that was described for another system.
struct ImportedWall {
  std::string json;                   ///< a wall file: JSON with a comment on top
  std::vector<std::string> warnings;  ///< one line each: what was left out or assumed, and where it stood
};

/// Reads the wall description of another system and says it as a wall file. The format is recognised by the
/// content: Equalizer (.eqc), Tide (JSON, XML), DisplayCluster (XML), SGCT (JSON) and MPCDI archives. What is
/// no wall is refused with one error; what is no part of a wall is left out with a warning.
/// Files of at most 1 MiB; MPCDI archives as readMpcdi takes them.
[[nodiscard]] Result<ImportedWall> importWall(const std::filesystem::path& path);

/// The same for text that is already there; `fileName` stands for the file in errors, warnings and the name
/// of the wall. No MPCDI archives.
[[nodiscard]] Result<ImportedWall> importWallText(std::string_view text, const std::string& fileName);

}  // namespace tessera
