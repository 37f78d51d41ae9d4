#include "effects/stages/timing.h"

namespace seam::effects {

Timing timing_of(const Model& model) {
  Timing timing;
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->timing) effect.definition->timing(effect.values(), timing);
  }
  return timing;
}

}  // namespace seam::effects
