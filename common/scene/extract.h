#pragma once

#include <cstdint>
#include <string>

#include "common/base/result.h"
#include "common/scene/imported_graph.h"
#include "common/scene/scene.h"

namespace tessera {

/// Walks an imported graph in pre-order and makes of it the object hierarchy, the leaves and their assets.
/// Only what is drawn is taken: nodes with nothing below vanish, of a Switch its active children, of a LOD
/// its finest level. The depth of the graph is not limited by the machine stack. A drawable of more than
/// `maxTrianglesPerLeaf` triangles (0: any number) becomes a subtree of parts where it can be cut
/// (cut_drawable.h); that some cannot is said in the warnings. Billboards are never cut.
[[nodiscard]] Result<Scene> extractScene(ImportedGraph graph, const std::string& source, bool isGltf,
                                         std::uint64_t maxTrianglesPerLeaf = 0);

}  // namespace tessera
