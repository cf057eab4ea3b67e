#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/gltf/accessor.h"
#include "common/scene/gltf/load_document.h"
#include "common/scene/gltf/warnings.h"
#include "common/scene/imported_graph.h"

namespace tessera::gltf {

/// How the nodes that show a mesh deform it.
struct MeshDeforms {
  bool hasSkin = false;
  bool isMorphed = false;
};
/// By mesh. What no skin and no weight ever reaches need not be read.
[[nodiscard]] std::vector<MeshDeforms> meshDeforms(const Document& document);

/// Reads animations and skins into `graph.motion`: nodes, channels and skins of the nodes below `roots`,
/// which must be roots of a forest (buildNodes has seen to it). All animations play at once; where several
/// drive one property the first does. What is malformed is left out with a warning: the scene then stands
/// still there.
void readMotion(const Document& document, AccessorReader& accessors, const std::vector<int>& roots,
                Warnings& warnings, ImportedGraph& graph);

}  // namespace tessera::gltf
