#include "effects/effect.h"
#include "effects/stages/timing.h"

namespace seam::effects {

EffectDefinition clock_drift() {
  return {
      .name = "clock_drift",
      .stage = Stage::timing,
      .kinds = kPoints | kLandmarks | kRanges | kFrames,
      .parameters = {{.name = "drift_ppm",
                      .min = -200000.0,
                      .max = 200000.0,
                      .scale = 1e3,
                      .help = "How much faster true time runs than the stamps, parts per million.",
                      .plausible = {-50000, 50000,
                                    "quartz keeps 100 ppm, oscillators without one 1 to 5 %"}}},
      .help = "The camera's clock runs at another rate than the reference log's.",
      .formula = "true time = stamp * (1 + drift * 1e-6), from the first time of the reference log",
      .signature = "latency that grows with time",
      .example = "clock_drift: {drift_ppm: 40}",
      .timing = [](Values p, Timing& timing) { timing.drift_ppm += p[0]; },
      .proof = {{.values = {40},
                 .given = {{"stamp_s", 100}},
                 .expected = {{"start_s", 100.004}},
                 .source = "python: stamp_s * (1 + p[0] * 1e-6)"},
                {.values = {-150},
                 .given = {{"stamp_s", 2000}, {"row", 9}},
                 .expected = {{"start_s", 1999.7}},
                 .source = "python: stamp_s * (1 + p[0] * 1e-6)"}},
  };
}

}  // namespace seam::effects
