#include "common/image/mosaic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace tessera {

namespace {

/// A point of the picture, in pixels of the part.
struct ToPart {
  double determinant, x0, y0, ax, ay, dx, dy;
  explicit ToPart(const MosaicPlace& p)
      : determinant(p.acrossX * p.downY - p.acrossY * p.downX),
        x0(p.x),
        y0(p.y),
        ax(p.acrossX),
        ay(p.acrossY),
        dx(p.downX),
        dy(p.downY) {}
  [[nodiscard]] std::array<double, 2> operator()(double x, double y) const {
    return {((x - x0) * dy - (y - y0) * dx) / determinant, ((y - y0) * ax - (x - x0) * ay) / determinant};
  }
};

bool isWhole(double x) {
  return x == std::round(x);
}

/// Its pixels are pixels of the picture.
bool isAligned(const MosaicPlace& p) {
  const auto isUnit = [](double x, double y) { return std::abs(x) + std::abs(y) == 1 && x * y == 0; };
  return isWhole(p.x) && isWhole(p.y) && isUnit(p.acrossX, p.acrossY) && isUnit(p.downX, p.downY);
}

}  // namespace

Mosaic::Mosaic(int widthPx, int heightPx, double gamma) : gamma_(gamma), picture_(widthPx, heightPx) {
  if (gamma <= 0) return;
  light_.assign(picture_.rgb.size(), 0.0F);
  lightOf_.resize(256);
  for (std::size_t i = 0; i < 256; ++i)
    lightOf_[i] = static_cast<float>(std::pow(static_cast<double>(i) / 255, gamma));
}

void Mosaic::add(const MosaicPlace& place, int width, int height, std::span<const std::uint8_t> part) {
  const ToPart toPart(place);
  if (!(std::abs(toPart.determinant) > 0)) return;
  double left = INFINITY, right = -INFINITY, top = INFINITY, bottom = -INFINITY;
  for (const double i : {0.0, static_cast<double>(width)}) {
    for (const double j : {0.0, static_cast<double>(height)}) {
      const double x = place.x + i * place.acrossX + j * place.downX;
      const double y = place.y + i * place.acrossY + j * place.downY;
      left = std::min(left, x), right = std::max(right, x);
      top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  const auto clamped = [](double v, int most) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(most)));
  };
  const int firstX = clamped(std::floor(left), picture_.widthPx),
            endX = clamped(std::ceil(right), picture_.widthPx);
  const int firstY = clamped(std::floor(top), picture_.heightPx),
            endY = clamped(std::ceil(bottom), picture_.heightPx);
  const bool copies = isAligned(place);
  const auto at = [&](int i, int j) {
    return part.data() +
           (static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i)) * 3;
  };
  for (int y = firstY; y < endY; ++y) {
    for (int x = firstX; x < endX; ++x) {
      const auto [u, v] = toPart(x + 0.5, y + 0.5);
      if (!(u >= 0 && u < width && v >= 0 && v < height)) continue;
      const std::size_t to = (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.widthPx) +
                              static_cast<std::size_t>(x)) *
                             3;
      const int i = static_cast<int>(copies ? u : std::floor(u - 0.5)),
                j = static_cast<int>(copies ? v : std::floor(v - 0.5));
      const double s = u - 0.5 - i, t = v - 0.5 - j;
      const int i0 = std::max(i, 0), i1 = std::min(i + 1, width - 1), j0 = std::max(j, 0),
                j1 = std::min(j + 1, height - 1);
      for (std::size_t c = 0; c < 3; ++c) {
        const auto value = [&](int a, int b) {
          const std::uint8_t byte = at(a, b)[c];
          return light_.empty() ? static_cast<double>(byte) : static_cast<double>(lightOf_[byte]);
        };
        const double sample = copies ? value(i, j)
                                     : (1 - t) * ((1 - s) * value(i0, j0) + s * value(i1, j0)) +
                                           t * ((1 - s) * value(i0, j1) + s * value(i1, j1));
        if (light_.empty()) {
          picture_.rgb[to + c] = static_cast<std::uint8_t>(std::lround(sample));
        } else {
          light_[to + c] += static_cast<float>(sample);
        }
      }
    }
  }
}

Picture Mosaic::finish() {
  for (std::size_t i = 0; i < light_.size(); ++i) {
    const double value = std::pow(std::min(1.0, static_cast<double>(light_[i])), 1 / gamma_);
    picture_.rgb[i] = static_cast<std::uint8_t>(std::lround(255 * value));
  }
  return std::move(picture_);
}

}  // namespace tessera
