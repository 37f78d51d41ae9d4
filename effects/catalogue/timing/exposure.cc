#include "effects/effect.h"
#include "effects/stages/timing.h"

namespace seam::effects {

EffectDefinition exposure() {
  return {
      .name = "exposure",
      .stage = Stage::timing,
      .kinds = kPoints | kRanges | kFrames,
      .parameters = {{.name = "exposure_s",
                      .min = 0,
                      .max = 0.1,
                      .scale = 5e-3,
                      .help = "How long each row collects light, seconds."}},
      .help = "Each row integrates light over a window; a moving point is seen at its middle.",
      .formula = "row v integrates over [start, start + exposure]",
      .signature = "blur along the motion; with a known stamp, displacement with rate in every row",
      .example = "exposure: {exposure_s: 0.005}",
      .timing = [](Values p, Timing& timing) { timing.exposure_s += p[0]; },
      .proof = {{.values = {0.005},
                 .given = {{"stamp_s", 1}},
                 .expected = {{"start_s", 1}, {"middle_s", 1.0025}, {"end_s", 1.005}},
                 .source = "python: stamp_s, stamp_s + p[0] / 2, stamp_s + p[0]"},
                {.values = {0.02},
                 .given = {{"stamp_s", 2}, {"row", 10}},
                 .expected = {{"middle_s", 2.01}},
                 .source = "python: stamp_s + p[0] / 2"}},
  };
}

}  // namespace seam::effects
