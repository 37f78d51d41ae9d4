// Stage `detector`: range and bearing of a landmark as the robot's own software reports them.
#pragma once

#include "effects/model.h"

namespace seam::effects {

struct Detection {
  double range_m = 0;      // True on entry, reported on return.
  double bearing_rad = 0;  // From the camera's axis, left positive.
  double t_s = 0;          // Since the set's reference.
  // Variances that noise effects add to those of the set.
  double range_variance = 0;
  double bearing_variance = 0;
};

// The stream of single ranges' spread, one normal number a range.
inline RandomStream range_noise_stream(RandomStream frame_noise) {
  return frame_noise.child("range_noise");
}

// Applies every detector hook of the model, in order.
inline void apply_detector(const Model& model, Detection& detection) {
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->detector) effect.definition->detector(effect.values(), detection);
  }
}

}  // namespace seam::effects
