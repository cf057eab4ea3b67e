#include "client/egl_surface.h"

#include <algorithm>
#include <cstdio>

#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>

namespace tessera {

namespace {

constexpr const char* kWhere = "--surface egl";
constexpr EGLint kMaxDevices = 64;

bool has(const char* extensions, std::string_view name) {
  std::string_view rest = extensions ? extensions : "";
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == name) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

std::string complaint(const char* call) {
  char text[64];
  std::snprintf(text, sizeof text, "%s: error 0x%x", call, static_cast<unsigned>(eglGetError()));
  return text;
}

struct Device {
  EGLDeviceEXT handle = nullptr;
  std::string name;
};

std::vector<Device> devicesNow() {
  if (!has(eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), "EGL_EXT_platform_device")) return {};
  const auto query = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  const auto text =
      reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(eglGetProcAddress("eglQueryDeviceStringEXT"));
  EGLDeviceEXT handles[kMaxDevices];
  EGLint count = 0;
  if (!query || !text || !query(kMaxDevices, handles, &count)) return {};
  std::vector<Device> devices;
  for (EGLint i = 0; i < count; ++i) {
    const bool isCard = has(text(handles[i], EGL_EXTENSIONS), "EGL_EXT_device_drm");
    const char* file = isCard ? text(handles[i], EGL_DRM_DEVICE_FILE_EXT) : nullptr;
    devices.push_back({handles[i], "device " + std::to_string(i) + (file ? " " + std::string(file) : "")});
  }
  return devices;
}

/// One display with a context and a buffer to draw into; freed in the right order.
class EglSurface final : public Surface {
 public:
  EglSurface(EGLDisplay display, PixelSize size) : display_(display), size_(size) {}
  ~EglSurface() override {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (buffer_ != EGL_NO_SURFACE) eglDestroySurface(display_, buffer_);
    if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
    eglTerminate(display_);
  }
  EglSurface(const EglSurface&) = delete;
  EglSurface& operator=(const EglSurface&) = delete;

  /// Makes context and buffer; empty, or what went wrong. Call once.
  [[nodiscard]] std::string open() {
    if (!eglInitialize(display_, nullptr, nullptr)) return complaint("eglInitialize");
    if (!eglBindAPI(EGL_OPENGL_API)) return complaint("eglBindAPI");
    static constexpr EGLint attributes[] = {EGL_SURFACE_TYPE,
                                            EGL_PBUFFER_BIT,
                                            EGL_RENDERABLE_TYPE,
                                            EGL_OPENGL_BIT,
                                            EGL_RED_SIZE,
                                            8,
                                            EGL_GREEN_SIZE,
                                            8,
                                            EGL_BLUE_SIZE,
                                            8,
                                            EGL_ALPHA_SIZE,
                                            8,
                                            EGL_DEPTH_SIZE,
                                            24,
                                            EGL_STENCIL_SIZE,
                                            8,
                                            EGL_SAMPLES,
                                            0,
                                            EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (!eglChooseConfig(display_, attributes, &config, 1, &count) || count == 0)
      return complaint("eglChooseConfig");
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, nullptr);
    if (context_ == EGL_NO_CONTEXT) return complaint("eglCreateContext");
    const EGLint sides[] = {EGL_WIDTH, size_.widthPx, EGL_HEIGHT, size_.heightPx, EGL_NONE};
    buffer_ = eglCreatePbufferSurface(display_, config, sides);
    if (buffer_ == EGL_NO_SURFACE) return complaint("eglCreatePbufferSurface");
    if (!eglMakeCurrent(display_, buffer_, buffer_, context_)) return complaint("eglMakeCurrent");
    return {};
  }

