// A context on Mesa's surfaceless platform (extensions EGL_MESA_platform_surfaceless,
// EGL_KHR_no_config_context and EGL_KHR_surfaceless_context of the Khronos EGL registry): no
// window, no pixel buffer, no configuration. What is painted goes to framebuffer objects.
#include <array>

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "render/picture/gl_context.h"

namespace kirireel::picture {
namespace {

/// Mesa's display without a screen, shared by all contexts and never closed: closing it would end
/// contexts of other threads.
EGLDisplay surfacelessDisplay() {
  static const EGLDisplay display = [] {
    const EGLDisplay found =
        eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    const bool ready =
        found != EGL_NO_DISPLAY && eglInitialize(found, nullptr, nullptr) == EGL_TRUE;
    return ready ? found : EGL_NO_DISPLAY;
  }();
  return display;
}

class EglBackend : public Backend {
 public:
  EglBackend(EGLDisplay display, EGLContext context) : display_(display), context_(context) {}

  ~EglBackend() override {
    // A context that is current would only be marked for deletion.
    if (eglGetCurrentContext() == context_) {
      eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    }
    eglDestroyContext(display_, context_);
  }

  bool makeCurrent() override {
    // The bound API (OpenGL or OpenGL ES) is a state of each thread.
    if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) return false;
    if (eglGetCurrentContext() == context_) return true;
    return eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
  }

  Function address(const char* name) const override { return eglGetProcAddress(name); }

 private:
  EGLDisplay display_;
  EGLContext context_;
};

}  // namespace

std::unique_ptr<Backend> makeEglBackend() {
  const EGLDisplay display = surfacelessDisplay();
  if (display == EGL_NO_DISPLAY || eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) return nullptr;
  const std::array<EGLint, 7> attributes = {EGL_CONTEXT_MAJOR_VERSION,
                                            3,
                                            EGL_CONTEXT_MINOR_VERSION,
                                            3,
                                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                            EGL_NONE};
  // All drawing goes to framebuffer objects: no configuration of a surface is needed.
  EGLContext context =
      eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
  if (context == EGL_NO_CONTEXT) return nullptr;
  return std::make_unique<EglBackend>(display, context);
}

}  // namespace kirireel::picture
