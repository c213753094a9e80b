/// An OpenGL 3.3 core context that needs no screen.
#pragma once

#include <memory>
#include <string>

namespace kirireel {

/// Sets how many extra threads the software renderer uses, for contexts made later; 0 draws on the
/// calling thread, the efficient choice while other threads simulate and encode. Changes the
/// environment of the process: call it before other threads start. A value that the user has set
/// (LP_NUM_THREADS) stays.
void setRasterThreads(int count);

/// The graphics context of one thread. Every use must be on the thread that made it.
class Context {
 public:
  /// Makes the context and makes it current. Throws OutputError when the system offers none.
  Context();
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  /// Directs the thread's OpenGL calls to this context.
  void makeCurrent();

 private:
  struct Handle;
  std::unique_ptr<Handle> handle_;
};

/// OpenGL's version and its maker's, of the context that is current on this thread.
std::string graphicsVersion();

}  // namespace kirireel
