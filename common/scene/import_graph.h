#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "common/scene/imported_graph.h"
#include "common/scene/load_scene.h"

namespace tessera {

/// By the file's extension.
[[nodiscard]] bool isGltfFile(const std::filesystem::path& path);

/// Reads a scene file of any kind as a graph, y up; loadScene has what is refused.
[[nodiscard]] Result<ImportedGraph> importGraph(const std::filesystem::path& path, UpAxis up);

}  // namespace tessera
