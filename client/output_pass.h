#pragma once

#include <array>
#include <memory>
#include <optional>

#include <osg/GLExtensions>

#include "client/gl_program.h"
#include "client/gl_scope.h"
#include "client/gl_texture.h"
#include "common/base/pixel_place.h"
#include "common/base/result.h"
#include "proto/messages.h"

namespace tessera {

/// What a display needs after its picture is drawn: edge blending, gain, masks, black level, warp. Takes the
/// picture out of the framebuffer and puts it back corrected.
///
/// light = encoded ^ gamma, so a factor of light is one of encoded ^ (1 / gamma):
///
///   out = black + (1 - black) * encoded * (gain * ramps * alpha ^ maskGamma) ^ (1 / gamma)
///
/// which is exact where the factor is 1. A ramp at t = distance from its edge / its width is 3t^2 - 2t^3. Two
/// tiles that overlap see one point at t and at 1 - t, and these ramps sum to 1. The distances are those of
/// the drawn picture, so ramps of a warped picture meet as well.
///
/// Black is lifted so because it must not clip (a maximum would drown the darkest shades) and white must stay
/// white. `blackRgb` lifts only outside of the ramps: in an overlap the black light of several projectors
/// adds up by itself. Where a warp has a beta mask this is added everywhere, as the mask says itself where.
class OutputPass {
 public:
  /// False: the picture is to be shown as it was drawn, and no pass must be made.
  [[nodiscard]] static bool isNeeded(const proto::TileSetup& setup);

  /// For pictures of the given size that are drawn in another, in the context that is current and stays so.
  /// Copies what it needs of `setup`; keeps `gl`. Fails where OpenGL has no shaders or no textures of that
  /// size.
  [[nodiscard]] static Result<std::unique_ptr<OutputPass>> make(const osg::GLExtensions& gl,
                                                                const proto::TileSetup& setup,
                                                                PixelSize picture, PixelSize drawn);
  ~OutputPass();
  OutputPass(const OutputPass&) = delete;
  OutputPass& operator=(const OutputPass&) = delete;

  /// Corrects what the buffer that OpenGL reads from and draws to shows in `area`: the whole picture, in its
  /// own size or squeezed into less. Leaves the state of OpenGL as it was.
  void apply(const PixelArea& area) const;

 private:
  OutputPass(const osg::GLExtensions& gl, const proto::TileSetup& setup, PixelSize picture, PixelSize drawn);
  Status makeProgram();
  Status makeMasks(const proto::Warp& warp);
  void makeMesh(const std::optional<proto::Warp>& warp);
  void setUniforms(const PixelArea& area) const;

  const osg::GLExtensions& gl_;
  const PixelSize picturePx_, drawnPx_;
  std::array<float, 3> gain_, black_;
  std::array<float, 4> blendPx_;
  float gamma_, maskGamma_ = 1;
  bool isWarped_;
  std::unique_ptr<GlProgram> program_;
  GlTexture picture_{GL_NEAREST};
  std::optional<GlTexture> alpha_, beta_;
  GLuint mesh_ = 0;  ///< a display list
};

}  // namespace tessera
