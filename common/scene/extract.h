#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "common/base/result.h"
#include "common/scene/imported_graph.h"
#include "common/scene/scene.h"

namespace tessera {

struct ExtractOptions {
  std::string source;  ///< the file, for messages
  bool isGltf = false;
  std::uint64_t maxTrianglesPerLeaf = 0;      ///< 0: any number
  std::shared_ptr<AssetKeeper> keeper = {};   ///< of the assets' bytes; null: memory
  std::function<void(double)> progress = {};  ///< told the share of nodes that are done; may be empty
};

/// Walks an imported graph in pre-order and makes of it the object hierarchy, the leaves and their assets.
/// Only what is drawn is taken: nodes with nothing below vanish, of a Switch its active children, of a LOD
/// its finest level. The depth of the graph is not limited by the machine stack. A drawable of more than
/// `maxTrianglesPerLeaf` triangles becomes a subtree of parts where it can be cut
/// (cut_drawable.h); that some cannot is said in the warnings. Billboards are never cut.
[[nodiscard]] Result<Scene> extractScene(ImportedGraph graph, const ExtractOptions& options);

}  // namespace tessera
