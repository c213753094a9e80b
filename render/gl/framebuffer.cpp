#include "render/gl/framebuffer.h"

#include <fmt/format.h>

#include "render/gl/opengl.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

void attachTexture(GLuint texture, int width, int height) {
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
}

void attachDepth(GLuint renderbuffer, int width, int height) {
  glBindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT32F, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, renderbuffer);
}

}  // namespace

Framebuffer::Framebuffer(int width, int height, Depth depth) {
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glGenTextures(1, &texture_);
  attachTexture(texture_, width, height);
  if (depth == Depth::Tested) {
    glGenRenderbuffers(1, &depth_);
    attachDepth(depth_, width, height);
  }
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (glGetError() != GL_NO_ERROR || status != GL_FRAMEBUFFER_COMPLETE) {
    throw OutputError(
        fmt::format("error: the OpenGL driver cannot draw {} x {} samples (status {:#x}); choose a "
                    "smaller picture with --size",
                    width, height, status));
  }
}

Framebuffer::~Framebuffer() {
  glDeleteFramebuffers(1, &framebuffer_);
  glDeleteTextures(1, &texture_);
  if (depth_ != 0) glDeleteRenderbuffers(1, &depth_);
}

void Framebuffer::drawInto(int width, int height) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, width, height);
}

void Framebuffer::bindTexture() const {
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture_);
}

void Framebuffer::read(const Eigen::AlignedBox2i& box, int rowPixels, std::uint8_t* pixels) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
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
