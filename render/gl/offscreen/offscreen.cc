#include "render/gl/offscreen/offscreen.h"

#include <cstdlib>
#include <map>
#include <mutex>
#include <optional>

#include "sim_core/base/error.h"

namespace seam::render::gl {
namespace {

// A variable of the environment while Mesa reads it; afterwards as it was, so that no process that
// we start inherits it.
class EnvironmentFor {
 public:
  EnvironmentFor(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    setenv(name, value, 1);
  }
  ~EnvironmentFor() {
    if (before_)
      setenv(name_, before_->c_str(), 1);
    else
      unsetenv(name_);
  }
  EnvironmentFor(const EnvironmentFor&) = delete;
  EnvironmentFor& operator=(const EnvironmentFor&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

// Mesa reads the environment once, when its first context is made: then, and before there are
// frames on other threads, it is set. Fused multiply-adds of newer processors would give other
// bits; frames are made side by side, so that threads of the rasteriser's own would only get into
// each other's way.
std::unique_ptr<OffscreenGl> load_alike(std::unique_ptr<OffscreenGl> load()) {
  const EnvironmentFor same_bits("GALLIUM_OVERRIDE_CPU_CAPS", "sse4.1");
  const EnvironmentFor one_thread("LP_NUM_THREADS", "0");
  const EnvironmentFor software("GALLIUM_DRIVER", "llvmpipe");
  // Missing drivers are named by our own errors, where they matter.
  const EnvironmentFor quiet("EGL_LOG_LEVEL", "fatal");
  std::unique_ptr<OffscreenGl> made = load();
  made->ask_driver();
  return made;
}

// Throws what loading throws; a later call tries again.
template <std::unique_ptr<OffscreenGl> load()>
const OffscreenGl& only() {
  static const std::unique_ptr<OffscreenGl> made = load_alike(load);
  return *made;
}

}  // namespace

void OffscreenGl::ask_driver() {
  const std::unique_ptr<OffscreenContext> context = make_context();
  context->make_current();
  const auto text = [&](GLenum name) {
    return reinterpret_cast<const char*>(api_.glGetString(name));
  };
  driver_ = fmt::format("{}, {}", text(GL_VERSION), text(GL_RENDERER));
  context->release();
}

std::vector<const OffscreenGl*> copies_of(const OffscreenGl& gl) {
  std::vector<const OffscreenGl*> copies{&gl};
  try {
    const bool is_egl = std::string_view(gl.source()) == "egl";
    const OffscreenGl& other = offscreen_gl(is_egl ? "osmesa" : "egl");
    if (other.driver() == gl.driver()) copies.push_back(&other);
  } catch (const InputError&) {
    // One copy then; nothing was asked of the other.
  }
  return copies;
}

const OffscreenGl& offscreen_gl(const std::string& source) {
  if (source == "osmesa") return only<load_osmesa>();
  if (source == "egl") return only<load_egl>();
  try {
    return only<load_osmesa>();
  } catch (const InputError& osmesa) {
    try {
      return only<load_egl>();
    } catch (const InputError& egl) {
      throw InputError(
          fmt::format("renderer 'opengl': {}; {}; or take --renderer analytic for scenes of shapes",
                      osmesa.what(), egl.what()));
    }
  }
}

}  // namespace seam::render::gl
