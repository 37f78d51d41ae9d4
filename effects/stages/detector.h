// Stage `detector`: range and bearing of a landmark as the robot's own software reports them.
#pragma once

#include <fmt/format.h>

#include "effects/model.h"
#include "effects/not_a_number.h"
#include "effects/row_columns.h"
#include "sim_core/base/random.h"

namespace seam::effects {

struct Detection {
  double range_m = 0;       // True on entry, reported on return.
  double bearing_rad = 0;   // From the camera's axis, left positive.
  double above_m = 0;       // How far the landmark lies above the detector, as far as the set says.
  double x_m = 0, y_m = 0;  // Where the detector is, in the frame of the map.
  // The robot's own, along its heading and to the left; 0 where it stands.
  double speed_mps = 0;
  double turn_radps = 0;
  double t_s = 0;  // Since the set's reference.
  RowColumns columns;
  // Variances that noise effects add to those of the set.
  double range_variance = 0;
  double bearing_variance = 0;
};

// The stream of single ranges' spread, one normal number a range.
inline RandomStream range_noise_stream(RandomStream frame_noise) {
  return frame_noise.child("range_noise");
}

// Applies every detector hook of the model, in order. With `numbers_only`, which is not for fits
// that try what may not work, throws InputError where one gives no number.
inline void apply_detector(const Model& model, Detection& detection, bool numbers_only = false) {
  for (const ModelEffect& effect : model.effects()) {
    if (!effect.definition->detector) continue;
    effect.definition->detector(effect.values(), detection);
    if (!numbers_only) continue;
    for (const auto& [name, value] :
         {std::pair{"range", detection.range_m}, std::pair{"bearing", detection.bearing_rad}}) {
      if (!usable(value))
        fail_with(effect.definition->name, name, value,
                  fmt::format("a landmark at {:.9g} s", detection.t_s));
    }
  }
}

}  // namespace seam::effects
