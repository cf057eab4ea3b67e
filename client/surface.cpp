#include "client/surface.h"

#include <algorithm>
#include <cstring>

#include <GL/gl.h>
#include <dlfcn.h>

namespace tessera {

namespace {

std::size_t rowBytes(PixelSize size) {
  return static_cast<std::size_t>(size.widthPx) * 3;
}

std::size_t pictureBytes(PixelSize size) {
  return rowBytes(size) * static_cast<std::size_t>(size.heightPx);
}

int integerOf(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

}  // namespace

Status checkLibrary(const std::string& where, std::string_view library) {
  Dl_info info{};
  const bool isFound = ::dladdr(reinterpret_cast<void*>(&glGetString), &info) != 0 && info.dli_fname;
  const std::string_view found = isFound ? info.dli_fname : "nowhere";
  if (found.find(library) != std::string_view::npos) return Done{};
  return runtimeError(where, "OpenGL calls go to " + std::string(found) + " instead",
                      "do not preload or link another OpenGL library");
}

Status checkContext(const std::string& where) {
  if (glGetString(GL_VERSION) == nullptr) {
    return runtimeError(where, "OpenGL calls do not arrive in its context",
                        "do not preload or link another OpenGL library");
  }
  const int depthBits = integerOf(GL_DEPTH_BITS), stencilBits = integerOf(GL_STENCIL_BITS);
  if (depthBits >= 24 && stencilBits >= 8 && integerOf(GL_SAMPLES) == 0) return Done{};
  return runtimeError(where,
                      "its driver has no picture of 24 bits of depth, 8 of stencil and one sample a pixel");
}

std::vector<std::uint8_t> readFramebuffer(PixelSize size) {
  std::vector<std::uint8_t> upward(pictureBytes(size)), rgb(upward.size());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, size.widthPx, size.heightPx, GL_RGB, GL_UNSIGNED_BYTE, upward.data());
  const std::size_t row = rowBytes(size);
  for (std::size_t at = 0; at < rgb.size(); at += row)
    std::memcpy(rgb.data() + at, upward.data() + (rgb.size() - row - at), row);
  return rgb;
}

std::vector<std::uint8_t> resampled(std::vector<std::uint8_t> rgb, PixelSize from, PixelSize to) {
  if (from == to) return rgb;
  // The pixel whose middle is nearest, of `count` that lie where `wanted` shall.
  const auto nearest = [](int index, int count, int wanted) {
    const std::int64_t at = (2 * std::int64_t{index} + 1) * count / (2 * std::int64_t{wanted});
    return static_cast<std::size_t>(std::min<std::int64_t>(at, count - 1));
  };
  std::vector<std::uint8_t> out(pictureBytes(to));
  std::uint8_t* pixel = out.data();
  for (int y = 0; y < to.heightPx; ++y) {
    const std::uint8_t* row = rgb.data() + nearest(y, from.heightPx, to.heightPx) * rowBytes(from);
    for (int x = 0; x < to.widthPx; ++x, pixel += 3)
      std::memcpy(pixel, row + 3 * nearest(x, from.widthPx, to.widthPx), 3);
  }
  return out;
}

}  // namespace tessera
