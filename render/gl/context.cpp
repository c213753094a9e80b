#include "render/gl/context.h"

#include <array>
#include <cstdint>
#include <cstdlib>

#include <GL/osmesa.h>
#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {

struct Context::Handle {
  OSMesaContext context = nullptr;
  // OSMesa wants a default framebuffer; all drawing goes to framebuffer objects instead.
  std::array<std::uint8_t, 4> unusedPixel = {};

  ~Handle() {
    if (context != nullptr) OSMesaDestroyContext(context);
  }
};

void setRasterThreads(int count) {
  ::setenv("LP_NUM_THREADS", fmt::format("{}", count).c_str(), /*overwrite=*/0);
}

Context::Context() : handle_(std::make_unique<Handle>()) {
  const std::array<int, 9> attributes = {OSMESA_FORMAT,
                                         OSMESA_RGBA,
                                         OSMESA_PROFILE,
                                         OSMESA_CORE_PROFILE,
                                         OSMESA_CONTEXT_MAJOR_VERSION,
                                         3,
                                         OSMESA_CONTEXT_MINOR_VERSION,
                                         3,
                                         0};
  handle_->context = OSMesaCreateContextAttribs(attributes.data(), nullptr);
  if (handle_->context == nullptr) {
    throw OutputError(
        "error: cannot make an OpenGL 3.3 context off screen; check that the package libosmesa6 is "
        "installed and that no MESA_ or GALLIUM_ variable is set in the environment");
  }
  makeCurrent();
}

Context::~Context() = default;

void Context::makeCurrent() {
  if (OSMesaGetCurrentContext() == handle_->context) return;
  if (OSMesaMakeCurrent(handle_->context, handle_->unusedPixel.data(), GL_UNSIGNED_BYTE, 1, 1) !=
      GL_TRUE) {
    throw OutputError(
        "error: cannot use the OpenGL context that was made off screen; free some memory and try "
        "again");
  }
}

std::string graphicsVersion() {
  return reinterpret_cast<const char*>(glGetString(GL_VERSION));
}

}  // namespace kirireel
