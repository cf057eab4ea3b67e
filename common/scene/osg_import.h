#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "common/scene/imported_graph.h"

namespace tessera {

/// Reads a file with osgDB; `isZUp`: turns it to y up.
[[nodiscard]] Result<ImportedGraph> importOsg(const std::filesystem::path& path, bool isZUp);

}  // namespace tessera