  Status makeCurrent() override {
    if (!eglMakeCurrent(display_, buffer_, buffer_, context_))
      return runtimeError(kWhere, complaint("eglMakeCurrent"));
    if (Status status = checkContext(kWhere); !status) return status;
    PixelSize made;
    eglQuerySurface(display_, buffer_, EGL_WIDTH, &made.widthPx);
    eglQuerySurface(display_, buffer_, EGL_HEIGHT, &made.heightPx);
    if (made == size_) return Done{};
    return runtimeError(kWhere, "the driver has no room for " + textOf(size_) + " pixels",
                        "cut the wall into smaller tiles");
  }

  [[nodiscard]] PixelSize drawnSize() const override { return size_; }
  void finish() override { glFinish(); }
  void present() override {}
  [[nodiscard]] std::vector<std::uint8_t> readPicture() const override { return readFramebuffer(size_); }

 private:
  EGLDisplay display_;
  const PixelSize size_;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface buffer_ = EGL_NO_SURFACE;
};

class EglSurfaces final : public SurfaceMaker {
 public:
  explicit EglSurfaces(const SurfaceOptions& options) : device_(options.eglDevice) {}

  /// Opens a small surface, so that a missing driver is told before the master is asked for anything.
  Status check() override {
    if (Status status = checkLibrary(kWhere, "libGL"); !status) return status;
    if (Status status = checkDevice(); !status) return status;
    const auto trial = open({16, 16});
    return trial ? (*trial)->makeCurrent() : Status(trial.error());
  }

  Result<std::unique_ptr<Surface>> make(const SurfaceRequest& request) override {
    return open(request.picture);
  }

 private:
  [[nodiscard]] Status checkDevice() const {
    if (!device_) return Done{};
    const std::vector<Device> devices = devicesNow();
    if (static_cast<std::size_t>(*device_) < devices.size()) return Done{};
    std::string names;
    for (const Device& device : devices)
      names += (names.empty() ? "" : ", ") + device.name;
    return inputError("--egl-device", "there is no device " + std::to_string(*device_),
                      names.empty() ? "EGL tells of none; leave it out" : "there are: " + names);
  }

  [[nodiscard]] Result<std::unique_ptr<Surface>> open(PixelSize size) const {
    const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    const auto displayOf =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
    if (!displayOf || !has(extensions, "EGL_EXT_platform_base")) {
      return runtimeError(kWhere, "this EGL draws on displays alone",
                          "draw with --surface offscreen or window");
    }
    std::string tried;
    const auto attempt = [&](EGLenum platform, void* native, const std::string& name) {
      return attemptOn(displayOf(platform, native, nullptr), size, name, tried);
    };
    const std::vector<Device> devices = devicesNow();
    for (std::size_t i = 0; i < devices.size(); ++i) {
      if (device_ && i != static_cast<std::size_t>(*device_)) continue;
      if (auto surface = attempt(EGL_PLATFORM_DEVICE_EXT, devices[i].handle, devices[i].name)) return surface;
    }
    if (!device_ && has(extensions, "EGL_MESA_platform_surfaceless")) {
      if (auto surface = attempt(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, "surfaceless"))
        return surface;
    }
    if (tried.empty()) tried = "nothing, for EGL has neither devices nor Mesa's surfaceless platform";
    return runtimeError(kWhere, "no OpenGL can be had; tried " + tried,
                        "install a driver with EGL, or draw with --surface offscreen");
  }

  /// Null where it does not work; then `tried` says why.
  static std::unique_ptr<Surface> attemptOn(EGLDisplay display, PixelSize size, const std::string& name,
                                            std::string& tried) {
    std::string wrong = display == EGL_NO_DISPLAY ? complaint("eglGetPlatformDisplay") : "";
    if (wrong.empty()) {
      auto surface = std::make_unique<EglSurface>(display, size);
      wrong = surface->open();
      if (wrong.empty()) return surface;
    }
    tried += (tried.empty() ? "" : "; ") + name + " (" + wrong + ")";
    return nullptr;
  }

  const std::optional<int> device_;
};

}  // namespace

std::unique_ptr<SurfaceMaker> makeEglSurfaces(const SurfaceOptions& options) {
  return std::make_unique<EglSurfaces>(options);
}

}  // namespace tessera
