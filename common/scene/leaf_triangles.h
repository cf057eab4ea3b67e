#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "common/base/result.h"
#include "common/geometry/vec.h"
#include "common/scene/scene.h"

namespace tessera {

/// The triangles of a scene's leaves as the tiles are sent them, for audits of what is drawn where. Every
/// stored drawable is decoded once and kept for as long as this lives: 12 bytes a triangle and 24 a vertex of
/// the assets that were asked for, instances not counted. Not thread-safe.
class LeafTriangles {
 public:
  /// The scene must outlive this.
  explicit LeafTriangles(const Scene& scene);
  ~LeafTriangles();
  LeafTriangles(const LeafTriangles&) = delete;
  LeafTriangles& operator=(const LeafTriangles&) = delete;

  /// The leaf's triangles in world space: its stored vertices, which are floats, times its localToWorld in
  /// double. Points and lines are degenerate triangles (p, p, p) and (p, q, q). Empty for a billboard: it
  /// turns to the eye, so it has no place of its own and is not audited. Valid until the next call. Fails on
  /// an asset that is missing or cannot be read.
  [[nodiscard]] Result<std::span<const std::array<Vec3, 3>>> of(std::uint32_t leaf);

 private:
  struct Decoded;
  const Scene* scene_;
  std::unique_ptr<Decoded> decoded_;
};

}  // namespace tessera
