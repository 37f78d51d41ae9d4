#include "render/gl/api.h"

#include <dlfcn.h>

#include "sim_core/base/error.h"

namespace seam::render::gl {
namespace {

constexpr const char* kLibrary = "libOSMesa.so.8";

template <typename Function>
void find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  if (!function)
    throw InputError(fmt::format("{}: found no function {}, expected Mesa's OSMesa with OpenGL 3.3",
                                 kLibrary, name));
}

Api loaded() {
  // Stays open to the end: Mesa's own threads and tables outlive any context.
  void* const library = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    throw InputError(
        fmt::format("renderer 'opengl': {} cannot be loaded ({}); install Debian's libosmesa6, or "
                    "take --renderer analytic for scenes of shapes",
                    kLibrary, dlerror()));
  }
  Api api;
  find(library, "OSMesaCreateContextAttribs", api.create_context);
  find(library, "OSMesaMakeCurrent", api.make_current);
  find(library, "OSMesaDestroyContext", api.destroy_context);
#define SEAM_GL_FIND(name) find(library, #name, api.name);
  SEAM_GL_FUNCTIONS(SEAM_GL_FIND)
#undef SEAM_GL_FIND
  return api;
}

}  // namespace

const Api& Api::load() {
  static const Api api = loaded();
  return api;
}

}  // namespace seam::render::gl
