#include "app/predictors/frame_predictor.h"

#include "app/scene_assets.h"
#include "measurement/imaging/frame_predictor.h"
#include "render/cast/ray_store.h"
#include "render/gl/device.h"
#include "render/renderer.h"

namespace seam::app {
namespace {

using Device = std::shared_ptr<const render::GlDevice>;

class RenderedFrames final : public measurement::FramePredictor {
 public:
  RenderedFrames(const effects::Model& model, int width_px, int height_px, SimTime reference,
                 measurement::Detail detail, Device opengl, std::shared_ptr<render::RayStore> rays)
      : opengl_(std::move(opengl)),
        renderer_(model, width_px, height_px,
                  {.samples_per_pixel = 16,
                   .edge_samples_per_pixel = detail == measurement::Detail::fine ? 512 : 64,
                   .reference = reference,
                   .opengl = opengl_.get(),
                   .ray_store = std::move(rays)}) {}

  std::vector<float> light(const FrameJob& job) const override {
    const render::LinearImage image = renderer_.render_linear(opengl_ ? with_sizes(job) : job);
    std::vector<float> light(image.planes[0].size() * 3);
    for (size_t i = 0; i < light.size(); ++i) light[i] = image.planes[i % 3][i / 3];
    return light;
  }

 private:
  // Meshes have the size that their files say.
  FrameJob with_sizes(FrameJob job) const {
    for (SceneInstant& instant : job.instants) {
      for (Primitive& primitive : instant.primitives) {
        if (primitive.shape == Shape::mesh)
          primitive.size = Vec3(opengl_->assets().meshes[primitive.asset - 1].radius_m);
      }
    }
    return job;
  }

  Device opengl_;
  render::Renderer renderer_;
};

Device device_of(const SceneFiles& files) {
  if (files.empty()) return nullptr;
  return std::make_shared<const render::GlDevice>(read_assets(files));
}

}  // namespace

measurement::OpenFrameRenderer rendered_frames() {
  return [](const SceneFiles& files) {
    return [opengl = device_of(files), rays = std::make_shared<render::RayStore>()](
               const effects::Model& model, int width_px, int height_px, SimTime reference,
               measurement::Detail detail) {
      return std::make_unique<RenderedFrames>(model, width_px, height_px, reference, detail, opengl,
                                              rays);
    };
  };
}

}  // namespace seam::app
