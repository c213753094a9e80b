/// The OpenGL functions in use; included only by sources. They are loaded when a context is made,
/// because the libraries that make contexts do not share them.
///
/// One list names every function with its type. The macro is given another macro, which declares a
/// pointer here and loads it in gl_context.cpp: a function is added in one place.
#pragma once

#include <GL/glcorearb.h>

namespace kirireel::picture {

/// Every function that the program and its benchmarks call: its type and its name.
#define KIRIREEL_OPENGL_FUNCTIONS(FUNCTION)                             \
  FUNCTION(PFNGLATTACHSHADERPROC, glAttachShader)                       \
  FUNCTION(PFNGLBINDBUFFERPROC, glBindBuffer)                           \
  FUNCTION(PFNGLBINDFRAMEBUFFERPROC, glBindFramebuffer)                 \
  FUNCTION(PFNGLBINDRENDERBUFFERPROC, glBindRenderbuffer)               \
  FUNCTION(PFNGLBINDTEXTUREPROC, glBindTexture)                         \
  FUNCTION(PFNGLBINDVERTEXARRAYPROC, glBindVertexArray)                 \
  FUNCTION(PFNGLBLENDFUNCPROC, glBlendFunc)                             \
  FUNCTION(PFNGLBUFFERDATAPROC, glBufferData)                           \
  FUNCTION(PFNGLCHECKFRAMEBUFFERSTATUSPROC, glCheckFramebufferStatus)   \
  FUNCTION(PFNGLCLEARPROC, glClear)                                     \
  FUNCTION(PFNGLCLEARCOLORPROC, glClearColor)                           \
  FUNCTION(PFNGLCOMPILESHADERPROC, glCompileShader)                     \
  FUNCTION(PFNGLCREATEPROGRAMPROC, glCreateProgram)                     \
  FUNCTION(PFNGLCREATESHADERPROC, glCreateShader)                       \
  FUNCTION(PFNGLDELETEBUFFERSPROC, glDeleteBuffers)                     \
  FUNCTION(PFNGLDELETEFRAMEBUFFERSPROC, glDeleteFramebuffers)           \
  FUNCTION(PFNGLDELETEPROGRAMPROC, glDeleteProgram)                     \
  FUNCTION(PFNGLDELETERENDERBUFFERSPROC, glDeleteRenderbuffers)         \
  FUNCTION(PFNGLDELETESHADERPROC, glDeleteShader)                       \
  FUNCTION(PFNGLDELETEVERTEXARRAYSPROC, glDeleteVertexArrays)           \
  FUNCTION(PFNGLDEPTHFUNCPROC, glDepthFunc)                             \
  FUNCTION(PFNGLDEPTHMASKPROC, glDepthMask)                             \
  FUNCTION(PFNGLDISABLEPROC, glDisable)                                 \
  FUNCTION(PFNGLDRAWARRAYSPROC, glDrawArrays)                           \
  FUNCTION(PFNGLDRAWELEMENTSPROC, glDrawElements)                       \
  FUNCTION(PFNGLENABLEPROC, glEnable)                                   \
  FUNCTION(PFNGLENABLEVERTEXATTRIBARRAYPROC, glEnableVertexAttribArray) \
  FUNCTION(PFNGLFINISHPROC, glFinish)                                   \
  FUNCTION(PFNGLFRAMEBUFFERRENDERBUFFERPROC, glFramebufferRenderbuffer) \
  FUNCTION(PFNGLFRAMEBUFFERTEXTURE2DPROC, glFramebufferTexture2D)       \
  FUNCTION(PFNGLGENBUFFERSPROC, glGenBuffers)                           \
  FUNCTION(PFNGLGENFRAMEBUFFERSPROC, glGenFramebuffers)                 \
  FUNCTION(PFNGLGENRENDERBUFFERSPROC, glGenRenderbuffers)               \
  FUNCTION(PFNGLGENTEXTURESPROC, glGenTextures)                         \
  FUNCTION(PFNGLGENVERTEXARRAYSPROC, glGenVertexArrays)                 \
  FUNCTION(PFNGLGETERRORPROC, glGetError)                               \
  FUNCTION(PFNGLGETPROGRAMINFOLOGPROC, glGetProgramInfoLog)             \
  FUNCTION(PFNGLGETPROGRAMIVPROC, glGetProgramiv)                       \
  FUNCTION(PFNGLGETSHADERINFOLOGPROC, glGetShaderInfoLog)               \
  FUNCTION(PFNGLGETSHADERIVPROC, glGetShaderiv)                         \
  FUNCTION(PFNGLGETSTRINGPROC, glGetString)                             \
  FUNCTION(PFNGLGETUNIFORMLOCATIONPROC, glGetUniformLocation)           \
  FUNCTION(PFNGLLINKPROGRAMPROC, glLinkProgram)                         \
  FUNCTION(PFNGLPIXELSTOREIPROC, glPixelStorei)                         \
  FUNCTION(PFNGLREADPIXELSPROC, glReadPixels)                           \
  FUNCTION(PFNGLRENDERBUFFERSTORAGEPROC, glRenderbufferStorage)         \
  FUNCTION(PFNGLSCISSORPROC, glScissor)                                 \
  FUNCTION(PFNGLSHADERSOURCEPROC, glShaderSource)                       \
  FUNCTION(PFNGLTEXIMAGE2DPROC, glTexImage2D)                           \
  FUNCTION(PFNGLTEXPARAMETERIPROC, glTexParameteri)                     \
  FUNCTION(PFNGLUNIFORM4FPROC, glUniform4f)                             \
  FUNCTION(PFNGLUSEPROGRAMPROC, glUseProgram)                           \
  FUNCTION(PFNGLVERTEXATTRIBPOINTERPROC, glVertexAttribPointer)         \
  FUNCTION(PFNGLVIEWPORTPROC, glViewport)

#define KIRIREEL_DECLARE(type, name) inline type name = nullptr;
KIRIREEL_OPENGL_FUNCTIONS(KIRIREEL_DECLARE)
#undef KIRIREEL_DECLARE

}  // namespace kirireel::picture
