#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "common/base/result.h"
#include "common/scene/scene.h"
#include "common/wall/camera_path.h"
#include "common/wall/wall.h"
#include "server/master/head_tracker.h"
#include "server/master/master.h"
#include "server/master/navigator.h"

namespace tessera {

/// What people do to a wall while it runs: steer, track a head, and show patterns and statistics.
struct LiveFlags {
  bool overlay = false, identify = false, alignment = false;
  int oscPort = 0;
  void add(CLI::App& app);
};

class LiveWall {
 public:
  /// All outlive it. `interactive`: people steer; the keyframes of the path are the views of keys 1 to 9.
  [[nodiscard]] static Result<std::unique_ptr<LiveWall>> make(const LiveFlags& flags, const Scene& scene,
                                                              const Wall& wall, const CameraPath& path,
                                                              bool interactive);

  /// What tiles show at first.
  [[nodiscard]] Display display() const { return display_; }
  /// Adds itself to the hooks of a run of the master.
  void hookInto(Master& master, Master::Hooks& hooks);

 private:
  LiveWall() = default;
  void handle(const proto::Input& input, Master& master);
  void place(CameraPose& pose);

  Display display_;
  std::optional<Navigator> navigator_;
  std::unique_ptr<HeadTracker> tracker_;
  std::optional<std::chrono::steady_clock::time_point> lastFrame_;
};

}  // namespace tessera
