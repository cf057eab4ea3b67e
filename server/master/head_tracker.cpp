#include "server/master/head_tracker.h"

#include <cmath>
#include <mutex>
#include <string>
#include <string_view>

#include <lo/lo.h>

namespace tessera {

namespace {

constexpr double kFarthestM = 1000;

class OscTracker final : public HeadTracker {
 public:
  OscTracker() = default;
  OscTracker(const OscTracker&) = delete;
  OscTracker& operator=(const OscTracker&) = delete;
  ~OscTracker() override {
    if (!server_) return;
    lo_server_thread_stop(server_);
    lo_server_thread_free(server_);
  }

  Status open(int port) {
    const std::string text = port > 0 ? std::to_string(port) : std::string();
    server_ = lo_server_thread_new(port > 0 ? text.c_str() : nullptr, nullptr);
    if (!server_)
      return runtimeError("OSC port " + text, "cannot be opened", "is another program listening there?");
    lo_server_thread_add_method(server_, "/tessera/head", nullptr, &OscTracker::hear, this);
    if (lo_server_thread_start(server_) < 0)
      return runtimeError("OSC port " + text, "the thread that listens cannot be started");
    return Done{};
  }

  std::optional<Vec3> headM() const override {
    const std::lock_guard lock(mutex_);
    return headM_;
  }
  int port() const override { return lo_server_thread_get_port(server_); }

 private:
  static int hear(const char*, const char* types, lo_arg** values, int count, lo_message, void* self) {
    if (count != 3 || !types) return 0;
    Vec3 head;
    for (int i = 0; i < 3; ++i) {
      if (types[i] != 'f' && types[i] != 'd') return 0;
      head[i] = types[i] == 'f' ? static_cast<double>(values[i]->f) : values[i]->d;
      if (!std::isfinite(head[i]) || std::abs(head[i]) > kFarthestM) return 0;
    }
    auto* tracker = static_cast<OscTracker*>(self);
    const std::lock_guard lock(tracker->mutex_);
    tracker->headM_ = head;
    return 0;
  }

  lo_server_thread server_ = nullptr;
  mutable std::mutex mutex_;
  std::optional<Vec3> headM_;
};

}  // namespace

Result<std::unique_ptr<HeadTracker>> HeadTracker::listen(int port) {
  auto tracker = std::make_unique<OscTracker>();
  if (Status status = tracker->open(port); !status) return status.error();
  return std::unique_ptr<HeadTracker>(std::move(tracker));
}

}  // namespace tessera
