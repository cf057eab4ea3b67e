#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "common/hierarchy/frustum_hierarchy.h"
#include "common/hierarchy/object_hierarchy.h"
#include "common/hierarchy/visible_list.h"

namespace tessera::cull {

/// How the object hierarchy (OH, n leaves) is culled to the frustum hierarchy (FH, m tiles). Sources:
/// Nirnimesh, Harish, Narayanan 2006, section 4.2.
enum class Algorithm {
  None,      ///< everything on every tile: the reference for pictures
  Naive,     ///< every leaf against every tile, O(mn)
  Oh,        ///< the OH once for each tile, with plane masks
  Adaptive,  ///< the paper's text: descend FH while the node is uncut, unfold OH where it is cut, and go on
             ///< culling OH against what is left of the planes where FH ends
};

enum class BoundsKind { Sphere, Aabb, Obb };

struct Options {
  Algorithm algorithm = Algorithm::Adaptive;
  BoundsKind bounds = BoundsKind::Obb;
};

[[nodiscard]] std::optional<Algorithm> algorithmFromName(std::string_view name);
[[nodiscard]] std::optional<BoundsKind> boundsFromName(std::string_view name);
[[nodiscard]] std::string_view nameOf(Algorithm algorithm);
[[nodiscard]] std::string_view nameOf(BoundsKind bounds);

struct Result {
  std::vector<VisibleList> lists;  ///< one for each tile, in the order of the tiles
  std::uint64_t planeTests = 0;    ///< box-plane classifications made
  std::uint64_t pairs = 0;         ///< (leaf, tile) pairs listed
};

/// Culls one scene, frame after frame. Every algorithm is conservative: a leaf with a triangle that meets a
/// tile's closed frustum is in that tile's list (BoundedPlane has the proof for floating point). Lists may
/// hold leaves that do not meet it (excess). The same input gives the same lists on every run.
///
/// Holds references to neither argument of cull; `scene` must outlive the culler. Not thread-safe; separate
/// cullers on one scene are. Buffers are kept from frame to frame.
class Culler {
 public:
  Culler(const ObjectHierarchy& scene, const Options& options) : scene_(&scene), options_(options) {}

  /// The result lives until the next call.
  const Result& cull(const FrustumHierarchy& frusta);

 private:
  const ObjectHierarchy* scene_;
  Options options_;
  Result result_;
  /// Work still to be done: a node of the OH against a node of the FH, with the planes that still matter.
  struct Task {
    std::uint32_t node, frustum, mask;
  };
  std::vector<Task> tasks_;

  template <class View>
  void run(const FrustumHierarchy& frusta);
  template <class View>
  void cullNaive(const FrustumHierarchy& frusta);
  template <class View>
  void cullOh(const FrustumHierarchy& frusta);
  template <class View>
  void cullAdaptive(const FrustumHierarchy& frusta);
  template <class View>
  bool testPlanes(const View& bounds, const FrustumPlanes& planes, std::uint32_t& mask);
  void pushChildren(std::uint32_t node, std::uint32_t frustum, std::uint32_t mask);
};

}  // namespace tessera::cull
