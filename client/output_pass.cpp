#include "client/output_pass.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace tessera {

namespace {

constexpr GLenum kLuminance16 = 0x8042;  // GL_LUMINANCE16

constexpr const char* kFragmentSource = R"(
uniform sampler2D picture;
uniform vec2 texturePx;   // size of the texture, whose lower left holds the picture
uniform vec2 sizePx;      // of the picture as it is meant
uniform vec4 area;        // of the framebuffer: x, y, width, height; the picture as it is
uniform vec4 blendPx;     // left, right, bottom, top
uniform vec3 gain;
uniform vec3 black;
uniform float inverseGamma;
varying vec2 at;

float ramp(float distancePx, float widthPx) {
  if (widthPx <= 0.0) return 1.0;
  float t = clamp(distancePx / widthPx, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

#ifdef WARP
vec3 texel(vec2 px) {
  return texture2D(picture, (clamp(px, vec2(0.0), area.zw - 1.0) + 0.5) / texturePx).rgb;
}
// Of four texels in float: the weights of a texture unit are no finer than 1/256, and would blur a picture
// that is merely shifted.
vec3 lookUp(vec2 where) {
  vec2 px = where * area.zw - 0.5;
  vec2 low = floor(px);
  vec2 part = px - low;
  vec3 lower = mix(texel(low), texel(low + vec2(1.0, 0.0)), part.x);
  vec3 upper = mix(texel(low + vec2(0.0, 1.0)), texel(low + vec2(1.0, 1.0)), part.x);
  return mix(lower, upper, part.y);
}
#endif

#ifdef MASKS
uniform sampler2D alphaMask;
uniform float maskGamma;
#endif
#ifdef BETA
uniform sampler2D betaMask;
#endif

void main() {
  vec2 shown = (gl_FragCoord.xy - area.xy) / area.zw;
  vec2 mask = vec2(shown.x, 1.0 - shown.y);
#ifdef WARP
  vec2 where = at;
  if (any(lessThan(where, vec2(0.0))) || any(greaterThan(where, vec2(1.0)))) {
    gl_FragColor = vec4(0.0, 0.0, 0.0, 1.0);
    return;
  }
  vec3 encoded = lookUp(where);
#else
  vec2 where = shown;
  vec3 encoded = texture2D(picture, (gl_FragCoord.xy - area.xy) / texturePx).rgb;
#endif
  vec2 px = where * sizePx;
  vec4 edgePx = vec4(px.x, sizePx.x - px.x, px.y, sizePx.y - px.y);
  float light = ramp(edgePx.x, blendPx.x) * ramp(edgePx.y, blendPx.y) * ramp(edgePx.z, blendPx.z) *
                ramp(edgePx.w, blendPx.w);
  vec3 lift = any(lessThan(edgePx, blendPx)) ? vec3(0.0) : black;
#ifdef MASKS
  light *= pow(texture2D(alphaMask, mask).r, maskGamma);
#endif
#ifdef BETA
  lift = min(lift + texture2D(betaMask, mask).r, 1.0);
#endif
  encoded = min(encoded * pow(gain * light, vec3(inverseGamma)), 1.0);
  gl_FragColor = vec4(lift + (1.0 - lift) * encoded, 1.0);
}
)";

/// A mask of 16 bits. The texture must be bound to the unit that is active.
Status uploadMask(const proto::Warp& warp, std::span<const std::byte> mask) {
  std::vector<std::uint16_t> values(mask.size() / sizeof(std::uint16_t));
  std::memcpy(values.data(), mask.data(), mask.size());
  glPixelStorei(GL_UNPACK_SWAP_BYTES, std::endian::native == std::endian::big);
  glTexImage2D(GL_TEXTURE_2D, 0, kLuminance16, static_cast<GLsizei>(warp.maskWidthPx),
               static_cast<GLsizei>(warp.maskHeightPx), 0, GL_LUMINANCE, GL_UNSIGNED_SHORT, values.data());
  GLint bits = 0;
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_LUMINANCE_SIZE, &bits);
  if (bits < 16) return runtimeError("OpenGL", "has no textures of 16 bits for the masks of a warp");
  return Done{};
}

/// A vertex of the display at `column`, `row` from the top, with the place in the picture that it shows.
struct MeshVertex {
  float u, v;  ///< v from below
  [[nodiscard]] bool isHole() const { return std::isnan(u) || std::isnan(v); }
};

std::vector<MeshVertex> verticesOf(const proto::Warp& warp) {
  std::vector<MeshVertex> vertices(std::size_t{warp.columns} * warp.rows);
  const auto floatAt = [&](std::size_t index) {
    std::uint32_t bits = 0;
    for (std::size_t byte = 0; byte < 4; ++byte)
      bits |= std::to_integer<std::uint32_t>(warp.uv[4 * index + byte]) << (8 * byte);
    return std::bit_cast<float>(bits);
  };
  for (std::size_t i = 0; i < vertices.size(); ++i)
    vertices[i] = {floatAt(2 * i), 1.0F - floatAt(2 * i + 1)};
  return vertices;
}

/// The place of vertex `i` of `count` along a side, in clip coordinates.
float clipAt(std::size_t i, std::size_t count) {
  return -1.0F + 2.0F * static_cast<float>(i) / static_cast<float>(count - 1);
}

/// One row of cells as strips, which end at cells with a vertex that is a hole.
void drawRow(std::span<const MeshVertex> upper, std::span<const MeshVertex> lower, float upperY,
             float lowerY) {
  const auto isHole = [&](std::size_t i) { return upper[i].isHole() || lower[i].isHole(); };
  for (std::size_t first = 0; first < upper.size();) {
    std::size_t last = first;
    while (last < upper.size() && !isHole(last))
      ++last;
    if (last - first >= 2) {
      glBegin(GL_TRIANGLE_STRIP);
      for (std::size_t i = first; i < last; ++i) {
        const float x = clipAt(i, upper.size());
        glTexCoord2f(upper[i].u, upper[i].v);
        glVertex2f(x, upperY);
        glTexCoord2f(lower[i].u, lower[i].v);
        glVertex2f(x, lowerY);
      }
      glEnd();
    }
    first = last + 1;
  }
}

bool hasMasks(const proto::TileSetup& setup) {
  return setup.warp && setup.warp->maskWidthPx > 0;
}

}  // namespace

