#include "effects/stages/timing.h"

#include <cmath>

namespace seam::effects {

double Timing::in_lock(double since_start, double cycle) const {
  if (sync_period_frames <= 0 || cycle <= 0) return since_start;
  const double slot = cycle / sync_period_frames;
  return std::round(since_start / slot) * slot;
}

double Timing::own_latency_s(RandomStream camera, uint64_t frame) const {
  return jitter_sigma_s > 0 ? jitter_sigma_s * normal(camera.child("frame_jitter"), frame) : 0;
}

Timing timing_of(const Model& model) {
  Timing timing;
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->timing) effect.definition->timing(effect.values(), timing);
  }
  return timing;
}

}  // namespace seam::effects
