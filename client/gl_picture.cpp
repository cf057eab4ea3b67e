#include "client/gl_picture.h"

#include <algorithm>
#include <string>
#include <utility>

namespace tessera {

namespace {

constexpr const char* kFragmentSource = R"(
uniform sampler2D picture;
uniform float opacity;
varying vec2 at;
void main() {
  vec3 colour = texture2D(picture, at).rgb;
  float brightest = max(colour.r, max(colour.g, colour.b));
  gl_FragColor = vec4(colour, mix(opacity, 1.0, brightest));
}
)";

}  // namespace

Result<std::unique_ptr<GlPicture>> GlPicture::make(const osg::GLExtensions& gl) {
  const GlScope scope(gl);
  auto program = GlProgram::make(gl, kFragmentSource);
  if (!program) return program.error();
  return std::unique_ptr<GlPicture>(new GlPicture(gl, std::move(*program)));
}

Status GlPicture::upload(const Picture& picture) {
  if (const int maxPx = GlTexture::maxSidePx(); std::max(picture.widthPx, picture.heightPx) > maxPx) {
    return runtimeError("OpenGL", "has no textures larger than " + std::to_string(maxPx) + " pixels",
                        "cut the wall into smaller tiles");
  }
  const GlScope scope(gl_);
  texture_.bind();
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, picture.widthPx, picture.heightPx, 0, GL_RGB, GL_UNSIGNED_BYTE,
               picture.rgb.data());
  widthPx_ = picture.widthPx;
  heightPx_ = picture.heightPx;
  return Done{};
}

void GlPicture::draw(const PixelArea& area, float opacity) const {
  const GlScope scope(gl_);
  scope.restrictTo(area);
  texture_.bind();
  const bool isWhole = area.widthPx == widthPx_ && area.heightPx == heightPx_;
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, isWhole ? GL_NEAREST : GL_LINEAR);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
  program_->use();
  program_->set("picture", 0);
  program_->set("opacity", {opacity});
  glBegin(GL_TRIANGLE_STRIP);  // the texture's first row is the upper one
  for (const float x : {0.0F, 1.0F}) {
    for (const float y : {0.0F, 1.0F}) {
      glTexCoord2f(x, y);
      glVertex2f(2 * x - 1, 1 - 2 * y);
    }
  }
  glEnd();
}

}  // namespace tessera
