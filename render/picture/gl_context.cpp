// Two libraries can make a context without a window system: OSMesa (osmesa_backend.cpp) and EGL
// (egl_backend.cpp). Both provide OpenGL 3.3 core. Without a graphics card both draw with Mesa's
// llvmpipe on the processor, and the pictures are the same.
//
// Each library has its own addresses of the OpenGL functions. The first context loads them into the
// pointers of opengl.h. They are invalid in contexts of the other library, so a process uses only
// one library.
#include "render/picture/gl_context.h"

#include <algorithm>
#include <cstdlib>
#include <mutex>

#include <fmt/format.h>

#include "render/picture/opengl.h"
#include "sim/base/error.h"

namespace kirireel::picture {
namespace {

struct KnownLibrary {
  GraphicsLibrary library;
  const char* name;     ///< as for --gl
  const char* package;  ///< of Debian
  std::unique_ptr<Backend> (*makeBackend)();
};

/// The libraries that CMake found, the preferred one first.
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

/// Null if the program was built without this library.
const KnownLibrary* find(GraphicsLibrary library) {
  const auto found = std::find_if(libraries().begin(), libraries().end(),
                                  [&](const KnownLibrary& k) { return k.library == library; });
  return found == libraries().end() ? nullptr : &*found;
}

/// Loads the functions of OpenGL 3.3 at the first call. All contexts share them.
void loadFunctions(const Backend& backend) {
  static std::once_flag loaded;
  std::call_once(loaded, [&backend] {
#define KIRIREEL_LOAD(type, name) name = reinterpret_cast<type>(backend.address(#name));
    KIRIREEL_OPENGL_FUNCTIONS(KIRIREEL_LOAD)
#undef KIRIREEL_LOAD
  });
}

}  // namespace

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
  // llvmpipe reads the variable with its first context. A value of the user is kept.
  ::setenv("LP_NUM_THREADS", fmt::format("{}", count).c_str(), /*overwrite=*/0);
}

Context::Context() {
  // Never null, see setGraphicsLibrary().
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

// ------------------------------------------------------------------------------------------------
// A framebuffer object with two renderbuffers: colours as RGBA, 8 bits each, and depth as 32-bit
// floats. Renderbuffers, not textures, since nothing samples them. Depth has the finest format that
// OpenGL 3.3 offers.

namespace {

/// A new renderbuffer that is the framebuffer's colours or depth. `format` is GL_RGBA8 or a depth
/// format.
GLuint attach(GLenum format, GLenum attachment, int width, int height) {
  GLuint renderbuffer = 0;
  glGenRenderbuffers(1, &renderbuffer);
  glBindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
  glRenderbufferStorage(GL_RENDERBUFFER, format, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, renderbuffer);
  return renderbuffer;
}

}  // namespace

Framebuffer::Framebuffer(int width, int height) : sides_(width, height) {
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  colour_ = attach(GL_RGBA8, GL_COLOR_ATTACHMENT0, width, height);
  depth_ = attach(GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT, width, height);
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  // A driver that is short of memory reports an error or an incomplete framebuffer.
  if (glGetError() != GL_NO_ERROR || status != GL_FRAMEBUFFER_COMPLETE) {
    throw OutputError(
        fmt::format("error: the OpenGL driver cannot draw {} x {} samples (status {:#x}); choose a "
                    "smaller picture with --size",
                    width, height, status));
  }
}

Framebuffer::~Framebuffer() {
  glDeleteFramebuffers(1, &framebuffer_);
  glDeleteRenderbuffers(1, &colour_);
  glDeleteRenderbuffers(1, &depth_);
}

void Framebuffer::drawInto() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, sides_.x(), sides_.y());
}

void Framebuffer::read(const Eigen::AlignedBox2i& box, int rowPixels, std::uint8_t* pixels) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  // Rows of the destination may be longer than the box is wide: tiles of one picture are read into
  // their places.
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

// ------------------------------------------------------------------------------------------------
// A linked pair of shaders.

namespace {

constexpr GLsizei kLogLength = 1024;

OutputError shaderError(std::string log) {
  // The first line of the driver's log has the first mistake.
  log.erase(std::find(log.begin(), log.end(), '\n'), log.end());
  return OutputError(
      fmt::format("error: the OpenGL driver refuses a shader ({}); install Debian's libosmesa6, "
                  "version 22.3 or later",
                  log));
}

/// A compiled shader, deleted when the program has been linked.
class Shader {
 public:
  Shader(GLenum stage, const char* source) : handle_(glCreateShader(stage)) {
    glShaderSource(handle_, 1, &source, nullptr);
    glCompileShader(handle_);
  }
  ~Shader() { glDeleteShader(handle_); }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;

  GLuint handle() const { return handle_; }

  void requireCompiled() const {
    GLint compiled = GL_FALSE;
    glGetShaderiv(handle_, GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_TRUE) return;
    std::string log(kLogLength, '\0');
    GLsizei length = 0;
    glGetShaderInfoLog(handle_, kLogLength, &length, log.data());
    throw shaderError(log.substr(0, length));
  }

 private:
  GLuint handle_;
};

/// Deletes a program that cannot be linked: its constructor throws, so no destructor does.
void requireLinked(GLuint program) {
  GLint linked = GL_FALSE;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return;
  std::string log(kLogLength, '\0');
  GLsizei length = 0;
  glGetProgramInfoLog(program, kLogLength, &length, log.data());
  glDeleteProgram(program);
  throw shaderError(log.substr(0, length));
}

}  // namespace

Program::Program(const char* vertexSource, const char* fragmentSource) {
  // Shaders may be deleted once the program is linked; OpenGL keeps what it needs.
  const Shader vertex(GL_VERTEX_SHADER, vertexSource);
  const Shader fragment(GL_FRAGMENT_SHADER, fragmentSource);
  vertex.requireCompiled();
  fragment.requireCompiled();
  handle_ = glCreateProgram();
  glAttachShader(handle_, vertex.handle());
  glAttachShader(handle_, fragment.handle());
  glLinkProgram(handle_);
  requireLinked(handle_);
}

Program::~Program() {
  glDeleteProgram(handle_);
}

void Program::use() const {
  glUseProgram(handle_);
}

void Program::set(const char* name, float x, float y, float z, float w) const {
  glUniform4f(glGetUniformLocation(handle_, name), x, y, z, w);
}

}  // namespace kirireel::picture
