// Two libraries can make a context without a window system, and each is in one source file of its
// own: OSMesa (osmesa_backend.cpp) and EGL (egl_backend.cpp). Both give OpenGL 3.3 core; on a
// machine without a graphics card both draw by Mesa's llvmpipe on the processor, so that pictures
// are the same.
//
// OpenGL functions have no fixed address: each library hands out its own. They are loaded once for
// the process into the pointers of opengl.h. That is why one process uses one library: pointers of
// one must not meet contexts of the other.
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
  // At least one of the two is built; CMake ends with an error otherwise.
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

/// Null where the program was built without it.
const KnownLibrary* find(GraphicsLibrary library) {
  const auto found = std::find_if(libraries().begin(), libraries().end(),
                                  [&](const KnownLibrary& k) { return k.library == library; });
  return found == libraries().end() ? nullptr : &*found;
}

/// Once for all contexts, which come from one library. A function that the library lacks stays
/// null; OpenGL 3.3 has all that are named.
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
  // llvmpipe reads it when it makes its screen; 0 as the last argument keeps what the user has set.
  ::setenv("LP_NUM_THREADS", fmt::format("{}", count).c_str(), /*overwrite=*/0);
}

Context::Context() {
  // Never null: only libraries that were built can be chosen.
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
