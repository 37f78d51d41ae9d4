// OpenGL's functions, found by name: libraries are loaded when the first context is asked for, so
// that commands without OpenGL do not wait for them; nothing outside gl/ sees their headers.
#pragma once

#include <functional>
#include <vector>

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>

// Needs the types of the one above.
#include <GL/glext.h>

namespace seam::render::gl {

// clang-format off
#define SEAM_GL_FUNCTIONS(F) \
  F(glActiveTexture) F(glAttachShader) F(glBindAttribLocation) F(glBindBuffer) \
  F(glBindFramebuffer) F(glBindRenderbuffer) F(glBindTexture) F(glBindVertexArray) \
  F(glBlendFunc) F(glBufferData) F(glCheckFramebufferStatus) F(glClear) F(glClearColor) \
  F(glClearDepth) F(glCompileShader) F(glCreateProgram) F(glCreateShader) F(glDeleteShader) \
  F(glDepthFunc) F(glDisable) F(glDrawArraysInstanced) F(glEnable) F(glEnableVertexAttribArray) \
  F(glFlush) F(glFramebufferRenderbuffer) F(glFramebufferTexture2D) F(glFrontFace) \
  F(glGenBuffers) F(glGenFramebuffers) F(glGenRenderbuffers) F(glGenTextures) \
  F(glGenVertexArrays) F(glGenerateMipmap) F(glGetError) F(glGetIntegerv) F(glGetProgramInfoLog) \
  F(glGetProgramiv) F(glGetShaderInfoLog) F(glGetShaderiv) F(glGetString) \
  F(glGetUniformLocation) F(glLinkProgram) F(glMultiDrawElements) F(glPixelStorei) \
  F(glReadPixels) F(glRenderbufferStorage) F(glScissor) F(glShaderSource) F(glTexImage2D) \
  F(glTexParameteri) F(glUniform1f) F(glUniform1i) F(glUniform3f) F(glUniform4f) \
  F(glUniformMatrix3fv) F(glUseProgram) F(glVertexAttribDivisor) F(glVertexAttribPointer) \
  F(glViewport)
// clang-format on

struct Api {
#define SEAM_GL_MEMBER(name) decltype(&::name) name = nullptr;
  SEAM_GL_FUNCTIONS(SEAM_GL_MEMBER)
#undef SEAM_GL_MEMBER

  // A texture whose texels are taken as they are.
  GLuint make_texture() const;
  // Throws where the framebuffer that is bound, of this size, cannot be drawn into.
  void check_framebuffer(int width, int height) const;
  // What lies in the framebuffer that is bound: one float a texel (GL_RED) or four (GL_RGBA).
  void read(int width, int height, GLenum form, std::vector<float>& texels) const;

  // `find` gives a function by its name, `library` is what errors call it. Throws InputError where
  // one is missing.
  static Api of(const std::function<void*(const char*)>& find, const char* library);
};

}  // namespace seam::render::gl
