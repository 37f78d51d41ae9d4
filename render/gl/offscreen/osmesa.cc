#include <GL/osmesa.h>
#include <dlfcn.h>

#include <array>

#include "render/gl/offscreen/offscreen.h"
#include "sim_core/base/error.h"

namespace seam::render::gl {
namespace {

constexpr const char* kOsMesaLibrary = "libOSMesa.so.8";

struct OsMesaFunctions {
  decltype(&::OSMesaCreateContextAttribs) create = nullptr;
  decltype(&::OSMesaMakeCurrent) make_current = nullptr;
  decltype(&::OSMesaDestroyContext) destroy = nullptr;
};

class OsMesaContext final : public OffscreenContext {
 public:
  OsMesaContext(const OsMesaFunctions& mesa, OSMesaContext context)
      : mesa_(mesa), context_(context) {}
  ~OsMesaContext() override { mesa_.destroy(context_); }
  void make_current() override {
    SEAM_CHECK(mesa_.make_current(context_, window_.data(), GL_UNSIGNED_BYTE, kSide, kSide), "{}",
               "OSMesaMakeCurrent");
  }
  void release() override { mesa_.make_current(nullptr, nullptr, 0, 0, 0); }

 private:
  static constexpr int kSide = 64;
  const OsMesaFunctions& mesa_;
  OSMesaContext context_;
  std::array<uint8_t, size_t{kSide} * kSide * 4>
      window_{};  // It wants one; nothing is drawn there.
};

class OsMesa final : public OffscreenGl {
 public:
  OsMesa(const OsMesaFunctions& mesa, Api api) : OffscreenGl("osmesa", api), mesa_(mesa) {}

  std::unique_ptr<OffscreenContext> make_context() const override {
    constexpr int kAttributes[] = {OSMESA_FORMAT,
                                   OSMESA_RGBA,
                                   OSMESA_DEPTH_BITS,
                                   24,
                                   OSMESA_PROFILE,
                                   OSMESA_CORE_PROFILE,
                                   OSMESA_CONTEXT_MAJOR_VERSION,
                                   3,
                                   OSMESA_CONTEXT_MINOR_VERSION,
                                   3,
                                   0};
    OSMesaContext context = mesa_.create(kAttributes, nullptr);
    if (!context)
      throw InputError(
          fmt::format("{}: makes no off-screen OpenGL 3.3 core context here", kOsMesaLibrary));
    return std::make_unique<OsMesaContext>(mesa_, context);
  }

 private:
  const OsMesaFunctions mesa_;
};

}  // namespace

std::unique_ptr<OffscreenGl> load_osmesa() {
  void* const library = dlopen(kOsMesaLibrary, RTLD_NOW | RTLD_LOCAL);
  if (!library)
    throw InputError(
        fmt::format("--gl osmesa: {} cannot be loaded ({}); install Debian's "
                    "libosmesa6, or take --gl egl",
                    kOsMesaLibrary, dlerror()));
  const auto find = [&](const char* name) { return dlsym(library, name); };
  OsMesaFunctions mesa;
  const auto take = [&](const char* name, auto& function) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(find(name));
    if (!function) throw InputError(fmt::format("{}: found no function {}", kOsMesaLibrary, name));
  };
  take("OSMesaCreateContextAttribs", mesa.create);
  take("OSMesaMakeCurrent", mesa.make_current);
  take("OSMesaDestroyContext", mesa.destroy);
  return std::make_unique<OsMesa>(mesa, Api::of(find, kOsMesaLibrary));
}

}  // namespace seam::render::gl
