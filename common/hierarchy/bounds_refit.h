#pragma once

#include <cstdint>
#include <vector>

#include "common/geometry/vec.h"
#include "common/hierarchy/enclosing_bounds.h"
#include "common/hierarchy/object_hierarchy.h"

namespace tessera {

/// Moves leaves of a hierarchy and refits the bounds above them, bottom-up and only along the touched paths
/// (van den Bergen 1997, refitting of AABB trees). The tree keeps its shape, so its quality decays where
/// things travel far. Between move() and refit() the hierarchy is not to be culled: the nodes above a moved
/// leaf do not hold it yet. One BoundsRefit at a time for a hierarchy, which must outlive it and
/// keep its shape. Not for use by several threads.
class BoundsRefit {
 public:
  /// How the oriented boxes of moved leaves and of all nodes above them are found from now on.
  BoundsRefit(ObjectHierarchy& oh, BoxFit fit);

  enum class Moved {
    Done,
    KeptLastPlace,  ///< NaN, infinity, no affine map, or a result that is not finite: nothing has changed
  };

  /// Places a leaf by an affine map of world space, from its place at rest: where it was when first moved or
  /// last given bounds. Maps do not add up. The leaf must have its terminal node to itself; a bug otherwise.
  Moved move(std::uint32_t leaf, const Mat4& restToNow);
  /// Gives a leaf other bounds, which are its place at rest from now on; same condition.
  Moved setBounds(std::uint32_t leaf, const Bounds& bounds);

  /// Recomputes every node above the leaves moved since the last refit, children before parents, and
  /// changes the revision if any leaf's bounds are other than they were. Returns how many nodes that was.
  /// Does not allocate once warm.
  std::uint32_t refit();

  /// How many calls of move and setBounds kept the last place.
  [[nodiscard]] std::uint64_t refusedMoves() const { return refusedMoves_; }

 private:
  static constexpr std::uint32_t kNone = UINT32_MAX;

  std::uint32_t aloneInNode(std::uint32_t leaf) const;
  std::uint32_t restOf(std::uint32_t leaf);
  void place(std::uint32_t node, const Bounds& bounds);
  void recompute(std::uint32_t node);
  [[nodiscard]] std::uint32_t countChildren(std::uint32_t node, std::uint32_t limit) const;
  void store(std::uint32_t node, const Bounds& bounds);

  ObjectHierarchy& oh_;
  BoxFit fit_;
  std::vector<std::uint32_t> restIndex_;  ///< of each leaf into rests_; empty before the first move
  std::vector<Bounds> rests_;
  std::vector<std::uint64_t> touched_;  ///< one bit for each node to be recomputed
  bool changed_ = false;
  std::vector<std::uint32_t> changedLeaves_;  ///< since the last refit
  std::uint64_t refusedMoves_ = 0;
  EnclosingBounds enclosing_;
};

}  // namespace tessera
