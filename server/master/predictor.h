#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/wall/grown_wall.h"
#include "server/master/wall_culler.h"

namespace tessera {

/// Where a camera is about to be if it goes on as it did: at the velocity and the turning of the last frames.
/// Two steps that have little in common are no motion but a jump or noise, and nothing is made of them.
class CameraMotion {
 public:
  /// The pose of the next frame.
  void add(const CameraPose& pose);
  /// The pose so many frames after the last. It is turned by kMostTurnRad at most, and moved by `mostPath`:
  /// no camera goes on like that for long. add() must have been called.
  [[nodiscard]] CameraPose ahead(double frames, double mostPath) const;
  [[nodiscard]] bool isStanding() const { return step_.isZero() && turn_.isZero(); }

  static constexpr double kMostTurnRad = 1;

 private:
  CameraPose last_;
  bool hasLast_ = false;
  Vec3 lastStep_ = Vec3::Zero(), lastTurn_ = Vec3::Zero();  ///< of the last frame
  Vec3 step_ = Vec3::Zero(), turn_ = Vec3::Zero();          ///< smoothed; a turn is its axis times radians
};

struct PredictorOptions {
  unsigned horizonFrames = 30;
  double grownShare = 0.125;  ///< of a tile, on each side
  cull::Options cull = {.algorithm = cull::Algorithm::Auto};
};

/// Which leaves tiles will probably need in the next frames, so that geometry can be sent ahead.
///
/// Each call culls once, for a wall of grown tiles where the camera will probably be: in turn in a quarter,
/// in half and in all of the horizon. So what lies along the way is told in the course of three frames. Of a
/// camera that stands, the leaves beside the current view are told. Not thread-safe; no allocation once warm
/// but for walls in stereo.
class Predictor {
 public:
  /// `scene` outlives the predictor.
  Predictor(const ObjectHierarchy& scene, const Wall& wall, const PredictorOptions& options = {});

  /// To be called once for each frame, with the pose it was culled for and the sphere of the scene. By tile,
  /// the leaves it will probably need, canonical; they live until the next call.
  const std::vector<VisibleList>& predict(const CameraPose& pose, const Sphere& scene);

 private:
  PredictorOptions options_;
  GrownWall grown_;
  WallCuller culler_;
  CameraMotion motion_;
  WallView view_;
  unsigned turn_ = 0;
};

}  // namespace tessera
