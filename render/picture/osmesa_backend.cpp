// A context of OSMesa (GL/osmesa.h), Mesa's own interface for drawing into memory. Attributes are
// pairs of a name and a value, ended by 0, as for OSMesaCreateContextAttribs.
#include <array>
#include <cstdint>

#include <GL/osmesa.h>

#include "render/picture/gl_context.h"

namespace kirireel::picture {
namespace {

class OsmesaBackend : public Backend {
 public:
  explicit OsmesaBackend(OSMesaContext context) : context_(context) {}
  ~OsmesaBackend() override { OSMesaDestroyContext(context_); }

  bool makeCurrent() override {
    if (OSMesaGetCurrentContext() == context_) return true;
    return OSMesaMakeCurrent(context_, unusedPixel_.data(), GL_UNSIGNED_BYTE, 1, 1) == GL_TRUE;
  }

  Function address(const char* name) const override { return OSMesaGetProcAddress(name); }

 private:
  OSMesaContext context_;
  // OSMesa requires a default framebuffer; all drawing goes to framebuffer objects instead.
  std::array<std::uint8_t, 4> unusedPixel_ = {};
};

}  // namespace

std::unique_ptr<Backend> makeOsmesaBackend() {
  const std::array<int, 9> attributes = {OSMESA_FORMAT,
                                         OSMESA_RGBA,
                                         OSMESA_PROFILE,
                                         OSMESA_CORE_PROFILE,
                                         OSMESA_CONTEXT_MAJOR_VERSION,
                                         3,
                                         OSMESA_CONTEXT_MINOR_VERSION,
                                         3,
                                         0};
  OSMesaContext context = OSMesaCreateContextAttribs(attributes.data(), nullptr);
  return context == nullptr ? nullptr : std::make_unique<OsmesaBackend>(context);
}

}  // namespace kirireel::picture
