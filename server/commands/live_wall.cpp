#include "server/commands/live_wall.h"

#include <vector>

#include <spdlog/spdlog.h>

namespace tessera {

namespace {

// GLFW's numbers.
constexpr std::int32_t kF1 = 290, kF2 = 291, kF3 = 292;

std::vector<CameraPose> viewsOf(const CameraPath& path, const Scene& scene) {
  std::vector<CameraPose> views;
  const Sphere& sphere = scene.sphere();
  for (const CameraKeyframe& keyframe : path.keyframes())
    views.push_back(path.poseAt(keyframe.timeS, sphere.center, sphere.radius));
  return views;
}

}  // namespace

void LiveFlags::add(CLI::App& app) {
  app.add_flag("--overlay", overlay,
               "Statistics in a corner of each tile: frames a second, leaves, bytes, cache, skew (key F1)");
  auto* identifyFlag = app.add_flag("--identify", identify, "Each tile shows its name (key F2)");
  app.add_flag("--test-pattern", alignment,
               "Lines, circles and colours to align the tiles by, instead of the scene (key F3)")
      ->excludes(identifyFlag);
  app.add_option(
         "--osc-port", oscPort,
         "UDP port at which a tracker says /tessera/head x y z (metres, room); instead of the wall file's")
      ->check(CLI::Range(1, 65535))
      ->envname("TESSERA_OSC_PORT");
}

Result<std::unique_ptr<LiveWall>> LiveWall::make(const LiveFlags& flags, const Scene& scene, const Wall& wall,
                                                 const CameraPath& path, bool interactive) {
  std::unique_ptr<LiveWall> live(new LiveWall);
  live->display_.overlay = flags.overlay;
  if (flags.identify) live->display_.pattern = proto::Pattern::Identify;
  if (flags.alignment) live->display_.pattern = proto::Pattern::Alignment;
  if (flags.oscPort > 0 && !wall.observer)
    return inputError("--osc-port", "the wall has no observer whose head could be tracked",
                      "add \"observer\": {\"eye_m\": [x, y, z]} to " + wall.source);
  const int port = flags.oscPort > 0 ? flags.oscPort : wall.observer ? wall.observer->oscPort : 0;
  if (port > 0) {
    auto tracker = HeadTracker::listen(port);
    if (!tracker) return tracker.error();
    live->tracker_ = std::move(*tracker);
    spdlog::info("listening for /tessera/head at UDP port {}", port);
  }
  if (interactive) {
    const double fovYRad = wall.observer ? 1.0 : wall.fovYRad;
    live->navigator_.emplace(viewsOf(path, scene), scene.sphere().center, scene.sphere().radius, fovYRad);
  }
  return live;
}

void LiveWall::hookInto(Master& master, Master::Hooks& hooks) {
  master.show(display_);
  hooks.input = [this, &master](std::uint32_t, const proto::Input& input) { handle(input, master); };
  if (navigator_ || tracker_) hooks.pose = [this](CameraPose& pose) { place(pose); };
}

void LiveWall::handle(const proto::Input& input, Master& master) {
  if (input.kind == proto::InputKind::Key && input.pressed) {
    const auto toggle = [&](proto::Pattern pattern) {
      display_.pattern = display_.pattern == pattern ? proto::Pattern::None : pattern;
    };
    if (input.code == kF1) display_.overlay = !display_.overlay;
    if (input.code == kF2) toggle(proto::Pattern::Identify);
    if (input.code == kF3) toggle(proto::Pattern::Alignment);
    master.show(display_);
  }
  if (navigator_) navigator_->handle(input);
}

void LiveWall::place(CameraPose& pose) {
  if (navigator_) {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = lastFrame_ ? std::chrono::duration<double>(now - *lastFrame_).count() : 0;
    lastFrame_ = now;
    pose = navigator_->advance(seconds);
  }
  if (!tracker_) return;
  const std::optional<Vec3> head = tracker_->headM();
  if (!head) return;
  pose.hasHead = true;
  pose.headM = *head;
}

}  // namespace tessera
