#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "common/base/result.h"

namespace tessera::cull {

/// How the object hierarchy (OH, n leaves) is culled to the frustum hierarchy (FH, m tiles). Sources:
/// Nirnimesh, Harish, Narayanan 2006 ("the paper"), section 4.2. All cull to the primary frustum first.
enum class Algorithm {
  None,      ///< everything on every tile: the reference for pictures
  Naive,     ///< every leaf against every tile, O(mn)
  Oh,        ///< the OH once for each tile, O(m log n)
  Fh,        ///< every leaf down the FH, O(n log m)
  Adaptive,  ///< the paper's text: descend FH while the node is uncut, unfold OH where it is cut, and go on
             ///< culling OH against what is left of the planes where FH ends
  AdaptiveListing,  ///< Algorithm 2 as printed: where FH ends the whole node is marked
  Footprint,        ///< intervals of columns and rows of projected boxes, 16 at a time, in a tree
  Table,            ///< the same of every leaf, without a tree, as one dense table
  Auto,             ///< chooses between table, footprint and adaptive; what runs is Culler::picked()
};

/// What is tested against the planes.
enum class BoundsKind {
  Sphere,
  Aabb,
  Obb,
  Hybrid,      ///< AABB for what moves, OBB for what stands still (the paper, section 5)
  AabbThenObb  ///< the OBB only where the AABB is cut
};

/// When a result may be kept as long as it certainly still holds.
enum class Reuse {
  Never,
  Always,
  Measured,  ///< while it spares more than it costs
};

/// Each can be measured alone and together with others. None changes what may be dropped.
struct Switches {
  /// Cull to the primary frustum before the tiles (the paper, section 4.2). Off: naive and oh test the tiles
  /// alone, fh tests each leaf; the adaptive algorithms are never without.
  bool firstLevel = true;
  /// Planes that a node is wholly inside of are not tested below it (Assarsson and Moeller 2000).
  bool planeMasking = true;
  /// The plane that rejected a node last time is tested first (Assarsson and Moeller 2000). One byte for each
  /// node and frustum.
  bool planeCoherency = false;
  /// Of two opposite planes only the one nearer to the node's centre is tested: the centre lies inside the
  /// other (Assarsson and Moeller 2000). The planes left out stay in the mask of the children.
  bool octantTest = false;
  /// For tests and the record: the octant test with the mistake that Koblizek's term project confesses
  /// (section 3): planes left out are masked for the children, which may be outside of them.
  bool octantPitfall = false;
  /// The corners nearest to and farthest along a plane's normal by a table of its signs, instead of centre
  /// and half-extents (term project, section 2.4). For AABBs alone.
  bool signTable = false;
  /// A sphere first, then the box where the sphere is cut (Real-Time Rendering, section 14.3).
  bool sphereFirst = false;
  /// Distances to the rejecting plane are kept and updated by how far the eye has moved and the plane has
  /// turned (Real-Time Rendering, section 14.3; MotionCache has the bound).
  bool motionCoherence = false;
  /// Adaptive: children on one side of a bisection are regrouped under a box of their own, from
  /// `regroupFrom` children on (the paper, section 4.2: pseudo-groups).
  bool regroup = false;
  std::uint32_t regroupFrom = 8;
  /// Footprint, table: leaves that cover several rows and columns are listed row by row, where the outline of
  /// the projected box is, instead of in the whole rectangle.
  bool refine = true;
  /// Table: blocks of leaves are looked at again only when the camera has moved so far that their footprints
  /// may have changed. The lists are the same.
  Reuse coherent = Reuse::Measured;
};

struct Options {
  Algorithm algorithm = Algorithm::Adaptive;
  BoundsKind bounds = BoundsKind::Obb;
  Switches switches = {};
  /// Footprint and table: at most so many threads where the work is large enough; 0: as many as the machine
  /// has. The lists are the same for any number.
  unsigned threads = 0;
};

[[nodiscard]] std::optional<Algorithm> algorithmFromName(std::string_view name);
[[nodiscard]] std::optional<BoundsKind> boundsFromName(std::string_view name);
[[nodiscard]] std::string_view nameOf(Algorithm algorithm);
[[nodiscard]] std::string_view nameOf(BoundsKind bounds);

[[nodiscard]] std::optional<Reuse> reuseFromName(std::string_view name);
[[nodiscard]] std::string_view nameOf(Reuse reuse);

/// Whether some switch is about tests against planes and not at its default. Footprints have none, so
/// Algorithm::Auto then chooses adaptive.
[[nodiscard]] bool concernsPlanes(const Switches& switches);

/// Refuses switches that do not go together with each other or with the bounds.
[[nodiscard]] Status check(const Options& options);

}  // namespace tessera::cull
