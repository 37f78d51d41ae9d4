#include "effects/effect.h"
#include "effects/stages/timing.h"

namespace seam::effects {

EffectDefinition frame_jitter() {
  return {
      .name = "frame_jitter",
      .stage = Stage::timing,
      .kinds = kPoints | kLandmarks | kRanges,
      .parameters = {{.name = "sigma_s",
                      .min = 0,
                      .max = 0.5,
                      .scale = 5e-3,
                      .help = "Standard deviation of the latency of each frame, seconds.",
                      .plausible = {0, 0.1,
                                    "stamps that a computer gives come milliseconds late, on a "
                                    "loaded one tens of them"}}},
      .help = "Each frame has a random latency of its own.",
      .formula =
          "true time = stamp + latency, latency normal with this sigma, drawn for each frame",
      .signature = "displacement with rate, one value a frame",
      .example = "frame_jitter: {sigma_s: 0.002}",
      .spread_only = true,
      .timing = [](Values p, Timing& timing) { timing.jitter_sigma_s = p[0]; },
      .proof = {{.values = {0.002},
                 .expected = {{"own_latency_rms_s", 0.002}},
                 .source = "python: p[0]",
                 .tolerance = 0.03},
                {.values = {0.03},
                 .expected = {{"own_latency_rms_s", 0.03}},
                 .source = "python: p[0]",
                 .tolerance = 0.03}},
  };
}

}  // namespace seam::effects
