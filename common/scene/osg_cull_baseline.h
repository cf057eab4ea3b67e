#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "common/base/result.h"
#include "common/scene/load_scene.h"
#include "common/wall/wall.h"

namespace tessera {

/// What OpenSceneGraph's own cull traversal costs, once for each tile, on the graph of a scene file as it was
/// imported: to compare cullers with. Frusta are tested with all six planes (near and far are the tile's),
/// small features are kept. OSG's bounds are floats without a margin, so this is no conservative culler.
class OsgCullBaseline {
 public:
  /// Reads the file again (a Scene keeps no graph) and computes all bounding volumes.
  [[nodiscard]] static Result<OsgCullBaseline> read(const std::filesystem::path& path, UpAxis up);
  ~OsgCullBaseline();
  OsgCullBaseline(OsgCullBaseline&&) noexcept;
  OsgCullBaseline& operator=(OsgCullBaseline&&) noexcept;

  /// Makes the tiles' matrices, and on the first call their visitors: what a viewer has before it culls.
  void setView(const WallView& view);
  /// osgUtil::CullVisitor as a viewer runs it: state graphs and render stages are built and sorted.
  void cullFull();
  /// The same tests and nothing else: drawables that pass are counted.
  void cullTraversalOnly();

  /// (drawable, tile) pairs that the last cullFull() left in the state graphs.
  [[nodiscard]] std::uint64_t fullPairs() const;
  /// (drawable, tile) pairs that passed in the last cullTraversalOnly().
  [[nodiscard]] std::uint64_t traversalPairs() const;

 private:
  struct Impl;
  explicit OsgCullBaseline(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
