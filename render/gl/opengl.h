/// The OpenGL functions that the library exports; included by sources only.
#pragma once

#define GL_GLEXT_PROTOTYPES 1
#include <GL/glcorearb.h>
