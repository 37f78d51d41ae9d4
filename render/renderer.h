// A camera's frames from scene instants: the whole chain from light to digital numbers.
//
// scene radiance at the sampling instants -> lens (distortion is in the rays) -> integration over
// each row's window -> lamps, blur, gain field, glare (effects/stages/optics.h) -> sensor
// (effects/stages/sensor/sensor.h) -> YCrCb. Bits depend on the job, the model and the image size
// alone: not on threads, the machine's vector width, the compiler or its optimisation.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "effects/model.h"
#include "render/base/linear_image.h"
#include "render/base/renderer_options.h"
#include "sim_core/scene/frame.h"

namespace seam::render {

// What is seen by the ray through each pixel's centre at the middle of its row's window.
struct GroundTruth {
  int width_px = 0;
  int height_px = 0;
  std::vector<uint8_t> label;  // seam::Label.
  std::vector<uint16_t> object_id;
  std::vector<float> depth_m;  // Along the optical axis; infinite where nothing is met.
  // Where the point seen moves in the image from the start of its row's window to the end, pixels
  // (the rolling shutter's own displacement: a point is followed to the row that then shows it).
  std::vector<float> flow_u_px, flow_v_px;
};

// One stage of the chain, for dumps: linear stages are scaled so that 1 is white.
struct StageImage {
  std::string name;
  LinearImage image;
};

// What follows from a frame's size, stamp, rows and rgb: its YCrCb and its fingerprint.
void develop(Frame& frame);

class Renderer {
 public:
  // Throws InputError when the model has no projection or cannot be inverted over the image.
  Renderer(const effects::Model& model, int width_px, int height_px,
           const RendererOptions& options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  int width_px() const;
  int height_px() const;
  const effects::Model& model() const;

  // Each may be called from several threads at once.
  Frame render(const FrameJob& job) const;
  // Noise-free light as it falls on the sensor.
  LinearImage render_linear(const FrameJob& job) const;
  // The light before the optics: the image of an ideal, sharp lens, integrated over row windows.
  LinearImage render_scene(const FrameJob& job) const;
  GroundTruth ground_truth(const FrameJob& job) const;
  // Every stage, first to last; the last but one is the frame as the sensor gives it.
  std::vector<StageImage> stages(const FrameJob& job) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace seam::render
