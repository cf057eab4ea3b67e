#pragma once

#include <vector>

#include "common/base/result.h"
#include "common/scene/gltf/geometry.h"
#include "common/scene/gltf/load_document.h"
#include "common/scene/gltf/warnings.h"
#include "common/scene/imported_graph.h"

namespace tessera::gltf {

/// Builds the graph of the document's default scene (or its first, or of all parentless nodes) into `graph`.
/// Refuses node references that do not make up a forest.
[[nodiscard]] Status buildNodes(const Document& document, Geometries& geometries, Warnings& warnings,
                                ImportedGraph& graph);

}  // namespace tessera::gltf
