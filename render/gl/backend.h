/// A library that makes OpenGL contexts without a screen; each is known to one source alone.
#pragma once

#include <memory>

namespace kirireel {

/// One OpenGL 3.3 core context. Made, used and destroyed on one thread.
class Backend {
 public:
  using Function = void (*)();

  Backend() = default;
  virtual ~Backend() = default;
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;

  /// Directs the thread's OpenGL calls to this context. False when the library refuses.
  virtual bool makeCurrent() = 0;

  /// The address of an OpenGL function. Null where the library does not have it. OpenGL functions
  /// may be looked up once a context is current.
  virtual Function address(const char* name) const = 0;
};

/// The context of each library; null when the program was built without the library or the library
/// cannot make one. The context is not current yet.
std::unique_ptr<Backend> makeOsmesaBackend();
std::unique_ptr<Backend> makeEglBackend();

}  // namespace kirireel
