#include "client/window_surface.h"

#include <algorithm>

#define GLFW_INCLUDE_NONE
#include <GL/gl.h>
#include <GLFW/glfw3.h>
#include <spdlog/spdlog.h>

#include "client/input_collector.h"

namespace tessera {

namespace {

static_assert(GLFW_JOYSTICK_LAST + 1 == InputCollector::kGamepads);
static_assert(GLFW_KEY_LAST <= proto::kMaxInputCode);
static_assert(GLFW_MOD_NUM_LOCK < 1 << proto::kInputModifierBits);
static_assert(GLFW_GAMEPAD_BUTTON_LAST < proto::kGamepadButtonBits && GLFW_GAMEPAD_AXIS_LAST == 5);

constexpr const char* kWhere = "--surface window";

/// Of the desktop, in its pixels; `right` and `bottom` are just outside.
struct Area {
  int left = 0, top = 0, right = 0, bottom = 0;
  [[nodiscard]] PixelSize size() const { return {right - left, bottom - top}; }
  [[nodiscard]] bool holds(const Area& other) const {
    return other.left >= left && other.top >= top && other.right <= right && other.bottom <= bottom;
  }
  [[nodiscard]] std::string text() const {
    return textOf(size()) + " at " + std::to_string(left) + "," + std::to_string(top);
  }
};

struct Monitor {
  GLFWmonitor* handle = nullptr;
  std::string name;
  Area area;
};

std::vector<Monitor> monitorsNow() {
  int count = 0;
  GLFWmonitor** handles = glfwGetMonitors(&count);
  std::vector<Monitor> monitors;
  for (int i = 0; i < count; ++i) {
    const GLFWvidmode* mode = glfwGetVideoMode(handles[i]);
    if (!mode) continue;
    const char* name = glfwGetMonitorName(handles[i]);
    Area area;
    glfwGetMonitorPos(handles[i], &area.left, &area.top);
    area.right = area.left + mode->width;
    area.bottom = area.top + mode->height;
    monitors.push_back({handles[i], name ? name : "", area});
  }
  return monitors;
}

Area desktopOf(const std::vector<Monitor>& monitors) {
  Area all = monitors.front().area;
  for (const Monitor& monitor : monitors) {
    all.left = std::min(all.left, monitor.area.left);
    all.top = std::min(all.top, monitor.area.top);
    all.right = std::max(all.right, monitor.area.right);
    all.bottom = std::max(all.bottom, monitor.area.bottom);
  }
  return all;
}

/// What GLFW complains of.
std::string lastComplaint() {
  const char* text = nullptr;
  (void)glfwGetError(&text);
  return text ? text : "no reason given";
}

class WindowSurface final : public Surface {
 public:
  WindowSurface(GLFWwindow* window, PixelSize size, bool waitsForRetrace)
      : window_(window), size_(size), waitsForRetrace_(waitsForRetrace) {
    glfwSetWindowUserPointer(window, this);
    glfwSetKeyCallback(window, [](GLFWwindow* of, int key, int, int action, int modifiers) {
      if (action == GLFW_PRESS && key == GLFW_KEY_ESCAPE) return inputsOf(of).quit();
      if (action != GLFW_REPEAT) inputsOf(of).key(key, action == GLFW_PRESS, modifiers);
    });
    glfwSetMouseButtonCallback(window, [](GLFWwindow* of, int button, int action, int modifiers) {
      double x = 0, y = 0;
      glfwGetCursorPos(of, &x, &y);
      inputsOf(of).button(button, action == GLFW_PRESS, modifiers, self(of).across(x), self(of).down(y));
    });
    glfwSetCursorPosCallback(window, [](GLFWwindow* of, double x, double y) {
      inputsOf(of).moveTo(self(of).across(x), self(of).down(y));
    });
    glfwSetScrollCallback(window,
                          [](GLFWwindow* of, double right, double up) { inputsOf(of).scroll(right, up); });
  }
  ~WindowSurface() override { glfwDestroyWindow(window_); }
  WindowSurface(const WindowSurface&) = delete;
  WindowSurface& operator=(const WindowSurface&) = delete;

