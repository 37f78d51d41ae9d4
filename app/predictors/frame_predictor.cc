#include "app/predictors/frame_predictor.h"

#include "render/renderer.h"

namespace seam::app {
namespace {

class RenderedFrames final : public measurement::FramePredictor {
 public:
  RenderedFrames(const effects::Model& model, int width_px, int height_px, SimTime reference,
                 measurement::Detail detail)
      : renderer_(model, width_px, height_px,
                  {.samples_per_pixel = 16,
                   .edge_samples_per_pixel = detail == measurement::Detail::fine ? 512 : 64,
                   .reference = reference}) {}

  std::vector<float> light(const FrameJob& job) const override {
    const render::LinearImage image = renderer_.render_linear(job);
    std::vector<float> light(image.planes[0].size() * 3);
    for (size_t i = 0; i < light.size(); ++i) light[i] = image.planes[i % 3][i / 3];
    return light;
  }

 private:
  render::Renderer renderer_;
};

}  // namespace

measurement::MakeFramePredictor rendered_frames() {
  return [](const effects::Model& model, int width_px, int height_px, SimTime reference,
            measurement::Detail detail) {
    return std::make_unique<RenderedFrames>(model, width_px, height_px, reference, detail);
  };
}

}  // namespace seam::app
