#include "render/gl/context.h"

#include <algorithm>
#include <cstdlib>
#include <mutex>

#include <fmt/format.h>

#include "render/gl/backend.h"
#include "render/gl/opengl.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

struct KnownLibrary {
  GraphicsLibrary library;
  const char* name;     ///< as --gl has it
  const char* package;  ///< of Debian
  std::unique_ptr<Backend> (*makeBackend)();
};

/// In order of preference; which of them there are is chosen when the program is configured.
const std::vector<KnownLibrary>& libraries() {
  static const std::vector<KnownLibrary> known = {
#ifdef KIRIREEL_HAS_OSMESA
      {GraphicsLibrary::Osmesa, "osmesa", "libosmesa6", makeOsmesaBackend},
#endif
#ifdef KIRIREEL_HAS_EGL
      {GraphicsLibrary::Egl, "egl", "libegl-mesa0", makeEglBackend},
#endif
  };
  return known;
}

GraphicsLibrary chosenLibrary = libraries().front().library;

const KnownLibrary* find(GraphicsLibrary library) {
  const auto found = std::find_if(libraries().begin(), libraries().end(),
                                  [&](const KnownLibrary& k) { return k.library == library; });
  return found == libraries().end() ? nullptr : &*found;
}

/// Once for all contexts, which come from one library.
void loadFunctions(const Backend& backend) {
  static std::once_flag loaded;
  std::call_once(loaded, [&backend] {
#define KIRIREEL_LOAD(type, name) name = reinterpret_cast<type>(backend.address(#name));
    KIRIREEL_OPENGL_FUNCTIONS(KIRIREEL_LOAD)
#undef KIRIREEL_LOAD
  });
}

}  // namespace

std::vector<GraphicsLibrary> builtGraphicsLibraries() {
  std::vector<GraphicsLibrary> built;
  for (const KnownLibrary& known : libraries()) built.push_back(known.library);
  return built;
}

void setGraphicsLibrary(GraphicsLibrary library) {
  if (find(library) == nullptr) {
    throw InputError(fmt::format(
        "error: this kirireel was built without {}; choose --gl {}, or install the library's "
        "development package and build again",
        library == GraphicsLibrary::Egl ? "EGL" : "OSMesa", libraries().front().name));
  }
  chosenLibrary = library;
}

void setRasterThreads(int count) {
  ::setenv("LP_NUM_THREADS", fmt::format("{}", count).c_str(), /*overwrite=*/0);
}

Context::Context() {
  const KnownLibrary& library = *find(chosenLibrary);
  backend_ = library.makeBackend();
  if (backend_ == nullptr) {
    throw OutputError(
        fmt::format("error: cannot make an OpenGL 3.3 context off screen with {}; check that the "
                    "package {} is installed and that no MESA_ or GALLIUM_ variable is set in the "
                    "environment",
                    library.name, library.package));
  }
  makeCurrent();
  loadFunctions(*backend_);
}

Context::~Context() = default;

void Context::makeCurrent() {
  if (backend_->makeCurrent()) return;
  throw OutputError(
      "error: cannot use the OpenGL context that was made off screen; free some memory and try "
      "again");
}

std::string graphicsVersion() {
  return reinterpret_cast<const char*>(glGetString(GL_VERSION));
}

}  // namespace kirireel