  Status makeCurrent() override {
    glfwMakeContextCurrent(window_);
    if (Status status = checkContext(kWhere); !status) return status;
    glfwSwapInterval(waitsForRetrace_ ? 1 : 0);
    PixelSize made;
    glfwGetFramebufferSize(window_, &made.widthPx, &made.heightPx);
    if (made != size_) {
      return runtimeError(kWhere,
                          "the window manager made it " + textOf(made) + " instead of " + textOf(size_),
                          "use a desktop that leaves windows as they are");
    }
    return Done{};
  }

  [[nodiscard]] PixelSize drawnSize() const override { return size_; }
  void finish() override { glFinish(); }
  [[nodiscard]] std::vector<std::uint8_t> readPicture() const override { return readFramebuffer(size_); }

  void present() override {
    glfwSwapBuffers(window_);
    glFinish();  // so that it returns when the picture has changed, as far as the driver tells
  }

  [[nodiscard]] bool hasEvents() const override { return true; }

  void poll(std::vector<proto::Input>& inputs) override {
    glfwPollEvents();
    if (glfwWindowShouldClose(window_)) {
      glfwSetWindowShouldClose(window_, GLFW_FALSE);  // the master ends the tile
      inputs_.quit();
    }
    pollGamepads();
    inputs_.takeInto(inputs);
  }

 private:
  static WindowSurface& self(GLFWwindow* window) {
    return *static_cast<WindowSurface*>(glfwGetWindowUserPointer(window));
  }
  static InputCollector& inputsOf(GLFWwindow* window) { return self(window).inputs_; }
  [[nodiscard]] double across(double x) const { return x / size_.widthPx; }
  [[nodiscard]] double down(double y) const { return y / size_.heightPx; }

  void pollGamepads() {
    for (int number = 0; number <= GLFW_JOYSTICK_LAST; ++number) {
      const auto index = static_cast<std::size_t>(number);
      GLFWgamepadstate state;
      if (!glfwJoystickIsGamepad(number) || !glfwGetGamepadState(number, &state)) {
        inputs_.noGamepad(index);
        continue;
      }
      std::array<float, 6> axes = {};
      std::copy(std::begin(state.axes), std::end(state.axes), axes.begin());
      std::uint32_t buttons = 0;
      for (std::size_t bit = 0; bit < std::size(state.buttons); ++bit)
        buttons |= state.buttons[bit] == GLFW_PRESS ? 1U << bit : 0U;
      inputs_.gamepad(index, axes, buttons);
    }
  }

  GLFWwindow* window_;
  const PixelSize size_;
  const bool waitsForRetrace_;
  InputCollector inputs_;
};

class WindowSurfaces final : public SurfaceMaker {
 public:
  explicit WindowSurfaces(SurfaceOptions options) : options_(std::move(options)) {}
  ~WindowSurfaces() override {
    if (isInitialized_) glfwTerminate();
  }
  WindowSurfaces(const WindowSurfaces&) = delete;
  WindowSurfaces& operator=(const WindowSurfaces&) = delete;

  Status check() override {
    if (Status status = checkLibrary(kWhere, "libGL"); !status) return status;
    if (!isInitialized_ && !glfwInit()) {
      return runtimeError(
          kWhere, "no window can be opened: " + lastComplaint(),
          "set DISPLAY to a desktop that this user may use, or draw with --surface egl or offscreen");
    }
    isInitialized_ = true;
    if (!options_.monitor.empty()) return findMonitor().ok() ? Status(Done{}) : findMonitor().error();
    if (options_.window && options_.window->size) return areaFor(*options_.window->size);
    return Done{};
  }

  Result<std::unique_ptr<Surface>> make(const SurfaceRequest& request) override {
    if (Status status = check(); !status) return status.error();
    return options_.monitor.empty() ? makeAtPlace(request) : makeFullScreen(request);
  }

 private:
  [[nodiscard]] Result<Monitor> findMonitor() const {
    std::string names;
    for (const Monitor& monitor : monitorsNow()) {
      if (monitor.name == options_.monitor) return monitor;
      names += (names.empty() ? "" : ", ") + monitor.name + " (" + monitor.area.text() + ")";
    }
    return inputError("--monitor", "there is no monitor named \"" + options_.monitor + "\"",
                      names.empty() ? "this desktop has no monitors" : "there are: " + names);
  }

