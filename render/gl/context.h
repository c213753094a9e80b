/// An OpenGL 3.3 core context that needs no screen.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace kirireel {

/// The libraries that contexts come from. Both run the same software renderer on a machine without
/// a graphics card.
enum class GraphicsLibrary {
  Osmesa,  ///< Mesa's own; gone from Mesa 25.1 on
  Egl,     ///< EGL on Mesa's surfaceless platform; may use a graphics card where there is one
};

/// The libraries that the program was built with, at least one; the first is used unless told
/// otherwise.
std::vector<GraphicsLibrary> builtGraphicsLibraries();

/// Chooses the library of all contexts made later. One process uses one library: call it before the
/// first context is made. Throws InputError when the program was built without it.
void setGraphicsLibrary(GraphicsLibrary library);

/// Sets how many extra threads the software renderer uses, for contexts made later; 0 draws on the
/// calling thread, one context at a time. Changes the
/// environment of the process: call it before other threads start. A value that the user has set
/// (LP_NUM_THREADS) stays.
void setRasterThreads(int count);

class Backend;

/// The graphics context of one thread. Every use must be on the thread that made it. Making one
/// costs time and memory, so that callers keep theirs.
class Context {
 public:
  /// Makes the context and makes it current. Throws OutputError when the system offers none.
  Context();
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  /// Directs the thread's OpenGL calls to this context. Throws OutputError when the library
  /// refuses.
  void makeCurrent();

 private:
  std::unique_ptr<Backend> backend_;
};

/// OpenGL's version and its maker's, of the context that is current on this thread. For example
/// "4.5 (Core Profile) Mesa 22.3.6".
std::string graphicsVersion();

}  // namespace kirireel
