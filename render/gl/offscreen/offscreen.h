// Off-screen OpenGL: contexts that draw into framebuffers of their own, and where they come from.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/gl/offscreen/api.h"

namespace seam::render::gl {

class OffscreenContext {
 public:
  virtual ~OffscreenContext() = default;
  // For this thread; another context that was current is so no longer.
  virtual void make_current() = 0;
  // No context is current on this thread.
  virtual void release() = 0;
};

// Mesa's OSMesa, or EGL without a surface. Lives as long as the process: drivers have threads and
// tables that outlive any context.
class OffscreenGl {
 public:
  virtual ~OffscreenGl() = default;
  const Api& api() const { return api_; }
  // "osmesa" or "egl".
  const char* source() const { return source_; }
  // Of its driver, "VERSION, RENDERER".
  const std::string& driver() const { return driver_; }
  // Whether that is Mesa's renderer on the processor: what it draws should stay in the caches.
  bool on_processor() const { return driver_.find("llvmpipe") != std::string::npos; }
  // OpenGL 3.3, core profile. Throws InputError where there is none.
  virtual std::unique_ptr<OffscreenContext> make_context() const = 0;
  // Makes a first context and asks it for the driver. For offscreen_gl alone.
  void ask_driver();

 protected:
  OffscreenGl(const char* source, Api api) : source_(source), api_(api) {}

 private:
  const char* source_;
  Api api_;
  std::string driver_;
};

// "osmesa", "egl", or "auto": OSMesa, and EGL where that is not installed. Made once for the
// process. Throws InputError that says what to install.
const OffscreenGl& offscreen_gl(const std::string& source);

// It, and the other source where that is here and has a driver of the same version and renderer.
// Mesa fills triangles under a lock that each copy has for itself: two contexts of one copy wait
// for each other, contexts of two do not.
std::vector<const OffscreenGl*> copies_of(const OffscreenGl& gl);

// For offscreen_gl alone.
std::unique_ptr<OffscreenGl> load_osmesa();
std::unique_ptr<OffscreenGl> load_egl();

}  // namespace seam::render::gl