  [[nodiscard]] PixelPlace place() const { return options_.window.value_or(PixelPlace{}); }

  /// Whether a window of that size fits at its place.
  [[nodiscard]] Status areaFor(PixelSize size) const {
    const std::vector<Monitor> monitors = monitorsNow();
    if (monitors.empty()) return Done{};  // then nobody knows
    const Area area{place().xPx, place().yPx, place().xPx + size.widthPx, place().yPx + size.heightPx};
    const Area desktop = desktopOf(monitors);
    if (desktop.holds(area)) return Done{};
    const std::string what =
        "a window of " + area.text() + " reaches beyond the desktop of " + desktop.text();
    if (options_.window)
      return inputError("--window", what, "choose a place where it fits, or a smaller size with X,Y,WxH");
    return runtimeError(kWhere, what, "choose a smaller size with --window X,Y,WxH");
  }

  [[nodiscard]] Result<std::unique_ptr<Surface>> makeAtPlace(const SurfaceRequest& request) {
    const PixelSize size = place().size.value_or(request.picture);
    if (Status status = areaFor(size); !status) return status.error();
    return open(request, size, nullptr);
  }

  [[nodiscard]] Result<std::unique_ptr<Surface>> makeFullScreen(const SurfaceRequest& request) {
    const auto monitor = findMonitor();
    if (!monitor) return monitor.error();
    const PixelSize size = monitor->area.size();
    if (request.picture.widthPx > size.widthPx || request.picture.heightPx > size.heightPx) {
      return runtimeError(
          "--monitor " + monitor->name,
          "the tile's " + textOf(request.picture) + " pixels are more than its " + textOf(size),
          "make the tiles of the wall smaller, or draw it smaller with --window X,Y,WxH");
    }
    if (size != request.picture) {
      spdlog::warn("the tile has {} pixels and is drawn with the {} of monitor {}", textOf(request.picture),
                   textOf(size), monitor->name);
    }
    return open(request, size, monitor->handle);
  }

  [[nodiscard]] Result<std::unique_ptr<Surface>> open(const SurfaceRequest& request, PixelSize size,
                                                      GLFWmonitor* monitor) {
    glfwDefaultWindowHints();  // an OpenGL of the compatibility profile, 8 bits a colour
    glfwWindowHint(GLFW_DEPTH_BITS, 24);
    glfwWindowHint(GLFW_STENCIL_BITS, 8);
    glfwWindowHint(GLFW_SAMPLES, 0);
    glfwWindowHint(GLFW_DECORATED, GLFW_FALSE);
    glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
    glfwWindowHint(GLFW_AUTO_ICONIFY, GLFW_FALSE);
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);  // until it is in its place
    glfwWindowHintString(GLFW_X11_CLASS_NAME, "tessera");
    if (monitor) {
      // The monitor's own mode, so that it is not changed.
      const GLFWvidmode* mode = glfwGetVideoMode(monitor);
      glfwWindowHint(GLFW_REFRESH_RATE, mode->refreshRate);
    }
    GLFWwindow* window = glfwCreateWindow(size.widthPx, size.heightPx,
                                          ("tessera " + request.tileName).c_str(), monitor, nullptr);
    if (!window) return runtimeError(kWhere, "no window can be opened: " + lastComplaint());
    auto surface = std::make_unique<WindowSurface>(window, size, options_.waitsForRetrace);
    if (!monitor) glfwSetWindowPos(window, place().xPx, place().yPx);
    if (!options_.showsPointer) glfwSetInputMode(window, GLFW_CURSOR, GLFW_CURSOR_HIDDEN);
    glfwShowWindow(window);
    if (!monitor)
      glfwSetWindowPos(window, place().xPx, place().yPx);  // some window managers place what they show
    return std::unique_ptr<Surface>(std::move(surface));
  }

  const SurfaceOptions options_;
  bool isInitialized_ = false;
};

}  // namespace

std::unique_ptr<SurfaceMaker> makeWindowSurfaces(const SurfaceOptions& options) {
  return std::make_unique<WindowSurfaces>(options);
}

}  // namespace tessera