bool OutputPass::isNeeded(const proto::TileSetup& setup) {
  // Gamma alone changes nothing.
  const proto::TileSetup plain;
  return setup.warp || setup.gainRgb != plain.gainRgb || setup.blackRgb != plain.blackRgb ||
         setup.blendPx != plain.blendPx;
}

OutputPass::OutputPass(const osg::GLExtensions& gl, const proto::TileSetup& setup, PixelSize picture,
                       PixelSize drawn)
    : gl_(gl),
      picturePx_(picture),
      drawnPx_(drawn),
      gain_(setup.gainRgb),
      black_(setup.blackRgb),
      blendPx_(setup.blendPx),
      gamma_(setup.gamma),
      isWarped_(setup.warp.has_value()) {}

OutputPass::~OutputPass() {
  if (mesh_ != 0) glDeleteLists(mesh_, 1);
}

Result<std::unique_ptr<OutputPass>> OutputPass::make(const osg::GLExtensions& gl,
                                                     const proto::TileSetup& setup, PixelSize picture,
                                                     PixelSize drawn) {
  const GlScope scope(gl);
  const int maxPx = GlTexture::maxSidePx();
  const int maskPx =
      hasMasks(setup) ? static_cast<int>(std::max(setup.warp->maskWidthPx, setup.warp->maskHeightPx)) : 0;
  if (std::max({drawn.widthPx, drawn.heightPx, maskPx}) > maxPx) {
    return runtimeError("OpenGL",
                        "has no textures larger than " + std::to_string(maxPx) +
                            " pixels, which blending, gain and warp of this tile would take",
                        "cut the wall into smaller tiles, or the masks");
  }
  std::unique_ptr<OutputPass> pass(new OutputPass(gl, setup, picture, drawn));
  pass->picture_.bind();
  // As the framebuffer has them: without the fourth channel OSMesa converts every pixel, at three times the
  // cost.
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, drawn.widthPx, drawn.heightPx, 0, GL_RGBA, GL_UNSIGNED_BYTE,
               nullptr);
  if (hasMasks(setup)) {
    if (Status status = pass->makeMasks(*setup.warp); !status) return status.error();
  }
  if (Status status = pass->makeProgram(); !status) return status.error();
  pass->makeMesh(setup.warp);
  return pass;
}

