#include "client/gl_scope.h"

namespace tessera {

namespace {

constexpr GLenum kVertexArrayBinding = 0x85B5;   // GL_VERTEX_ARRAY_BINDING
constexpr GLenum kUnpackBuffer = 0x88EC;         // GL_PIXEL_UNPACK_BUFFER
constexpr GLenum kUnpackBufferBinding = 0x88EF;  // GL_PIXEL_UNPACK_BUFFER_BINDING

}  // namespace

GlScope::GlScope(const osg::GLExtensions& gl) : gl_(gl) {
  glPushAttrib(GL_ALL_ATTRIB_BITS);
  glPushClientAttrib(GL_CLIENT_ALL_ATTRIB_BITS);
  glGetIntegerv(GL_CURRENT_PROGRAM, &program_);
  gl_.glUseProgram(0);
  if (gl_.glBindVertexArray) {
    glGetIntegerv(kVertexArrayBinding, &vertexArray_);
    gl_.glBindVertexArray(0);
  }
  glGetIntegerv(kUnpackBufferBinding, &unpackBuffer_);
  gl_.glBindBuffer(kUnpackBuffer, 0);
  for (const GLenum mode : {GL_DEPTH_TEST, GL_STENCIL_TEST, GL_ALPHA_TEST, GL_BLEND, GL_CULL_FACE,
                            GL_SCISSOR_TEST, GL_COLOR_LOGIC_OP, GL_DITHER, GL_FOG, GL_LIGHTING,
                            GL_POLYGON_STIPPLE, GL_POLYGON_OFFSET_FILL, GL_POLYGON_SMOOTH}) {
    glDisable(mode);
  }
  for (GLenum plane = 0; plane < 6; ++plane)
    glDisable(GL_CLIP_PLANE0 + plane);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_FALSE);
  gl_.glActiveTexture(GL_TEXTURE0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glPixelStorei(GL_UNPACK_SKIP_ROWS, 0);
  glPixelStorei(GL_UNPACK_SKIP_PIXELS, 0);
  glPixelStorei(GL_UNPACK_SWAP_BYTES, GL_FALSE);
}

GlScope::~GlScope() {
  gl_.glUseProgram(static_cast<GLuint>(program_));
  if (gl_.glBindVertexArray) gl_.glBindVertexArray(static_cast<GLuint>(vertexArray_));
  glPopClientAttrib();
  gl_.glBindBuffer(kUnpackBuffer, static_cast<GLuint>(unpackBuffer_));
  glPopAttrib();
}

void GlScope::restrictTo(const PixelArea& area) const {
  glViewport(area.xPx, area.yPx, area.widthPx, area.heightPx);
  glScissor(area.xPx, area.yPx, area.widthPx, area.heightPx);
  glEnable(GL_SCISSOR_TEST);
}

}  // namespace tessera
