// In place of the OpenGL renderer where the build left it out.
#include "render/gl/device.h"

#include <fmt/format.h>

#include "sim_core/base/error.h"

namespace seam::render {

namespace {

constexpr const char* kMissing =
    "this build has none; install libosmesa6-dev and libassimp-dev and build with -DSEAM_OPENGL=ON";

[[noreturn]] void refuse(const FileName& file) {
  throw InputError(
      fmt::format("{}: only renderer 'opengl' draws meshes and pictures: {}", file.name, kMissing));
}

}  // namespace

struct GlDevice::Impl {
  std::string nothing;
  Assets none;
};

GlDevice::GlDevice(Assets, const std::string&, Gathering) {
  throw InputError(fmt::format(
      "renderer 'opengl': {}, or take --renderer analytic for scenes of shapes", kMissing));
}
GlDevice::~GlDevice() = default;
bool opengl_is_here(const std::string&) {
  return false;
}

std::string GlDevice::source() const {
  return {};
}
const std::string& GlDevice::version() const {
  return impl_->nothing;
}
const std::string& GlDevice::renderer() const {
  return impl_->nothing;
}
const Assets& GlDevice::assets() const {
  return impl_->none;
}
void GlDevice::integrate_light(const FrameJob&, const CameraRays&, const RendererOptions&,
                               LinearImage&) const {}
GlDevice::Centres GlDevice::see_centres(const FrameJob&, const CameraRays&) const {
  return {};
}

bool reads_assets() {
  return false;
}
Mesh AssetFiles::mesh(const FileName& file, double) {
  refuse(file);
}
Texture AssetFiles::texture(const FileName& file) {
  refuse(file);
}

}  // namespace seam::render
