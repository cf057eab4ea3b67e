#include "client/offscreen_surface.h"

#include <algorithm>
#include <cstring>

#include <GL/osmesa.h>

namespace tessera {

namespace {

class OffscreenSurface final : public Surface {
 public:
  OffscreenSurface(OSMesaContext context, PixelSize size)
      : context_(context),
        size_(size),
        rgba_(static_cast<std::size_t>(size.widthPx) * static_cast<std::size_t>(size.heightPx) * 4) {}
  ~OffscreenSurface() override { OSMesaDestroyContext(context_); }
  OffscreenSurface(const OffscreenSurface&) = delete;
  OffscreenSurface& operator=(const OffscreenSurface&) = delete;

  Status makeCurrent() override {
    if (!OSMesaMakeCurrent(context_, rgba_.data(), GL_UNSIGNED_BYTE, size_.widthPx, size_.heightPx))
      return runtimeError("OSMesa", "cannot make its context current");
    return checkContext("OSMesa");
  }

  [[nodiscard]] PixelSize drawnSize() const override { return size_; }
  void finish() override { glFinish(); }
  void present() override {}

  [[nodiscard]] std::vector<std::uint8_t> readPicture() const override {
    std::vector<std::uint8_t> rgb(rgba_.size() / 4 * 3);
    const std::size_t rowBytes = static_cast<std::size_t>(size_.widthPx) * 4;
    std::uint8_t* to = rgb.data();
    for (std::size_t end = rgba_.size(); end > 0; end -= rowBytes) {  // OSMesa's rows go up
      const std::uint8_t* from = rgba_.data() + end - rowBytes;
      for (int x = 0; x < size_.widthPx; ++x, from += 4, to += 3)
        std::memcpy(to, from, 3);
    }
    return rgb;
  }

 private:
  OSMesaContext context_;
  PixelSize size_;
  std::vector<std::uint8_t> rgba_;
};

class OffscreenSurfaces final : public SurfaceMaker {
 public:
  Status check() override { return checkLibrary("OSMesa", "OSMesa"); }

  [[nodiscard]] int maxSidePx() const override {
    GLint widthPx = 0, heightPx = 0;
    OSMesaGetIntegerv(OSMESA_MAX_WIDTH, &widthPx);
    OSMesaGetIntegerv(OSMESA_MAX_HEIGHT, &heightPx);
    return std::min(widthPx, heightPx);
  }

  Result<std::unique_ptr<Surface>> make(const SurfaceRequest& request) override {
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
    if (OSMesaContext context = OSMesaCreateContextAttribs(attributes, nullptr))
      return std::unique_ptr<Surface>(std::make_unique<OffscreenSurface>(context, request.picture));
    return runtimeError("OSMesa", "cannot create an OpenGL context");
  }
};

}  // namespace

std::unique_ptr<SurfaceMaker> makeOffscreenSurfaces() {
  return std::make_unique<OffscreenSurfaces>();
}

}  // namespace tessera
