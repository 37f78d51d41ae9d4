// What kinds of whole images need of a renderer.
#pragma once

#include <functional>
#include <memory>
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

// `reference` is the time from which drift, flicker and formulas of time count. Throws InputError
// for a model that gives no image.
using MakeFramePredictor = std::function<std::unique_ptr<FramePredictor>(
    const effects::Model& model, int width_px, int height_px, SimTime reference, Detail detail)>;

// For a scene whose objects name these files, which are read once. Throws InputError for files that
// cannot be had.
using OpenFrameRenderer = std::function<MakeFramePredictor(const SceneFiles& files)>;

}  // namespace seam::measurement
