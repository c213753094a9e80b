#include "render/gl/program.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "render/gl/opengl.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

constexpr GLsizei kLogLength = 1024;

OutputError shaderError(std::string log) {
  // The first line of the driver's log tells the first mistake.
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

/// Deletes a program that failed, for the constructor's caller gets no object to do so.
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

}  // namespace kirireel
