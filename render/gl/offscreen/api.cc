#include "render/gl/offscreen/api.h"

#include "sim_core/base/error.h"

namespace seam::render::gl {

Api Api::of(const std::function<void*(const char*)>& find, const char* library) {
  Api api;
#define SEAM_GL_FIND(name)                                      \
  api.name = reinterpret_cast<decltype(api.name)>(find(#name)); \
  if (!api.name)                                                \
    throw InputError(                                           \
        fmt::format("{}: found no function {}, expected one of OpenGL 3.3", library, #name));
  SEAM_GL_FUNCTIONS(SEAM_GL_FIND)
#undef SEAM_GL_FIND
  return api;
}

GLuint Api::make_texture() const {
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

void Api::check_framebuffer(int width, int height) const {
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  SEAM_CHECK(status == GL_FRAMEBUFFER_COMPLETE, "framebuffer of {}x{}: {}", width, height, status);
}

void Api::read(int width, int height, GLenum form, std::vector<float>& texels) const {
  texels.resize(static_cast<size_t>(form == GL_RED ? 1 : 4) * width * height);
  glReadPixels(0, 0, width, height, form, GL_FLOAT, texels.data());
  const GLenum error = glGetError();
  SEAM_CHECK(error == GL_NO_ERROR, "OpenGL error {}", error);
}

}  // namespace seam::render::gl
