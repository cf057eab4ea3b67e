#include "client/offscreen_surface.h"

#include <cstring>
#include <string>

#include <GL/osmesa.h>
#include <dlfcn.h>

namespace tessera {

namespace {

class OffscreenSurface final : public Surface {
 public:
  OffscreenSurface(OSMesaContext context, int widthPx, int heightPx)
      : context_(context),
        widthPx_(static_cast<std::size_t>(widthPx)),
        heightPx_(static_cast<std::size_t>(heightPx)),
        rgba_(widthPx_ * heightPx_ * 4) {}
  ~OffscreenSurface() override { OSMesaDestroyContext(context_); }
  OffscreenSurface(const OffscreenSurface&) = delete;
  OffscreenSurface& operator=(const OffscreenSurface&) = delete;

  Status makeCurrent() override {
    if (!OSMesaMakeCurrent(context_, rgba_.data(), GL_UNSIGNED_BYTE, static_cast<GLsizei>(widthPx_),
                           static_cast<GLsizei>(heightPx_))) {
      return runtimeError("OSMesa", "cannot make its context current");
    }
    // With another OpenGL library linked beside OSMesa all calls go there, and nothing is drawn, silently.
    Dl_info info{};
    const bool isOsMesa = ::dladdr(reinterpret_cast<void*>(&glGetString), &info) != 0 && info.dli_fname &&
                          std::strstr(info.dli_fname, "OSMesa") != nullptr;
    if (glGetString(GL_VERSION) == nullptr || !isOsMesa) {
      return runtimeError(
          "OSMesa",
          std::string("OpenGL calls go to ") + (info.dli_fname ? info.dli_fname : "nowhere") + " instead",
          "do not preload or link another OpenGL library");
    }
    return Done{};
  }

  void present() override { glFinish(); }

  [[nodiscard]] std::vector<std::uint8_t> readPicture() const override {
    std::vector<std::uint8_t> rgb(widthPx_ * heightPx_ * 3);
    std::uint8_t* to = rgb.data();
    for (std::size_t row = heightPx_; row-- > 0;) {  // OSMesa's rows go up
      const std::uint8_t* from = rgba_.data() + row * widthPx_ * 4;
      for (std::size_t x = 0; x < widthPx_; ++x, from += 4, to += 3)
        std::memcpy(to, from, 3);
    }
    return rgb;
  }

 private:
  OSMesaContext context_;
  std::size_t widthPx_, heightPx_;
  std::vector<std::uint8_t> rgba_;
};

}  // namespace

int maxOffscreenSidePx() {
  GLint side = 0;
  OSMesaGetIntegerv(OSMESA_MAX_WIDTH, &side);
  GLint height = 0;
  OSMesaGetIntegerv(OSMESA_MAX_HEIGHT, &height);
  return side < height ? side : height;
}

Result<std::unique_ptr<Surface>> makeOffscreenSurface(int widthPx, int heightPx) {
  static constexpr int attributes[] = {OSMESA_FORMAT,
                                       OSMESA_RGBA,
                                       OSMESA_DEPTH_BITS,
                                       24,
                                       OSMESA_STENCIL_BITS,
                                       8,
                                       OSMESA_ACCUM_BITS,
                                       0,
                                       OSMESA_PROFILE,
                                       OSMESA_COMPAT_PROFILE,
                                       0};
  if (OSMesaContext context = OSMesaCreateContextAttribs(attributes, nullptr)) {
    return std::unique_ptr<Surface>(std::make_unique<OffscreenSurface>(context, widthPx, heightPx));
  }
  return runtimeError("OSMesa", "cannot create an OpenGL context");
}

}  // namespace tessera
