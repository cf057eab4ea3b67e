#pragma once

namespace tessera {

/// Whether and how the master plays a scene.
struct MotionOptions {
  bool animate = false;         ///< else only levels of detail choose
  double framesPerSecond = 60;  ///< of the scene's own time: frame k shows second (k - 1) / framesPerSecond
  /// Transforms of rigid leaves are sent in steps that put no point of a leaf farther than this from its
  /// place; 0: as they are.
  double quantizeBoundM = 0;
};

}  // namespace tessera
