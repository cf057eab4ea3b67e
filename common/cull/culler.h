#pragma once

#include <memory>

#include "common/cull/options.h"
#include "common/cull/result.h"
#include "common/hierarchy/frustum_hierarchy.h"
#include "common/hierarchy/object_hierarchy.h"

namespace tessera::cull {

struct Workspace;

/// Culls one scene, frame after frame. Every algorithm is conservative: a leaf with a triangle that meets a
/// tile's closed frustum is in that tile's list (BoundedPlane has the proof for floating point). Lists may
/// hold leaves that do not meet it (excess). The same scene, frusta and options give the same lists on every
/// run and every machine; where a switch remembers earlier frames, the same sequence of frames does.
///
/// `scene` must outlive the culler; its bounds may be refitted between calls. Not thread-safe; separate
/// cullers on one scene are. Buffers are kept from frame to frame. No recursion: depth costs heap, not stack.
class Culler {
 public:
  /// `options` must pass check().
  Culler(const ObjectHierarchy& scene, const Options& options);
  ~Culler();
  Culler(Culler&&) noexcept;
  Culler& operator=(Culler&&) noexcept;

  /// The result lives until the next call.
  const Result& cull(const FrustumHierarchy& frusta);

 private:
  const ObjectHierarchy* scene_;
  Options options_;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace tessera::cull
