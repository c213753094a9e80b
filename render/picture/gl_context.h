/// OpenGL without a screen: contexts, framebuffers and shaders.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace kirireel::picture {

// ------------------------------------------------------------------------------------------------
// An OpenGL 3.3 core context that needs no screen.

/// The libraries of contexts. Without a graphics card both use the same software renderer.
enum class GraphicsLibrary {
  Osmesa,  ///< Mesa's own; removed in Mesa 25.1
  Egl,     ///< EGL on Mesa's surfaceless platform; may use a graphics card
};

/// Selects the library of all contexts made later. A process uses one library: call it before the
/// first context. Throws InputError if the program was built without the library.
void setGraphicsLibrary(GraphicsLibrary library);

/// Sets how many extra threads the software renderer uses, for contexts made later; 0 draws on the
/// calling thread, one context at a time. Changes the environment of the process: call it before
/// other threads start. A value that the user has set (LP_NUM_THREADS) stays.
void setRasterThreads(int count);

class Backend;

/// The graphics context of one thread. Every use must be on the thread that made it. Making one
/// costs time and memory: callers should keep theirs.
class Context {
 public:
  /// Makes the context and makes it current. Throws OutputError if the system has none.
  Context();
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  /// Directs the thread's OpenGL calls to this context. Throws OutputError if the library refuses
  /// it.
  void makeCurrent();

 private:
  std::unique_ptr<Backend> backend_;
};

/// OpenGL's version and vendor in the thread's current context, for example "4.5 (Core Profile)
/// Mesa 22.3.6".
std::string graphicsVersion();

// ------------------------------------------------------------------------------------------------
// Interface to a library that makes OpenGL contexts without a screen.

/// One OpenGL 3.3 core context. Made, used and destroyed on one thread.
class Backend {
 public:
  /// A function of OpenGL, to be cast to its own type.
  using Function = void (*)();

  Backend() = default;
  virtual ~Backend() = default;
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;

  /// Directs the thread's OpenGL calls to this context. False if the library refuses it.
  virtual bool makeCurrent() = 0;

  /// The address of an OpenGL function. Null if the library does not have it. Requires a current
  /// context.
  virtual Function address(const char* name) const = 0;
};

/// The context of each library; null if the program was built without the library or the library
/// cannot make one. The context is not current yet.
std::unique_ptr<Backend> makeOsmesaBackend();
/// The same for EGL, which needs no screen.
std::unique_ptr<Backend> makeEglBackend();

// ------------------------------------------------------------------------------------------------
// A picture in the graphics context as a drawing target.

/// A framebuffer object with RGBA8 colours and depth. Belongs to the context that is current when
/// it is made.
class Framebuffer {
 public:
  /// `width` and `height`: pixels, >= 1. Throws OutputError if the driver refuses the size or has
  /// too little memory.
  Framebuffer(int width, int height);
  ~Framebuffer();
  Framebuffer(const Framebuffer&) = delete;
  Framebuffer& operator=(const Framebuffer&) = delete;

  /// Width and height, pixels.
  const Eigen::Vector2i& sides() const { return sides_; }

  /// Directs draws to this framebuffer from now on.
  void drawInto() const;

  /// Copies a box of pixels as RGBA, the lowest row first, as in OpenGL. The box excludes its
  /// maximum column and row. Waits for all drawing to end. `rowPixels`: pixels from the start of a
  /// row of `pixels` to the next. `pixels` holds 4 bytes per pixel, up to the end of the last row.
  /// Throws OutputError if the driver has run out of memory.
  void read(const Eigen::AlignedBox2i& box, int rowPixels, std::uint8_t* pixels) const;

 private:
  Eigen::Vector2i sides_;
  unsigned int framebuffer_ = 0;
  unsigned int colour_ = 0;
  unsigned int depth_ = 0;
};

// ------------------------------------------------------------------------------------------------
// A linked pair of shaders.

/// A vertex and a fragment shader in GLSL 3.30, linked. Belongs to the context that is current when
/// it is made.
class Program {
 public:
  /// Throws OutputError with the compiler's message if the sources do not compile or link.
  Program(const char* vertexSource, const char* fragmentSource);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Makes this program current until another one is used.
  void use() const;

  /// Sets a uniform of the program in use. `name` as in the shader's source; a name that no shader
  /// uses is ignored. Floats, as in GLSL's vec4.
  void set(const char* name, float x, float y, float z, float w) const;

 private:
  unsigned int handle_ = 0;
};

}  // namespace kirireel::picture
