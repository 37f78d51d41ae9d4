// The OpenGL renderer: light of a frame's instants drawn off-screen, beside the ray caster of
// cast/. It draws what the ray caster does and, beyond that, meshes and textures.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/assets/assets.h"
#include "render/base/linear_image.h"
#include "render/base/renderer_options.h"
#include "render/cast/ray_table.h"
#include "sim_core/scene/frame.h"

namespace seam::render {

// Where a pixel's samples are looked up and summed: on the processor, in shaders, or in shaders
// where the driver is a graphics processor's. Fisheyes' and huge images' always on the processor.
enum class Gathering { by_driver, on_processor, in_shaders };

class GlDevice {
 public:
  // `source`: "osmesa", Mesa's software renderer; "egl", the first driver that EGL finds, that of a
  // graphics processor where there is one; "auto": osmesa, and egl where that is not installed.
  // Throws InputError where this build or this machine has no OpenGL.
  explicit GlDevice(Assets assets = {}, const std::string& source = "auto",
                    Gathering gathering = Gathering::by_driver);
  ~GlDevice();
  GlDevice(const GlDevice&) = delete;
  GlDevice& operator=(const GlDevice&) = delete;

  // "osmesa" or "egl".
  std::string source() const;
  // Of the driver, as logs name them.
  const std::string& version() const;
  const std::string& renderer() const;

  const Assets& assets() const;

  // As integrate_light of the ray caster; may be called from several threads at once.
  void integrate_light(const FrameJob& job, const CameraRays& rays, const RendererOptions& options,
                       LinearImage& image) const;

  // What the ray through each pixel's centre meets at the one instant that its row has in this job:
  // its place in the instant's primitives (-1: nothing), and the multiple of the ray.
  struct Centres {
    std::vector<int32_t> source;
    std::vector<float> depth;
  };
  Centres see_centres(const FrameJob& job, const CameraRays& rays) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Whether "osmesa" or "egl" makes contexts here.
bool opengl_is_here(const std::string& source);

}  // namespace seam::render
