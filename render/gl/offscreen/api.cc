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

}  // namespace seam::render::gl
