#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/base/result.h"

namespace tessera {

/// Where a tile is drawn. One thread, which makes the context current once and keeps it.
class Surface {
 public:
  virtual ~Surface() = default;
  /// Makes the surface's OpenGL context current in this thread.
  [[nodiscard]] virtual Status makeCurrent() = 0;
  /// Shows what was drawn.
  virtual void present() = 0;
  /// What was drawn last, RGB, 8 bits, rows from the top: width x height x 3 bytes.
  [[nodiscard]] virtual std::vector<std::uint8_t> readPicture() const = 0;
};

}  // namespace tessera
