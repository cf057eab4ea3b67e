#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "common/scene/imported_graph.h"

namespace tessera {

/// Reads a file with osgDB and turns it from z up to y up.
[[nodiscard]] Result<ImportedGraph> importOsg(const std::filesystem::path& path);

}  // namespace tessera
