#include "effects/effect.h"
#include "effects/stages/timing.h"

namespace seam::effects {

EffectDefinition frame_latency() {
  return {
      .name = "frame_latency",
      .stage = Stage::timing,
      .kinds = kPoints | kLandmarks | kRanges | kFrames,
      .parameters = {{.name = "latency_s",
                      .min = -0.2,
                      .max = 0.2,
                      .scale = 5e-3,
                      .help = "True time of a frame minus its stamp, seconds."}},
      .help = "The stamp of a frame is early or late by a constant.",
      .formula = "true time = stamp + latency",
      .signature = "displacement with rate, equal in all rows",
      .example = "frame_latency: {latency_s: 0.012}",
      .advice = {{kPoints,
                  {"exposure"},
                  "Expose for two different known times: only the window's length moves with the "
                  "exposure."}},
      .timing = [](Values p, Timing& timing) { timing.latency_s += p[0]; },
      .proof = {{.values = {0.012},
                 .given = {{"stamp_s", 3}},
                 .expected = {{"start_s", 3.012}},
                 .source = "python: stamp_s + p[0]"},
                {.values = {-0.004},
                 .given = {{"stamp_s", 0.5}, {"row", 20}},
                 .expected = {{"end_s", 0.496}},
                 .source = "python: stamp_s + p[0]"}},
  };
}

}  // namespace seam::effects
