#pragma once

#include <memory>

#include "common/cull/options.h"
#include "common/cull/result.h"
#include "common/hierarchy/frustum_hierarchy.h"
#include "common/hierarchy/object_hierarchy.h"

namespace tessera::cull {

struct Workspace;
class FootprintCuller;

/// Culls one scene, frame after frame. Every algorithm is conservative: a leaf with a triangle that meets a
/// tile's closed frustum is in that tile's list (BoundedPlane has the proof for floating point). Lists may
/// hold leaves that do not meet it (excess). The same scene, frusta and options give the same lists on every
/// run and every machine; where a switch remembers earlier frames, the same sequence of frames does.
///
/// Leaves that are absent (ObjectHierarchy::absentLeaves) are in no list, whichever the algorithm.
///
/// `scene` must outlive the culler; its bounds may be refitted, and leaves made absent, between calls. Not
/// thread-safe; separate cullers on one scene are. Buffers are kept from frame to frame. No recursion: depth
/// costs heap, not stack.
class Culler {
 public:
  /// `options` must pass check().
  Culler(const ObjectHierarchy& scene, const Options& options);
  /// The same, with what both make of the scene's boxes in memory once: `sharing` is of the same scene and
  /// options. Together they are then no more thread-safe than one.
  Culler(const ObjectHierarchy& scene, const Options& options, const Culler& sharing);
  ~Culler();
  Culler(Culler&&) noexcept;
  Culler& operator=(Culler&&) noexcept;

  /// The whole lists. The result lives until the next call of any member.
  const Result& cull(const FrustumHierarchy& frusta);

  /// The same lists as what they change in those of the call before, of whichever member; of the first call,
  /// and where the number of tiles changes, in empty lists. Does not allocate once warm. The result lives
  /// until the next call of any member.
  const Changes& cullChanges(const FrustumHierarchy& frusta);

  /// One tile's whole list as of the last call. `out` is cleared and refilled.
  void listOf(std::uint32_t tile, VisibleList& out) const;

  /// Whether it would read the planes of such frusta, or their grid() alone.
  [[nodiscard]] bool readsPlanes(const FrustumHierarchy& frusta) const;

  /// What the last call ran: the algorithm of the options, or what Algorithm::Auto chose.
  [[nodiscard]] Algorithm picked() const { return picked_; }

 private:
  Culler(const ObjectHierarchy& scene, const Options& options, const FootprintCuller* sharing);
  void pick(const FrustumHierarchy& frusta, bool forChanges);
  void listBeforeFrom(const FrustumHierarchy& frusta);
  void listAll(const FrustumHierarchy& frusta);
  void cullByPlanes(const FrustumHierarchy& frusta);
  void takeAbsentOut();

  const ObjectHierarchy* scene_;
  Options options_;
  Algorithm picked_ = options_.algorithm;
  std::unique_ptr<Workspace> workspace_;
  std::unique_ptr<FootprintCuller> footprints_;  ///< of the algorithms that need it
};

}  // namespace tessera::cull
