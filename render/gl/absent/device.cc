// In place of the OpenGL renderer where the build left it out.
#include "render/gl/device.h"

#include "sim_core/base/error.h"

namespace seam::render {

namespace {
constexpr const char* kMissing =
    "renderer 'opengl': this build has none; install libosmesa6-dev and libassimp-dev and build "
    "with -DSEAM_OPENGL=ON, or take --renderer analytic for scenes of shapes";
}  // namespace

struct GlDevice::Impl {
  std::string nothing;
};

GlDevice::GlDevice(Assets) {
  throw InputError(kMissing);
}
GlDevice::~GlDevice() = default;
const std::string& GlDevice::version() const {
  return impl_->nothing;
}
const std::string& GlDevice::renderer() const {
  return impl_->nothing;
}
void GlDevice::integrate_light(const FrameJob&, const CameraRays&, const RendererOptions&,
                               LinearImage&) const {}
GlDevice::Centres GlDevice::see_centres(const FrameJob&, const CameraRays&) const {
  return {};
}

Mesh read_mesh(const FileName&, double) {
  throw InputError(kMissing);
}
Texture read_texture(const FileName&) {
  throw InputError(kMissing);
}

}  // namespace seam::render
