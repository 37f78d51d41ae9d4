// What kinds of whole images need of a renderer.
#pragma once

#include <vector>

#include "effects/model.h"
#include "sim_core/scene/frame.h"
#include "sim_core/scene/scene_file.h"

namespace seam::measurement {

class FramePredictor {
 public:
  virtual ~FramePredictor() = default;
  // Noise-free linear light on the sensor, row-major, red, green and blue interleaved. May be
  // called from several threads at once.
  virtual std::vector<float> light(const FrameJob& job) const = 0;
};

// How many rays an edge is drawn with: `rough` images cost a third, and do to tell large changes
// apart.
enum class Detail { fine, rough };

}  // namespace seam::measurement