Status OutputPass::makeMasks(const proto::Warp& warp) {
  maskGamma_ = warp.maskGamma;
  alpha_.emplace(GL_LINEAR);
  if (Status status = uploadMask(warp, warp.alpha); !status) return status;
  if (warp.beta.empty()) return Done{};
  beta_.emplace(GL_LINEAR);
  return uploadMask(warp, warp.beta);
}

Status OutputPass::makeProgram() {
  const std::string variant = std::string(isWarped_ ? "#define WARP\n" : "") +
                              (alpha_ ? "#define MASKS\n" : "") + (beta_ ? "#define BETA\n" : "");
  auto program = GlProgram::make(gl_, variant + kFragmentSource);
  if (!program) return program.error();
  program_ = std::move(*program);
  return Done{};
}

void OutputPass::makeMesh(const std::optional<proto::Warp>& warp) {
  mesh_ = glGenLists(1);
  glNewList(mesh_, GL_COMPILE);
  if (warp) {
    const std::vector<MeshVertex> vertices = verticesOf(*warp);
    const auto row = [&](std::size_t r) {
      return std::span(vertices).subspan(r * warp->columns, warp->columns);
    };
    for (std::size_t r = 0; r + 1 < warp->rows; ++r)
      drawRow(row(r), row(r + 1), -clipAt(r, warp->rows), -clipAt(r + 1, warp->rows));
  } else {
    const MeshVertex corners[] = {{0, 1}, {1, 1}, {0, 0}, {1, 0}};
    drawRow(std::span(corners).first<2>(), std::span(corners).last<2>(), 1, -1);
  }
  glEndList();
}

void OutputPass::setUniforms(const PixelArea& area) const {
  const auto real = [](int number) { return static_cast<float>(number); };
  program_->set("picture", 0);
  program_->set("texturePx", {real(drawnPx_.widthPx), real(drawnPx_.heightPx)});
  program_->set("sizePx", {real(picturePx_.widthPx), real(picturePx_.heightPx)});
  program_->set("area", {real(area.xPx), real(area.yPx), real(area.widthPx), real(area.heightPx)});
  program_->set("blendPx", {blendPx_[0], blendPx_[1], blendPx_[2], blendPx_[3]});
  program_->set("gain", {gain_[0], gain_[1], gain_[2]});
  program_->set("black", {black_[0], black_[1], black_[2]});
  program_->set("inverseGamma", {1.0F / gamma_});
  if (alpha_) {
    program_->set("alphaMask", 1);
    program_->set("maskGamma", {maskGamma_});
  }
  if (beta_) program_->set("betaMask", 2);
}

void OutputPass::apply(const PixelArea& area) const {
  const GlScope scope(gl_);
  scope.restrictTo(area);
  const std::optional<GlTexture>* masks[] = {&alpha_, &beta_};
  for (unsigned int i = 0; i < 2; ++i) {
    if (!*masks[i]) continue;
    gl_.glActiveTexture(GL_TEXTURE1 + i);
    (*masks[i])->bind();
  }
  gl_.glActiveTexture(GL_TEXTURE0);
  picture_.bind();
  glCopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, area.xPx, area.yPx, area.widthPx, area.heightPx);
  glClearColor(0, 0, 0, 1);
  if (isWarped_) glClear(GL_COLOR_BUFFER_BIT);  // the holes
  program_->use();
  setUniforms(area);
  glCallList(mesh_);
}

}  // namespace tessera
