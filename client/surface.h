#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/pixel_place.h"
#include "common/base/result.h"
#include "proto/messages.h"

namespace tessera {

/// Where a tile is drawn. One thread, which makes the context current once and keeps it.
///
/// A frame is drawn, finished, held back until the wall swaps, then presented.
class Surface {
 public:
  virtual ~Surface() = default;
  /// Makes the surface's OpenGL context current in this thread.
  [[nodiscard]] virtual Status makeCurrent() = 0;
  /// Size of the picture as it is drawn; that of a window may differ from the tile's.
  [[nodiscard]] virtual PixelSize drawnSize() const = 0;
  /// Returns once all that was drawn is complete. Nobody sees it yet.
  virtual void finish() = 0;
  /// What was finished last and not yet presented, RGB, 8 bits, rows from the top: width x height x 3 bytes
  /// of the drawn size.
  [[nodiscard]] virtual std::vector<std::uint8_t> readPicture() const = 0;
  /// Shows what was finished.
  virtual void present() = 0;
  /// Whether poll() is to be called, about 60 times a second.
  [[nodiscard]] virtual bool hasEvents() const { return false; }
  /// Answers the window system and adds what a person did since the last call, at most 12 events.
  virtual void poll(std::vector<proto::Input>&) {}
};

struct SurfaceRequest {
  std::string tileName;
  PixelSize picture;  ///< of the tile
};

/// Makes the surfaces of one kind. Outlives them.
class SurfaceMaker {
 public:
  virtual ~SurfaceMaker() = default;
  /// Finds what is wrong whatever the tile: no display, an unknown monitor. Called before the master is.
  [[nodiscard]] virtual Status check() = 0;
  /// Largest side of a picture; 0: not known in advance.
  [[nodiscard]] virtual int maxSidePx() const { return 0; }
  [[nodiscard]] virtual Result<std::unique_ptr<Surface>> make(const SurfaceRequest& request) = 0;
};

/// Checks that OpenGL calls go to a library in whose file name `library` occurs. libosg calls whichever
/// OpenGL library was linked first; where that is not the one of the context nothing is drawn, and nobody
/// says so. `where` names the surface.
[[nodiscard]] Status checkLibrary(const std::string& where, std::string_view library);

/// Checks the context that was just made current: OpenGL calls arrive in it, depth has at least 24 bits,
/// stencil 8, and there are no samples to a pixel. `where` names the surface.
[[nodiscard]] Status checkContext(const std::string& where);

/// readPicture() of the current context's framebuffer.
[[nodiscard]] std::vector<std::uint8_t> readFramebuffer(PixelSize size);

/// A picture as of readPicture() in another size, each pixel the nearest one.
[[nodiscard]] std::vector<std::uint8_t> resampled(std::vector<std::uint8_t> rgb, PixelSize from,
                                                  PixelSize to);

}  // namespace tessera
