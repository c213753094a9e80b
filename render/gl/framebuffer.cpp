// A framebuffer object with two renderbuffers: colours as RGBA, 8 bits each, and depth as 32-bit
// floats. Renderbuffers, not textures, since nothing samples them. Depth has the finest format that
// OpenGL 3.3 offers.
#include "render/gl/framebuffer.h"

#include <fmt/format.h>

#include "render/gl/opengl.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

/// A new renderbuffer that is the framebuffer's colours or depth. `format` is GL_RGBA8 or a depth
/// format.
GLuint attach(GLenum format, GLenum attachment, int width, int height) {
  GLuint renderbuffer = 0;
  glGenRenderbuffers(1, &renderbuffer);
  glBindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
  glRenderbufferStorage(GL_RENDERBUFFER, format, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, renderbuffer);
  return renderbuffer;
}

}  // namespace

Framebuffer::Framebuffer(int width, int height) : sides_(width, height) {
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  colour_ = attach(GL_RGBA8, GL_COLOR_ATTACHMENT0, width, height);
  depth_ = attach(GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT, width, height);
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  // A driver that is short of memory says so by an error, or by a framebuffer that is not complete.
  if (glGetError() != GL_NO_ERROR || status != GL_FRAMEBUFFER_COMPLETE) {
    throw OutputError(
        fmt::format("error: the OpenGL driver cannot draw {} x {} samples (status {:#x}); choose a "
                    "smaller picture with --size",
                    width, height, status));
  }
}

Framebuffer::~Framebuffer() {
  glDeleteFramebuffers(1, &framebuffer_);
  glDeleteRenderbuffers(1, &colour_);
  glDeleteRenderbuffers(1, &depth_);
}

void Framebuffer::drawInto() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, sides_.x(), sides_.y());
}

void Framebuffer::read(const Eigen::AlignedBox2i& box, int rowPixels, std::uint8_t* pixels) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  // Rows of the destination may be longer than the box is wide: tiles of one picture are read into
  // their places.
  glPixelStorei(GL_PACK_ROW_LENGTH, rowPixels);
  glReadPixels(box.min().x(), box.min().y(), box.sizes().x(), box.sizes().y(), GL_RGBA,
               GL_UNSIGNED_BYTE, pixels);
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  throw OutputError(fmt::format(
      "error: the OpenGL driver failed while drawing (code {:#x}); choose a smaller picture with "
      "--size or free some memory",
      error));
}

}  // namespace kirireel
