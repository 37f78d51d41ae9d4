#include "render/gl/offscreen/offscreen.h"
#include "sim_core/base/error.h"

#if __has_include(<EGL/eglext.h>)

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <array>
#include <string_view>

namespace seam::render::gl {
namespace {

constexpr const char* kEglLibrary = "libEGL.so.1";

// clang-format off
#define SEAM_EGL_FUNCTIONS(F) \
  F(eglBindAPI) F(eglCreateContext) F(eglDestroyContext) F(eglGetPlatformDisplay) \
  F(eglGetProcAddress) F(eglInitialize) F(eglMakeCurrent) F(eglQueryString) F(eglTerminate)
// clang-format on

struct EglFunctions {
#define SEAM_EGL_MEMBER(name) decltype(&::name) name = nullptr;
  SEAM_EGL_FUNCTIONS(SEAM_EGL_MEMBER)
#undef SEAM_EGL_MEMBER
  PFNEGLQUERYDEVICESEXTPROC query_devices = nullptr;  // Null where EGL knows of none.
};

bool has(const char* extensions, std::string_view name) {
  return extensions != nullptr &&
         (" " + std::string(extensions) + " ").find(" " + std::string(name) + " ") !=
             std::string::npos;
}

class EglContext final : public OffscreenContext {
 public:
  EglContext(const EglFunctions& egl, EGLDisplay display, EGLContext context)
      : egl_(egl), display_(display), context_(context) {}
  ~EglContext() override { egl_.eglDestroyContext(display_, context_); }
  void make_current() override { take(context_); }
  void release() override { take(EGL_NO_CONTEXT); }

 private:
  void take(EGLContext context) {
    egl_.eglBindAPI(EGL_OPENGL_API);  // Each thread begins with OpenGL ES.
    SEAM_CHECK(egl_.eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context), "{}",
               "eglMakeCurrent");
  }
  const EglFunctions& egl_;
  EGLDisplay display_;
  EGLContext context_;
};

EGLContext create_context(const EglFunctions& egl, EGLDisplay display) {
  constexpr EGLint kAttributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                    3,
                                    EGL_CONTEXT_MINOR_VERSION,
                                    3,
                                    EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                    EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                    EGL_NONE};
  if (!egl.eglBindAPI(EGL_OPENGL_API)) return EGL_NO_CONTEXT;
  return egl.eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, kAttributes);
}

// A display that makes such contexts without a surface; null else.
EGLDisplay opened(const EglFunctions& egl, EGLenum platform, void* native) {
  const EGLDisplay display = egl.eglGetPlatformDisplay(platform, native, nullptr);
  if (display == EGL_NO_DISPLAY || !egl.eglInitialize(display, nullptr, nullptr))
    return EGL_NO_DISPLAY;
  const char* const extensions = egl.eglQueryString(display, EGL_EXTENSIONS);
  if (has(extensions, "EGL_KHR_surfaceless_context") &&
      has(extensions, "EGL_KHR_no_config_context")) {
    if (const EGLContext context = create_context(egl, display); context != EGL_NO_CONTEXT) {
      egl.eglDestroyContext(display, context);
      return display;
    }
  }
  egl.eglTerminate(display);
  return EGL_NO_DISPLAY;
}

// The first device that can: drivers name their graphics processors before Mesa's software one.
EGLDisplay find_display(const EglFunctions& egl) {
  if (egl.query_devices) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (!egl.query_devices(devices.size(), devices.data(), &count)) count = 0;
    for (EGLint i = 0; i < count; ++i)
      if (const EGLDisplay display = opened(egl, EGL_PLATFORM_DEVICE_EXT, devices[i]))
        return display;
  }
  return opened(egl, EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY);
}

class Egl final : public OffscreenGl {
 public:
  Egl(const EglFunctions& egl, EGLDisplay display, Api api)
      : OffscreenGl("egl", api), egl_(egl), display_(display) {}

  std::unique_ptr<OffscreenContext> make_context() const override {
    const EGLContext context = create_context(egl_, display_);
    if (context == EGL_NO_CONTEXT)
      throw InputError(fmt::format("{}: makes no further OpenGL 3.3 core context", kEglLibrary));
    return std::make_unique<EglContext>(egl_, display_, context);
  }

 private:
  const EglFunctions egl_;
  const EGLDisplay display_;
};

}  // namespace

std::unique_ptr<OffscreenGl> load_egl() {
  void* const library = dlopen(kEglLibrary, RTLD_NOW | RTLD_LOCAL);
  if (!library)
    throw InputError(fmt::format("--gl egl: {} cannot be loaded ({}); install Debian's libegl1",
                                 kEglLibrary, dlerror()));
  EglFunctions egl;
#define SEAM_EGL_FIND(name)                                               \
  egl.name = reinterpret_cast<decltype(egl.name)>(dlsym(library, #name)); \
  if (!egl.name)                                                          \
    throw InputError(fmt::format("{}: found no function {}, expected EGL 1.5", kEglLibrary, #name));
  SEAM_EGL_FUNCTIONS(SEAM_EGL_FIND)
#undef SEAM_EGL_FIND
  if (has(egl.eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), "EGL_EXT_platform_device"))
    egl.query_devices =
        reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(egl.eglGetProcAddress("eglQueryDevicesEXT"));
  const EGLDisplay display = find_display(egl);
  if (display == EGL_NO_DISPLAY)
    throw InputError(fmt::format(
        "--gl egl: {}: no device or driver here makes an OpenGL 3.3 core context without a "
        "surface; install a driver, such as Debian's libegl-mesa0 and libgl1-mesa-dri",
        kEglLibrary));
  const auto find = [&](const char* name) {
    return reinterpret_cast<void*>(egl.eglGetProcAddress(name));
  };
  return std::make_unique<Egl>(egl, display, Api::of(find, kEglLibrary));
}

}  // namespace seam::render::gl

#else

namespace seam::render::gl {

std::unique_ptr<OffscreenGl> load_egl() {
  throw InputError("--gl egl: this build has none; install libegl-dev and build again");
}

}  // namespace seam::render::gl

#endif
