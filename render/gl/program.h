/// A linked pair of shaders.
#pragma once

namespace kirireel {

/// A vertex and a fragment shader in GLSL 3.30, linked. Belongs to the context current when made.
class Program {
 public:
  /// Throws OutputError with the compiler's words when the sources do not compile or link.
  Program(const char* vertexSource, const char* fragmentSource);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Makes the program the one that draws. Until another program is.
  void use() const;

  /// Sets a uniform of the program in use. `name` as in the shader's source; a name that no shader
  /// uses is ignored. Floats, as in GLSL's vec4.
  void set(const char* name, float x, float y, float z, float w) const;

 private:
  unsigned int handle_ = 0;
};

}  // namespace kirireel
